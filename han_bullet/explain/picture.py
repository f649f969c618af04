"""The moment of an explanation from above: the way, and beside it the ways without each layer that moves it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from han_bullet import drawing
from han_bullet.atomic_file import write_at_once
from han_bullet.explain.explanation import Explanation
from han_bullet.explain.replay import Replay
from han_bullet.explain.sentences import movers, verdict
from han_bullet.geometry import Array, arc_lengths, points_at
from han_bullet.lettering import Colour, Lettering, Picture
from han_bullet.topdown import INK, OUTSIDE, PATH, TopDownView

WIDTH, MAP_HEIGHT = 1920, 592  # [px]
ROW, MARGIN, LETTERS = 26, 16, 15  # of the text below the map [px]
SAMPLE = 34  # [px] of a way's colour in the legend
DASH = 12.0  # [px] of a dashed line, and between two
CROSS = 6.0  # [px], half the extent
# Of the ways without a layer, the strongest first: apart from blue ways, green tracks and the costs' warm colours.
COLOURS: tuple[Colour, ...] = (
    (208, 0, 168),
    (0, 150, 160),
    (120, 60, 0),
    (90, 90, 90),
    (120, 0, 220),
    (150, 150, 0),
    (0, 90, 0),
    (60, 0, 60),
)


def draw(replayed: Replay, explanation: Explanation, path: Path) -> None:
    """Write the picture of an explanation.

    Args:
        replayed: Behind the explanation.
        explanation: What to show.
        path: Ending in .png; an older file is replaced.
    """
    picture = paint(replayed, explanation)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_at_once(path, cv2.imencode(".png", picture[..., ::-1])[1].tobytes())


def paint(replayed: Replay, explanation: Explanation) -> Picture:
    """Return the picture, RGB, shape (height, width, 3)."""
    way = explanation.way
    effects = [effect for effect in movers(way) if effect.way is not None][: len(COLOURS)]
    colours = {effect.layer: colour for effect, colour in zip(effects, COLOURS, strict=False)}
    lines: list[tuple[str, Colour | None]] = [
        (f"{explanation.world}, seed {explanation.seed}, {explanation.time:.2f} s: {'; '.join(verdict(way))}", None),
        ("best way of this moment; without a break: the way that the robot is on", PATH),
        *((f"best way without {layer}", colour) for layer, colour in colours.items()),
    ]
    if any(box.measured is None for box in explanation.detections):
        lines.append(("x: foot point of a box that gave no measurement", None))
    picture = np.full((MAP_HEIGHT + (len(lines) + 1) * ROW, WIDTH, 3), OUTSIDE, np.uint8)
    lettering = Lettering()
    view = TopDownView(replayed.run.world, (WIDTH, MAP_HEIGHT), lettering)
    tick = replayed.tick
    devices = tuple((device.name, device.on) for device in tick.decision.scene.devices)
    drawn = replace(tick, truth=replace(tick.truth, devices_on=devices))
    measurements = [look.scan.positions for look in replayed.looks.values()]
    view.draw(picture[:MAP_HEIGHT], drawn, measurements)
    for points, colour in [(way.best, PATH), *((effect.way, colours[effect.layer]) for effect in effects)]:
        if points is not None:
            _dashed(picture[:MAP_HEIGHT], view.pixels(points), colour)
    for box in explanation.detections:
        if box.measured is None:
            _cross(picture[:MAP_HEIGHT], view.pixels(np.array(box.foot_point)))
    _write(picture[MAP_HEIGHT:], lettering, lines)
    return picture


def _dashed(picture: Picture, places: Array, colour: Colour) -> None:
    """Draw a dashed line, so that of two ways on one another both can be seen."""
    arcs = arc_lengths(places)
    for start in np.arange(0.0, arcs[-1], 2.0 * DASH):
        drawing.line(picture, points_at(start + DASH * np.array([0.0, 0.5, 1.0]), places, arcs), colour, 3)


def _cross(picture: Picture, place: Array) -> None:
    for turn in (1.0, -1.0):
        arm = CROSS * np.array([1.0, turn])
        drawing.line(picture, np.array([place - arm, place + arm]), INK, 2)


def _write(picture: Picture, lettering: Lettering, lines: Sequence[tuple[str, Colour | None]]) -> None:
    """Write lines below one another, each behind a sample of its way's colour."""
    for number, (text, colour) in enumerate(lines):
        row = ROW * (number + 1)
        if colour is not None:
            _dashed(picture, np.array([[MARGIN, row], [MARGIN + SAMPLE, row]], float), colour)
        left = MARGIN if colour is None else MARGIN + SAMPLE + MARGIN
        lettering.write(picture, text, (left, row), LETTERS, INK, bold=number == 0)
