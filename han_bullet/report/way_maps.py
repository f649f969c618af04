"""Maps with ways as plain SVG, written letter by letter: a sweep has thousands, and charts would take minutes."""

from __future__ import annotations

import html
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from han_bullet.geometry import Array, SolidBox
from han_bullet.report.charts import GREY
from han_bullet.topdown import extent, footprint, plan_colours
from han_bullet.world_schema import World

FLOOR = "#fbfbf8"
TOLERANCE = 2.0  # [cm] by which a drawn way may be beside the true one
MARGIN = 20.0  # [cm] around everything
LETTERS = 40.0  # [cm]
TICK = 5.0  # [m] between the figures along the walls
WIDTH = 620  # [px], where the page does not say another


@dataclass(frozen=True)
class Stroke:
    """A way, or a part of one.

    Attributes:
        places: Shape (n, 2) [m].
        colour: As CSS has it.
        width: Of the line [cm].
        dot: Radius of a dot at the way's beginning, where it is negative at its end, or 0 for none [cm].
        opacity: 0 to 1.
        dashed: Whether the line is.
    """

    places: Array
    colour: str
    width: float
    dot: float = 0.0
    opacity: float = 1.0
    dashed: bool = False


def draw_way_map(world: World | None, strokes: Sequence[Stroke], *, lettered: bool = True) -> bytes:
    """Return a map as an SVG file, the same bytes every time.

    Args:
        world: The building; None: only the ways, as they lie to one another.
        strokes: The ways, the uppermost last.
        lettered: Whether the map has figures at its edges, and names beside furniture.
    """
    low, high = (100.0 * np.array(corner) for corner in (extent(world) if world is not None else _around(strokes)))
    left, top = low[0] - MARGIN, -high[1] - MARGIN  # y grows downwards
    size = high - low + 2.0 * MARGIN + (1.5 * LETTERS if lettered else 0.0) * np.array([0.0, 1.0])
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{WIDTH * size[1] / size[0]:.0f}" '
        f'viewBox="{left:.0f} {top:.0f} {size[0]:.0f} {size[1]:.0f}" '
        f'font-family="DejaVu Sans, sans-serif" font-size="{LETTERS:.0f}" fill="none" stroke-linejoin="round">'
    ]
    if world is not None:
        parts += _building(world, lettered)
    for stroke in strokes:
        parts += _drawn(stroke)
    if lettered:
        parts += _figures(low, high)
    return "".join([*parts, "</svg>"]).encode()


def _around(strokes: Sequence[Stroke]) -> tuple[Array, Array]:
    """Return the corners of what the ways cover [m]."""
    places = np.vstack([stroke.places for stroke in strokes])
    return places.min(axis=0) - 0.5, places.max(axis=0) + 0.5


def _building(world: World, named: bool) -> Iterator[str]:
    for area in world.floor:
        corners = np.array([[area.x[i], area.y[j]] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))])
        yield f'<path d="{_line(corners)}z" fill="{FLOOR}"/>'
    for box in world.solid_boxes():
        fill, rim = plan_colours(box, world)
        yield f'<path d="{_line(footprint(box))}z" fill="{_hex(fill)}" stroke="{_hex(rim)}" stroke-width="2"/>'
        if named and box.kind != "wall":
            yield _name(box)
    x, y = _pixel(np.array(world.task.place))
    radius = 100.0 * world.robot.radius
    yield f'<circle cx="{x}" cy="{y}" r="{radius:.0f}" stroke="{GREY}" stroke-width="4" stroke-dasharray="12 8"/>'


def _name(box: SolidBox) -> str:
    corners = footprint(box)
    x, y = _pixel(np.array([corners[:, 0].min(), corners[:, 1].max()]))
    return f'<text x="{x}" y="{y - 8}" fill="{GREY}">{html.escape(box.name)}</text>'


def _figures(low: Array, high: Array) -> Iterator[str]:
    """Write x [m] along the lower edge, given the corners [cm]."""
    numbers = TICK * np.arange(math.ceil(0.01 * low[0] / TICK), math.floor(0.01 * high[0] / TICK) + 1)
    for number in numbers.tolist():
        words = f"x = {number:g} m" if number == numbers[-1] else f"{number:g}"
        place = f'x="{100.0 * number:.0f}" y="{-low[1] + MARGIN + LETTERS:.0f}"'
        yield f'<text {place} fill="{GREY}" text-anchor="middle">{words}</text>'


def _drawn(stroke: Stroke) -> Iterator[str]:
    points = (100.0 * stroke.places).astype(np.float32)
    simple = 0.01 * cv2.approxPolyDP(points[:, None], TOLERANCE, False)[:, 0].astype(np.float64)
    dashes = ' stroke-dasharray="24 9"' if stroke.dashed else ""
    seen = f' opacity="{stroke.opacity:g}"' if stroke.opacity < 1.0 else ""
    yield f'<path d="{_line(simple)}" stroke="{stroke.colour}" stroke-width="{stroke.width:g}"{dashes}{seen}/>'
    if stroke.dot:
        x, y = _pixel(stroke.places[0 if stroke.dot > 0.0 else -1])
        yield f'<circle cx="{x}" cy="{y}" r="{abs(stroke.dot):g}" fill="{stroke.colour}"{seen}/>'


def _line(places: Array) -> str:
    """Return a line as SVG has it, relative to its beginning, in whole centimetres."""
    whole = np.rint(100.0 * places * [1.0, -1.0]).astype(int)
    steps = "".join(f" {x},{y}" for x, y in np.diff(whole, axis=0))
    return f"M{whole[0, 0]},{whole[0, 1]}" + (f"l{steps[1:]}" if steps else "l0,0")


def _pixel(place: Array) -> tuple[int, int]:
    return round(100.0 * float(place[0])), round(-100.0 * float(place[1]))


def _hex(colour: tuple[int, int, int]) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)
