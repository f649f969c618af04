"""What was found in single frames, and how old a frame is when a command heeds it."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from han_bullet.episode import Tick
from han_bullet.geometry import Array
from han_bullet.messages import CameraImage
from han_bullet.metrics.perceived import MATCH_WITHIN, distances_between, match
from han_bullet.metrics.tally import Definition, Definitions, Value
from han_bullet.tracking.field_of_view import SMALLEST, FieldOfView


class Visibility:
    """Tell whom frames show, and remember of each camera the newest.

    Args:
        view: Tells which floor points a frame sees a whole person at.
    """

    def __init__(self, view: FieldOfView) -> None:
        self._view = view
        self._newest: dict[str, NDArray[np.bool_]] = {}

    def look(self, tick: Tick, true_positions: Array) -> list[NDArray[np.bool_]]:
        """Return for each frame of a tick whom it shows, shape (people,)."""
        images = tick.observation.images
        masks = [self._shown(image, tick, true_positions) for image in images]
        self._newest |= {image.camera: mask for image, mask in zip(images, masks, strict=True)}
        return masks

    def _shown(self, image: CameraImage, tick: Tick, places: Array) -> NDArray[np.bool_]:
        frame = image.placed(tick.truth.pose_robot_in_world)
        shown = self._view.sees(frame, places, robot=tick.truth.pose_robot_in_world)
        if len(places) > 1 and shown.any():
            shown &= ~self._view.hidden_by_people(frame, places, places)
        return shown

    def newest(self, people: int) -> NDArray[np.bool_]:
        """Return whom the newest frame of some camera shows, shape (people,)."""
        shown = np.zeros(people, bool)
        for mask in self._newest.values():
            shown |= mask
        return shown

    @property
    def with_cameras(self) -> bool:
        """Tell whether a frame has come."""
        return bool(self._newest)


class FrameTally:
    """What was found in the frames.

    Args:
        people: Names, for metrics that exist also where nothing was recorded.
    """

    definitions: ClassVar[Definitions] = {
        "detections_per_frame": Definition("1", "mean number of boxes that the detector kept in a camera frame"),
        "false_detections_per_frame": Definition(
            "1",
            f"mean number per camera frame of foot points farther than {MATCH_WITHIN:g} m from every true person's "
            "centre",
            "lower",
        ),
        "detection_recall": Definition(
            "1",
            "share of the pairs of a camera frame and a true person whom it shows in which that person was found "
            "(behind a dot, of that person alone). Shown: whole in the image as somebody standing there, "
            f"{SMALLEST:g} px tall, hidden by no wall, furniture, robot or other person. Found: paired with a foot "
            f"point of that frame within {MATCH_WITHIN:g} m of their centre, as many pairs as can be; none if no frame "
            "showed anybody",
            "higher",
            headline=True,
        ),
        "frame_age_mean": Definition(
            "s",
            "mean over ticks of the simulation time from the exposure of the newest camera frame to the command that "
            "heeds it, from the first frame on; the command then holds for a tick; none without frames",
            "lower",
            "latency from camera to cmd_vel; of the wall clock only `timings` in result.json tell",
        ),
        "frame_age_max": Definition("s", "the largest of the same times", "lower"),
    }

    def __init__(self, people: Sequence[str]) -> None:
        self._frames = 0
        self._detections = 0
        self._false_detections = 0
        self._shown = Counter(dict.fromkeys(people, 0))
        self._found = Counter(dict.fromkeys(people, 0))
        self._exposure = -math.inf  # of the newest frame [s]
        self._ages: list[float] = []  # [s]

    def record(self, tick: Tick, true_positions: Array, shown: Sequence[NDArray[np.bool_]]) -> None:
        """Take note of one tick; `shown` has for each frame a mask of the people, shape (m,)."""
        self._frames += len(tick.decision.detections)
        self._detections += sum(len(found.boxes) for found in tick.decision.detections)
        for scan in tick.decision.scans:
            nearest = distances_between(scan.positions, true_positions).min(axis=1, initial=math.inf)
            self._false_detections += int((nearest > MATCH_WITHIN).sum())
        points = {scan.camera: scan.positions for scan in tick.decision.scans}
        for image, mask in zip(tick.observation.images, shown, strict=True):
            if mask.any():
                self._count_found(tick, mask, points.get(image.camera, np.zeros((0, 2))), true_positions)
        self._exposure = max((image.time for image in tick.observation.images), default=self._exposure)
        if math.isfinite(self._exposure):
            self._ages.append(tick.decision.time - self._exposure)

    def _count_found(self, tick: Tick, shown: NDArray[np.bool_], points: Array, true_positions: Array) -> None:
        found = {person for _, person in match(points, true_positions)}
        for index in map(int, np.flatnonzero(shown)):
            name = tick.truth.people[index].name
            self._shown[name] += 1
            self._found[name] += index in found

    def values(self) -> dict[str, Value]:
        """Return counts per frame, shares and ages."""
        values: dict[str, Value] = {
            "detections_per_frame": _share(self._detections, self._frames),
            "false_detections_per_frame": _share(self._false_detections, self._frames),
            "detection_recall": _share(self._found.total(), self._shown.total()),
            "frame_age_mean": float(np.mean(self._ages)) if self._ages else None,
            "frame_age_max": max(self._ages, default=None),
        }
        return values | {f"detection_recall.{name}": _share(self._found[name], n) for name, n in self._shown.items()}


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None
