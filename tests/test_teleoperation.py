"""How long a command of somebody who drives counts."""

import math

import pytest

from han_bullet.control.teleoperation import HOLD, Teleoperation
from han_bullet.errors import BadInputError
from han_bullet.geometry import Twist2D

FORWARD, LEFT = Twist2D(0.5, 0.0, 0.0), Twist2D(0.0, 0.5, 0.0)


def test_a_command_counts_for_its_hold_after_the_next_tick_and_then_nobody_drives() -> None:
    driver = Teleoperation()
    assert driver.at(0.0) is None
    driver.take(FORWARD)
    assert [driver.at(time) for time in (3.0, 3.0 + HOLD)] == [FORWARD, FORWARD]
    assert driver.active and driver.at(3.05 + HOLD) is None and not driver.active


def test_a_command_without_hold_counts_for_one_tick() -> None:
    driver = Teleoperation()
    driver.take(FORWARD, hold=0.0)
    assert [driver.at(time) for time in (3.0, 3.05)] == [FORWARD, None]


def test_a_new_command_replaces_the_old_one_and_its_time() -> None:
    driver = Teleoperation()
    driver.take(FORWARD, hold=0.2)
    assert driver.at(1.0) == FORWARD
    driver.take(LEFT, hold=0.2)
    assert [driver.at(time) for time in (1.15, 1.35, 1.4)] == [LEFT, LEFT, None]


@pytest.mark.parametrize("command", [Twist2D(math.nan, 0.0, 0.0), Twist2D(0.0, math.inf, 0.0), Twist2D(0, 0, math.nan)])
def test_a_command_that_is_no_number_is_refused_and_the_one_before_counts(command: Twist2D) -> None:
    driver = Teleoperation()
    driver.take(FORWARD)
    with pytest.raises(BadInputError, match="command to drive"):
        driver.take(command)
    assert driver.at(0.0) == FORWARD


@pytest.mark.parametrize("hold", [-0.1, math.nan, math.inf])
def test_a_hold_that_is_no_time_is_refused(hold: float) -> None:
    with pytest.raises(BadInputError, match="hold of a command"):
        Teleoperation().take(FORWARD, hold)
