"""What stands around the map in a video: title bar, legend, and the row of camera images with their detections."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np

from han_bullet import drawing
from han_bullet.costmap.grid import SOCIAL_MAX
from han_bullet.episode import Tick
from han_bullet.geometry import Array
from han_bullet.lettering import Colour, Lettering, Picture
from han_bullet.messages import CameraImage, Detections, Fault, RecoveryStep, Status
from han_bullet.stack import Decision
from han_bullet.topdown import GOAL, INK, LASER, PALE, PATH, ROBOT, TRACK, TRAJECTORY, cost_colours
from han_bullet.world_schema import World

BAR: Colour = (28, 34, 46)
LEGEND: Colour = (241, 243, 246)
GREY: Colour = (150, 160, 176)
FAULT: Colour = (255, 176, 60)
NO_IMAGE: Colour = (44, 51, 66)
BOX: Colour = (60, 220, 110)  # of a kept detection; brighter than the tracks, since it lies on photographs
STATUS_COLOURS: dict[Status, Colour] = {
    Status.MOVING: (44, 110, 226),
    Status.WAITING: (206, 120, 20),
    Status.YIELDING: (206, 120, 20),
    Status.LOOKING: (206, 120, 20),
    Status.ARRIVED: (20, 140, 90),
    Status.LOST: (196, 40, 60),
    Status.BLOCKED: (196, 40, 60),
    Status.PROTECTIVE_STOP: (196, 40, 60),
    Status.BLIND: (196, 40, 60),
    Status.TELEOPERATED: (124, 70, 190),
    Status.IDLE: (110, 118, 132),
}
NAME_SIZE, VALUE_SIZE, LABEL_SIZE, SMALL_SIZE, TINY_SIZE = 22, 18, 14, 13, 12  # [px]
FIELD_WIDTH = 168  # [px] of a figure in the title bar
COST_BAR_WIDTH = 150  # [px]
PAD = 16  # [px]
BELOW_NAME = 36.0  # [px]: scores of boxes at the image's upper border stay readable under the camera's name
LEGEND_ITEMS = (
    ("robot", ROBOT, "disc"),
    ("driven", TRAJECTORY, "line"),
    ("planned", PATH, "line"),
    ("goal", GOAL, "ring"),
    ("true person", INK, "ring"),
    ("track: 1 sigma, place in 1 s", TRACK, "arrow"),
    ("measured foot point", TRACK, "dot"),
    ("laser", LASER, "dot"),
)


class TitleBar:
    """Tell world, status and the figures so far.

    Args:
        world: Its name and description are the title.
        size: Width and height [px].
        lettering: For the text.
    """

    def __init__(self, world: World, size: tuple[int, int], lettering: Lettering) -> None:
        self._lettering = lettering
        self._name_end = 2 * PAD + lettering.width(world.name, NAME_SIZE, bold=True)
        self._room = size[0] - self._name_end - 5 * FIELD_WIDTH
        self._ground = np.full((size[1], size[0], 3), BAR, np.uint8)
        self._closest: tuple[float, str] = (math.inf, "")
        middle = size[1] / 2
        lettering.write(self._ground, world.name, (PAD, middle), NAME_SIZE, PALE, bold=True)
        description = lettering.shorten(world.description, 14, self._room)
        lettering.write(self._ground, description, (self._name_end, middle), 14, GREY)

    def record(self, tick: Tick) -> None:
        """Take in the figures of a tick, drawn or not."""
        robot = tick.truth.pose_robot_in_world.position
        for person in tick.truth.people:
            self._closest = min(self._closest, (person.pose_in_world.distance_to(robot), person.name))

    def draw(self, picture: Picture, tick: Tick) -> None:
        """Paint the bar over a picture of its size."""
        picture[:] = self._ground
        distance, name = self._closest
        fields = (
            ("time", f"{tick.truth.time:.2f} s"),
            ("speed", f"{tick.truth.twist_robot_in_body.speed:.2f} m/s"),
            (f"closest so far: {name}" if name else "closest so far", f"{distance:.2f} m" if name else "nobody"),
        )
        right = picture.shape[1] - PAD
        for caption, value in reversed(fields):
            self._lettering.write(picture, caption, (right - FIELD_WIDTH, 15), TINY_SIZE, GREY)
            self._lettering.write(picture, value, (right - FIELD_WIDTH, 35), VALUE_SIZE, PALE, bold=True)
            right -= FIELD_WIDTH
        self._draw_faults(picture, tick.decision.faults)
        self._draw_status(picture, tick.decision, right - 2 * PAD)

    def _draw_faults(self, picture: Picture, faults: Sequence[Fault]) -> None:
        """Tell what the robot knows to be wrong with its sensors, in place of the description."""
        if not faults:
            return
        start, middle = int(self._name_end), picture.shape[0] / 2
        picture[:, start : start + int(self._room)] = BAR
        text = "faults noticed: " + ", ".join(f"{fault.sensor} {fault.kind}" for fault in faults)
        self._lettering.write(picture, self._lettering.shorten(text, 14, self._room), (start, middle), 14, FAULT)

    def _draw_status(self, picture: Picture, decision: Decision, right: float) -> None:
        """Draw the status, or what is tried beyond waiting, in a rounded box that ends at a column [px]."""
        status, step = decision.status, decision.step
        text = status.value if step in (None, RecoveryStep.WAIT) else f"cannot go on: {step.value}"
        half, middle = 15.0, picture.shape[0] / 2
        left = right - 2 * half - self._lettering.width(text, VALUE_SIZE - 2, bold=True)
        drawing.line(picture, np.array([[left + half, middle], [right - half, middle]]), STATUS_COLOURS[status], 30)
        self._lettering.write(picture, text, (left + half, middle), VALUE_SIZE - 2, PALE, bold=True)


def draw_legend(size: tuple[int, int], lettering: Lettering, pixels_per_metre: float) -> Picture:
    """Return the legend with scale bar, RGB, for a size (width, height) [px]."""
    picture = np.full((size[1], size[0], 3), LEGEND, np.uint8)
    left, middle = float(PAD), size[1] / 2
    for name, colour, kind in LEGEND_ITEMS:
        _draw_symbol(picture, np.array([left + 13.0, middle]), colour, kind)
        lettering.write(picture, name, (left + 34, middle), SMALL_SIZE, INK)
        left += 34 + lettering.width(name, SMALL_SIZE) + 28
    bar = cost_colours()[256 : 257 + SOCIAL_MAX]
    rows, columns = slice(int(middle) - 6, int(middle) + 6), slice(int(left), int(left) + COST_BAR_WIDTH)
    picture[rows, columns] = cv2.resize(bar[None], (COST_BAR_WIDTH, 12))
    lettering.write(picture, "social cost, 0 to 1", (columns.stop + 10, middle), SMALL_SIZE, INK)
    ends = np.array([[size[0] - PAD - pixels_per_metre, middle], [size[0] - PAD, middle]])
    drawing.line(picture, ends, INK, 2)
    for end in ends:
        drawing.line(picture, end + np.array([[0.0, -5.0], [0.0, 5.0]]), INK, 2)
    lettering.write(picture, "1 m", (ends[0, 0] - 8, middle), SMALL_SIZE, INK, anchor="right")
    return picture


def _draw_symbol(picture: Picture, centre: Array, colour: Colour, kind: str) -> None:
    """Draw a sample of what the map shows, 26 px wide at most."""
    if kind == "line":
        drawing.line(picture, centre + np.array([[-13.0, 0.0], [13.0, 0.0]]), colour, 3)
    elif kind == "arrow":
        drawing.disc(picture, centre - [6.0, 0.0], 7.0, PALE, colour)
        drawing.arrow(picture, centre - [6.0, 0.0], centre - [-13.0, 0.0], colour, 2)
    elif kind == "ring":
        drawing.disc(picture, centre, 9.0, PALE, colour)
    else:
        drawing.disc(picture, centre, {"disc": 10.0, "dot": 3.5}[kind], colour)


class CameraStrip:
    """Show the last image of each camera in a row, with the boxes found in it.

    Args:
        cameras: Names, from left to right; at least one.
        picture: Where to paint, RGB, shape (height, width, 3).
        lettering: For names and scores.
    """

    def __init__(self, cameras: Sequence[str], picture: Picture, lettering: Lettering) -> None:
        self._lettering = lettering
        height, room = picture.shape[:2]
        width = min(room // len(cameras), height * 4 // 3)
        start = (room - width * len(cameras)) // 2
        self._panels = {name: picture[:, start + i * width :][:, :width] for i, name in enumerate(cameras)}
        self._blank = np.full((height, width, 3), NO_IMAGE, np.uint8)
        picture[:] = BAR
        for name, panel in self._panels.items():
            panel[:] = self._blank
            self._finish(name)

    def record(self, tick: Tick) -> None:
        """Paint the images of a tick, with grey boxes where they are not used, and what is wrong with their cameras."""
        used = {(scan.camera, scan.time) for scan in tick.decision.scans}
        for frame, detections in zip(tick.observation.images, tick.decision.detections, strict=True):
            if frame.camera in self._panels:
                colour = BOX if (frame.camera, frame.time) in used else GREY
                self._paint(self._panels[frame.camera], frame, detections, colour)
                self._finish(frame.camera)
        for name in self._panels:
            kinds = [fault.kind for fault in tick.decision.faults if fault.sensor == name]
            if kinds:
                text, place = ", ".join(kinds), (12, 36)
                self._lettering.write(self._panels[name], text, place, LABEL_SIZE, FAULT, bold=True, halo=BAR)

    def _paint(self, panel: Picture, frame: CameraImage, detections: Detections, colour: Colour) -> None:
        """Paint an image as large as fits without stretching it, with boxes, scores and probabilities."""
        available, full = np.array(panel.shape[1::-1]), np.array(frame.image.shape[1::-1])
        scale = float(np.min(available / full))
        width, height = np.rint(full * scale).astype(int).tolist()
        left, top = ((available - (width, height)) // 2).tolist()
        panel[:] = self._blank
        panel[top : top + height, left : left + width] = cv2.resize(frame.image, (width, height))
        for (x, y, w, h), score, probability in zip(
            detections.boxes, detections.scores, detections.probabilities, strict=True
        ):
            corners = scale * np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h]]) + (left, top)
            drawing.line(panel, corners, colour, 2, closed=True)
            text, place = f"{score:.0f} · {probability:.2f}", (corners[0, 0], max(corners[0, 1] - 9.0, BELOW_NAME))
            self._lettering.write(panel, text, place, TINY_SIZE, colour, bold=True, halo=BAR)

    def _finish(self, name: str) -> None:
        """Write a camera's name onto its panel and draw a thin frame around it."""
        panel = self._panels[name]
        self._lettering.write(panel, name, (12, 18), LABEL_SIZE, PALE, bold=True, halo=BAR)
        panel[[0, -1]] = panel[:, [0, -1]] = BAR
