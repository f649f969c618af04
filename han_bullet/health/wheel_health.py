"""Whether the wheels slip more than they should: odometry against localization."""

from __future__ import annotations

import math
from collections import deque
from itertools import pairwise

from han_bullet.geometry import Pose2D, wrap_angle
from han_bullet.health.watch import Watch
from han_bullet.messages import Fault, PoseEstimate
from han_bullet.world_schema import CONTROL_PERIOD, Slip

PIECE = 1.0  # [s] of way that are compared
PIECES = 4  # whose errors are added: slip is random, and one piece tells little
# Of what localization itself errs by over a piece, standard deviations [m], [rad].
POSITION_ERROR, YAW_ERROR = 0.015, 0.006
# Squared, normalized errors of all pieces: 12 on average for the usual slip, at most 32 in twelve runs. Five times the
# usual is noticed after 2.6 s in the median, in nine of ten runs within 8 s.
TOO_MUCH = 50.0
PIECE_TICKS = round(PIECE / CONTROL_PERIOD)
SLIPS_FOR = 0.5  # [s]


class WheelHealth:
    """Compare the way of the last seconds as odometry and as localization have it.

    Args:
        slip: The usual one.
    """

    def __init__(self, slip: Slip) -> None:
        self._slip = slip
        self._ways: deque[tuple[Pose2D, Pose2D]] = deque(maxlen=PIECES * PIECE_TICKS + 1)
        self._watch = Watch("wheels", "slip", SLIPS_FOR)

    @property
    def faults(self) -> tuple[Fault, ...]:
        """Return what is wrong now."""
        return () if self._watch.fault is None else (self._watch.fault,)

    def update(self, estimate: PoseEstimate, pose_robot_in_odom: Pose2D) -> None:
        """Take in both poses of a tick; those of a lost robot say nothing, nor does the leap with which it is found."""
        if estimate.lost:
            self._ways.clear()
        else:
            self._ways.append((estimate.pose_robot_in_world, pose_robot_in_odom))
        self._watch.update(self._normalized_error() > TOO_MUCH, estimate.time)

    def _normalized_error(self) -> float:
        """Return the squared differences of the ways, piece by piece, in standard deviations."""
        ways = list(self._ways)[::-PIECE_TICKS]
        return sum(self._error_of_piece(*piece) for piece in pairwise(reversed(ways)))

    def _error_of_piece(self, start: tuple[Pose2D, Pose2D], end: tuple[Pose2D, Pose2D]) -> float:
        way, told = start[0].relative(end[0]), start[1].relative(end[1])
        length = math.hypot(told.x, told.y)
        ahead = (self._slip.distance * length) ** 2 + POSITION_ERROR**2
        wander = self._slip.heading**2 * length  # of the heading [rad^2]
        aside = ahead + wander * length**2 / 3.0
        turned = wander + (self._slip.turn * told.yaw) ** 2 + YAW_ERROR**2
        off = (way.x - told.x) ** 2 + (way.y - told.y) ** 2
        return off / aside + wrap_angle(way.yaw - told.yaw) ** 2 / turned
