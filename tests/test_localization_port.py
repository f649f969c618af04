"""The port: where the robot is, and where it was a moment ago."""

import math

import numpy as np
import pytest

from han_bullet.geometry import Pose2D, Twist2D, camera_on_robot
from han_bullet.localization.localization import Localization
from han_bullet.messages import CameraImage, LaserScan, Odometry, PoseEstimate
from han_bullet.world_schema import CONTROL_PERIOD, OnboardCamera


class Believed(Localization):
    """Takes the odometry for the pose."""

    name = "believed"

    def locate(self, odometry: Odometry, laser: LaserScan | None) -> PoseEstimate:
        return PoseEstimate(odometry.time, odometry.pose_robot_in_odom)


def driven(ticks: int) -> tuple[Believed, list[Pose2D]]:
    localization = Believed()
    poses = [Pose2D(0.1 * k, 0.02 * k * k, 3.0 + 0.05 * k) for k in range(ticks)]
    for k, pose in enumerate(poses):
        localization.update(Odometry(k * CONTROL_PERIOD, pose, Twist2D()), None)
    return localization, poses


def test_a_pose_at_a_tick_is_that_of_the_tick_to_the_last_bit() -> None:
    localization, poses = driven(30)
    for k in (0, 7, 29):
        assert localization.pose_at(k * CONTROL_PERIOD) == poses[k]


def test_between_ticks_the_robot_moved_straight_and_turned_the_shorter_way() -> None:
    localization = Believed()
    localization.update(Odometry(1.0, Pose2D(0.0, 0.0, math.pi - 0.1), Twist2D()), None)
    localization.update(Odometry(1.05, Pose2D(1.0, 2.0, 0.1 - math.pi), Twist2D()), None)
    between = localization.pose_at(1.025)
    assert (between.x, between.y) == pytest.approx((0.5, 1.0))
    assert between.yaw == pytest.approx(math.pi)


def test_poses_are_remembered_for_two_seconds_and_the_last_one_stands_for_later_times() -> None:
    localization, poses = driven(100)
    assert localization.pose_at(9.0) == poses[-1]
    assert localization.pose_at(3.0) == poses[60]
    assert localization.pose_at(2.0) == poses[59]  # forgotten: the oldest that is known


def test_an_onboard_image_is_placed_where_the_robot_was_and_a_fixed_one_where_it_hangs() -> None:
    camera = OnboardCamera(name="onboard", height=1.1, forward=0.2, pitch_down=0.1)
    pose = Pose2D(3.0, -1.0, 2.0)
    pixels = np.zeros((4, 4, 3), np.uint8)
    moving = CameraImage("onboard", 0.0, pixels, camera.intrinsics, camera.mount, False).placed(pose)
    assert moving.camera_in_world == pytest.approx(camera_on_robot(pose, 0.2, 1.1, 0.1), abs=1e-12)
    still = CameraImage("ceiling", 0.0, pixels, camera.intrinsics, camera.mount, True).placed(pose)
    assert np.array_equal(still.camera_in_world, camera.mount)
