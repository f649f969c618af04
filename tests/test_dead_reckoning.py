"""Localization by odometry alone."""

import numpy as np
import pytest

from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.localization.dead_reckoning import AT_START, DeadReckoning
from han_bullet.localization.odometry_model import OdometryModel
from han_bullet.messages import Odometry


def odometry(time: float, x: float, y: float, yaw: float) -> Odometry:
    return Odometry(time, Pose2D(x, y, yaw), Twist2D())


def test_the_start_in_the_world_is_moved_by_what_odometry_tells_since_its_first() -> None:
    localization = DeadReckoning(Pose2D(2.0, 1.0, np.pi / 2), OdometryModel())
    first = localization.update(odometry(0.0, 5.0, 5.0, 0.0), None)  # an odom frame that began elsewhere
    assert first.pose_robot_in_world == Pose2D(2.0, 1.0, pytest.approx(np.pi / 2))
    moved = localization.update(odometry(0.1, 6.0, 5.5, 0.3), None)
    pose = moved.pose_robot_in_world
    assert (pose.x, pose.y) == (pytest.approx(1.5), pytest.approx(2.0))
    assert pose.yaw == pytest.approx(np.pi / 2 + 0.3)
    assert moved.time == 0.1 and not moved.lost


def test_its_covariance_grows_with_the_way_and_is_never_mended() -> None:
    localization = DeadReckoning(Pose2D(0.0, 0.0, 0.0), OdometryModel())
    variances = []
    for step in range(11):
        estimate = localization.update(odometry(0.1 * step, 1.0 * step, 0.0, 0.0), None)
        variances.append(np.diag(estimate.covariance))
    np.testing.assert_allclose(variances[0], np.diag(AT_START), rtol=1e-6)
    assert (np.diff(variances, axis=0)[:, [0, 1, 2]] > 0.0).all()
    before = localization.update(odometry(2.0, 10.0, 0.0, 0.0), None)
    localization.relocalize()
    after = localization.update(odometry(2.1, 10.0, 0.0, 0.0), None)
    assert after.pose_robot_in_world == before.pose_robot_in_world
