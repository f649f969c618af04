"""The named ablations: the simulator's people instead of detector and tracker, its robot instead of localization."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from han_bullet.detection.camera_detector import FrameDetector
from han_bullet.localization.localizer import Localization
from han_bullet.messages import (
    Detections,
    Frame,
    FrameDetections,
    LaserScan,
    LegScan,
    Odometry,
    PoseEstimate,
    Posture,
    Scan,
    TrackedPerson,
    Truth,
)
from han_bullet.tracking.tracker import PeopleTracker

CERTAIN = np.diag([1e-6, 1e-6, 1e-6, 1e-6])  # [m^2], [m^2/s^2]: the layers take sigma from here


class NoDetector(FrameDetector):
    """Find nobody."""

    def detect(self, frames: Sequence[Frame]) -> list[FrameDetections]:
        """Return empty detections, one per frame."""
        return [Detections.none().at(frame.camera, frame.time) for frame in frames]


class TrueLocalization(Localization):
    """Give the true pose of the robot.

    Args:
        truth: Returns the simulator's truth as of now.
    """

    name = "simulator"

    def __init__(self, truth: Callable[[], Truth]) -> None:
        self._truth = truth

    def update(self, odometry: Odometry, scan: LaserScan | None) -> PoseEstimate:
        """Return the true pose; what is sensed plays no part."""
        return PoseEstimate(odometry.time, self._truth().pose_robot_in_world)

    def relocalize(self) -> None:
        """Do nothing: the pose is always known."""


class TruthTracker(PeopleTracker):
    """Give the true people as tracks; ids follow the world file's order.

    Args:
        truth: Returns the simulator's truth as of now.
        seat_names: Name of the sitting area of each person who sits, by the person's name.
    """

    def __init__(self, truth: Callable[[], Truth], seat_names: dict[str, str] | None = None) -> None:
        self._truth = truth
        self._seat_names = seat_names or {}

    def update(
        self, scans: Sequence[Scan], time: float, blind: Sequence[Frame] = (), legs: LegScan | None = None
    ) -> tuple[TrackedPerson, ...]:
        """Return everybody as they are."""
        return tuple(
            TrackedPerson(
                id=index,
                time=time,
                position_in_world=person.pose_in_world.position,
                velocity_in_world=person.velocity_in_world,
                covariance=CERTAIN,
                posture=person.posture,
                heading=person.pose_in_world.yaw,
                seat=self._seat_names.get(person.name) if person.posture is Posture.SEATED else None,
            )
            for index, person in enumerate(self._truth().people)
        )
