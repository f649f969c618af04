"""The one port by which a pose of the robot enters the stack."""

from __future__ import annotations

from abc import ABC, abstractmethod
from bisect import bisect_left

from han_bullet.geometry import Pose2D, wrap_angle
from han_bullet.messages import LaserScan, Odometry, PoseEstimate

REMEMBERED = 2.0  # [s] for which earlier poses are known: an image may come that late


class Localization(ABC):
    """Say where the robot is, and where it was a moment ago.

    Attributes:
        name: Stands in the results, so that nobody takes one kind of localization for another.
    """

    name: str

    def __init__(self) -> None:
        self._trail: list[PoseEstimate] = []

    @abstractmethod
    def locate(self, odometry: Odometry, laser: LaserScan | None) -> PoseEstimate:
        """Return the pose at the time of the odometry; called at every control tick, in the order of time."""

    def update(self, odometry: Odometry, laser: LaserScan | None) -> PoseEstimate:
        """Take in the senses of one control tick and return the pose at its time."""
        estimate = self.locate(odometry, laser)
        first = bisect_left(self._trail, estimate.time - REMEMBERED, key=_time)
        self._trail = [*self._trail[first:], estimate]
        return estimate

    def pose_at(self, time: float) -> Pose2D:
        """Return where the robot was at a time [s], in between as if it had moved straight; the last pose later on."""
        after = bisect_left(self._trail, time, key=_time)
        if after == len(self._trail) or after == 0:
            return self._trail[min(after, len(self._trail) - 1)].pose_robot_in_world
        one, two = self._trail[after - 1], self._trail[after]
        share = (time - one.time) / (two.time - one.time)
        if share == 1.0:  # at a tick, which is the rule: to the last bit
            return two.pose_robot_in_world
        start, end = one.pose_robot_in_world, two.pose_robot_in_world
        x, y = start.position + share * (end.position - start.position)
        return Pose2D(float(x), float(y), start.yaw + share * wrap_angle(end.yaw - start.yaw))


def _time(estimate: PoseEstimate) -> float:
    return estimate.time
