"""Where the robot was a moment ago: an image comes a little after it was exposed."""

from __future__ import annotations

from bisect import bisect_left

from han_bullet.geometry import Pose2D, wrap_angle
from han_bullet.messages import PoseEstimate

REMEMBERED = 2.0  # [s]


class PoseTrail:
    """The estimates of the last two seconds."""

    def __init__(self) -> None:
        self._estimates: list[PoseEstimate] = []

    def add(self, estimate: PoseEstimate) -> None:
        """Take in the estimate of a tick; they come in the order of time."""
        first = bisect_left(self._estimates, estimate.time - REMEMBERED, key=_time)
        self._estimates = [*self._estimates[first:], estimate]

    def pose_at(self, time: float) -> Pose2D:
        """Return the pose at a time [s], as if the robot had moved straight between two ticks.

        Before the first remembered tick it is that one's pose, after the last one that one's.
        """
        after = bisect_left(self._estimates, time, key=_time)
        if after == len(self._estimates) or after == 0:
            return self._estimates[min(after, len(self._estimates) - 1)].pose_robot_in_world
        one, two = self._estimates[after - 1], self._estimates[after]
        share = (time - one.time) / (two.time - one.time)
        if share == 1.0:  # at a tick, which is the rule: to the last bit
            return two.pose_robot_in_world
        start, end = one.pose_robot_in_world, two.pose_robot_in_world
        x, y = start.position + share * (end.position - start.position)
        return Pose2D(float(x), float(y), start.yaw + share * wrap_angle(end.yaw - start.yaw))


def _time(estimate: PoseEstimate) -> float:
    return estimate.time
