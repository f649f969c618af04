"""A loop that is slower than the control period drives by how slow it is."""

from types import SimpleNamespace
from typing import Any

import pytest

from han_bullet.control.protective_stop import ProtectiveStop
from han_bullet.ros.slow_loop import FARTHEST, FARTHEST_TURN, LONGEST, LOOK_BACK, SlowLoop
from han_bullet.world_schema import CONTROL_PERIOD, Robot

ROBOT = Robot(start=(0.0, 0.0, 0.0))


@pytest.fixture
def stack() -> Any:
    limits = {"max_speed": ROBOT.max_speed, "max_yaw_rate": ROBOT.max_yaw_rate, "control_period": CONTROL_PERIOD}
    return SimpleNamespace(follower=SimpleNamespace(**limits), protective_stop=ProtectiveStop())


def limits(stack: Any) -> tuple[float, float, float, float]:
    follower = stack.follower
    assert stack.protective_stop.control_period == follower.control_period
    return follower.control_period, follower.max_speed, follower.max_yaw_rate, stack.protective_stop.reaction


def test_up_to_twice_the_control_period_the_robots_own_limits_hold(stack: Any) -> None:
    loop = SlowLoop(stack, ROBOT)
    for gap in (0.0, 0.05, 0.1):
        loop.note(gap)
        period = max(gap, CONTROL_PERIOD)
        assert limits(stack) == pytest.approx((period, ROBOT.max_speed, ROBOT.max_yaw_rate, 0.1 + period))


def test_beyond_it_the_robot_goes_no_farther_between_two_ticks_and_reckons_with_the_longest(stack: Any) -> None:
    loop = SlowLoop(stack, ROBOT)
    loop.note(0.4)
    assert limits(stack) == pytest.approx((0.4, FARTHEST / 0.4, FARTHEST_TURN / 0.4, 0.5))
    loop.note(0.05)
    assert limits(stack) == pytest.approx((0.05, FARTHEST / 0.4, FARTHEST_TURN / 0.4, 0.5))


def test_a_slow_moment_is_forgotten_and_a_pause_counts_no_more_than_half_a_second(stack: Any) -> None:
    loop = SlowLoop(stack, ROBOT)
    loop.note(30.0)
    assert limits(stack)[1] == pytest.approx(FARTHEST / LONGEST)
    for _ in range(LOOK_BACK):
        loop.note(CONTROL_PERIOD)
    assert limits(stack) == pytest.approx((CONTROL_PERIOD, ROBOT.max_speed, ROBOT.max_yaw_rate, 0.1 + CONTROL_PERIOD))
