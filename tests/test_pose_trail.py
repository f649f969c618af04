"""Where the robot was a moment ago, and images placed there."""

import math

import numpy as np
import pytest

from han_bullet.geometry import Pose2D, camera_on_robot
from han_bullet.localization.pose_trail import PoseTrail
from han_bullet.messages import CameraImage, PoseEstimate
from han_bullet.world_schema import CONTROL_PERIOD, OnboardCamera


def driven(ticks: int) -> tuple[PoseTrail, list[Pose2D]]:
    trail = PoseTrail()
    poses = [Pose2D(0.1 * k, 0.02 * k * k, 3.0 + 0.05 * k) for k in range(ticks)]
    for k, pose in enumerate(poses):
        trail.add(PoseEstimate(k * CONTROL_PERIOD, pose))
    return trail, poses


def test_a_pose_at_a_tick_is_that_of_the_tick_to_the_last_bit() -> None:
    trail, poses = driven(30)
    for k in (0, 7, 29):
        assert trail.pose_at(k * CONTROL_PERIOD) == poses[k]


def test_between_ticks_the_robot_moved_straight_and_turned_the_shorter_way() -> None:
    trail = PoseTrail()
    trail.add(PoseEstimate(1.0, Pose2D(0.0, 0.0, math.pi - 0.1)))
    trail.add(PoseEstimate(1.05, Pose2D(1.0, 2.0, 0.1 - math.pi)))
    between = trail.pose_at(1.025)
    assert (between.x, between.y) == pytest.approx((0.5, 1.0))
    assert between.yaw == pytest.approx(math.pi)


def test_poses_are_remembered_for_two_seconds_and_the_last_one_stands_for_later_times() -> None:
    trail, poses = driven(100)
    assert trail.pose_at(9.0) == poses[-1]
    assert trail.pose_at(3.0) == poses[60]
    assert trail.pose_at(2.0) == poses[59]  # forgotten: the oldest that is known


def test_an_onboard_image_is_placed_where_the_robot_was_and_a_fixed_one_where_it_hangs() -> None:
    camera = OnboardCamera(name="onboard", height=1.1, forward=0.2, pitch_down=0.1)
    pose = Pose2D(3.0, -1.0, 2.0)
    pixels = np.zeros((4, 4, 3), np.uint8)
    moving = CameraImage("onboard", 0.0, pixels, camera.intrinsics, camera.mount, False).placed(pose)
    assert moving.camera_in_world == pytest.approx(camera_on_robot(pose, 0.2, 1.1, 0.1), abs=1e-12)
    still = CameraImage("ceiling", 0.0, pixels, camera.intrinsics, camera.mount, True).placed(pose)
    assert np.array_equal(still.camera_in_world, camera.mount)
