"""What a loop owes to safety that is slower than the control period: it drives more slowly and reckons with it."""

from __future__ import annotations

from collections import deque

from han_bullet.stack import NavigationStack
from han_bullet.world_schema import CONTROL_PERIOD, Robot

LOOK_BACK = 20  # ticks, of whose gaps the longest counts
LONGEST = 0.5  # [s]: after a longer gap the robot stands anyway
FARTHEST, FARTHEST_TURN = 0.1, 0.15  # between two ticks [m], [rad]: no limit up to twice the control period


class SlowLoop:
    """Fit a stack's limits to how far apart its ticks really are.

    Follower and protective stop count on a tick per control period. On a machine, or with an odometry, that is slower,
    the follower would brake too slowly and the robot swing about its goal.

    Args:
        stack: To fit.
        robot: Its limits.
    """

    def __init__(self, stack: NavigationStack, robot: Robot) -> None:
        self._stack, self._robot = stack, robot
        self._reaction = stack.protective_stop.reaction - CONTROL_PERIOD
        self._gaps: deque[float] = deque([CONTROL_PERIOD], maxlen=LOOK_BACK)

    def note(self, gap: float) -> None:
        """Take note of the time between two ticks [s]."""
        gap = min(max(gap, CONTROL_PERIOD), LONGEST)
        self._gaps.append(gap)
        longest, follower, stop = max(self._gaps), self._stack.follower, self._stack.protective_stop
        follower.control_period = stop.control_period = gap
        follower.max_speed = min(self._robot.max_speed, FARTHEST / longest)
        follower.max_yaw_rate = min(self._robot.max_yaw_rate, FARTHEST_TURN / longest)
        stop.reaction = self._reaction + longest
