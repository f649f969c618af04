"""Errors of the believed pose, worked out by hand."""

import math

import pytest
from ticks import tick

from han_bullet.metrics.localization import LocalizationTally


def test_errors_are_between_believed_and_true_pose_with_the_shorter_turn() -> None:
    tally = LocalizationTally()
    tally.record(tick(0, robot=(1.0, 2.0, 3.1), believed=(1.03, 2.04, -3.1)))
    tally.record(tick(1, robot=(1.0, 2.0, 0.0), believed=(1.0, 2.0, 0.0), lost=True))
    values = tally.values()
    assert values["robot_position_rmse"] == pytest.approx(0.05 / math.sqrt(2.0))
    assert values["robot_position_error_max"] == pytest.approx(0.05)
    assert values["robot_yaw_rmse"] == pytest.approx((2.0 * math.pi - 6.2) / math.sqrt(2.0))
    assert values["lost_time"] == pytest.approx(0.05)


def test_who_is_told_the_true_pose_errs_by_nothing() -> None:
    tally = LocalizationTally()
    tally.record(tick(0, robot=(1.0, 2.0, 0.5)))
    assert set(tally.values().values()) == {0.0}
