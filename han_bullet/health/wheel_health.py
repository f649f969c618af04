"""Whether the wheels slip more than they should: odometry against localization."""

from __future__ import annotations

from collections import deque

import numpy as np

from han_bullet.geometry import Array, Pose2D, wrap_angle
from han_bullet.health.watch import Watch
from han_bullet.messages import Fault
from han_bullet.world_schema import CONTROL_PERIOD, Slip

LOOK_BACK = 2.0  # [s] of way that are compared
# Of what localization itself errs by over that way, standard deviations [m], [rad].
POSITION_ERROR, YAW_ERROR = 0.03, 0.02
# Squared, normalized errors of three numbers are 3 on average and above this once in 1e3. Slip is random, and five
# times the usual is noticed after 3 s in the median, in nine of ten runs within 8 s.
TOO_MUCH = 16.0
SLIPS_FOR = 0.5  # [s]


class WheelHealth:
    """Compare the way of the last seconds as odometry and as localization have it.

    Args:
        slip: The usual one.
    """

    def __init__(self, slip: Slip) -> None:
        self._slip = slip
        self._ways: deque[tuple[Pose2D, Pose2D]] = deque(maxlen=round(LOOK_BACK / CONTROL_PERIOD) + 1)
        self._watch = Watch("wheels", "slip", SLIPS_FOR)

    @property
    def faults(self) -> tuple[Fault, ...]:
        """Return what is wrong now."""
        return () if self._watch.fault is None else (self._watch.fault,)

    def update(self, pose_robot_in_world: Pose2D, pose_robot_in_odom: Pose2D, time: float) -> None:
        """Take in both poses of a tick."""
        self._ways.append((pose_robot_in_world, pose_robot_in_odom))
        self._watch.update(self._normalized_error() > TOO_MUCH, time)

    def _normalized_error(self) -> float:
        """Return the squared difference of the two ways in standard deviations."""
        (world, odom), (world_now, odom_now) = self._ways[0], self._ways[-1]
        way, told = _from(world, world_now), _from(odom, odom_now)
        length = float(np.hypot(told[0], told[1]))
        ahead = (self._slip.distance * length) ** 2 + POSITION_ERROR**2
        wander = self._slip.heading**2 * length  # of the heading [rad^2]
        aside = ahead + wander * length**2 / 3.0
        turned = wander + (self._slip.turn * told[2]) ** 2 + YAW_ERROR**2
        error = way - told
        error[2] = wrap_angle(float(error[2]))
        return float(np.sum(error**2 / [aside, aside, turned]))


def _from(before: Pose2D, after: Pose2D) -> Array:
    """Return the way from one pose to another as the first has it: x, y, yaw, shape (3,) [m], [rad]."""
    x, y = before.to_body(after.position)
    return np.array([x, y, wrap_angle(after.yaw - before.yaw)])
