"""The robot itself as ROS messages."""

import math

import numpy as np
import pytest

from han_bullet.geometry import Pose2D, Twist2D, moved
from han_bullet.mecanum import WHEELS, MecanumWheels
from han_bullet.messages import LaserScan, Odometry, PoseEstimate
from han_bullet.ros.message_types import serialize
from han_bullet.ros.robot_messages import Footprint, Joints, estimate_message, odometry_message, scan_message
from han_bullet.world_schema import CONTROL_PERIOD, Slip

GEOMETRY = MecanumWheels(0.075, 0.165, 0.195)


def test_the_twist_of_odometry_is_in_the_child_frame_and_its_pose_in_odom() -> None:
    """A robot that looks along +y and drives forward: in odom it moves along y, in base_link along x."""
    twist = Twist2D(0.5, 0.1, 0.2)
    before = Odometry(1.0, Pose2D(2.0, 3.0, math.pi / 2), twist)
    message = odometry_message(before, Slip())
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_link")
    linear = message.twist.twist.linear
    assert (linear.x, linear.y, message.twist.twist.angular.z) == (0.5, 0.1, 0.2)
    after = odometry_message(Odometry(1.001, moved(before.pose_robot_in_odom, twist, 0.001), twist), Slip())
    step = (after.pose.pose.position.x - 2.0) / 0.001, (after.pose.pose.position.y - 3.0) / 0.001
    assert step == pytest.approx((-0.1, 0.5), abs=1e-3)


def test_covariances_of_x_y_and_yaw_stand_where_ros_has_them() -> None:
    covariance = np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 5.0], [3.0, 5.0, 6.0]])
    message = estimate_message(PoseEstimate(1.0, Pose2D(1.0, 2.0, 0.0), covariance))
    whole = message.pose.covariance.reshape(6, 6)
    assert whole[0, 0] == 1.0 and whole[0, 1] == 2.0 and whole[0, 5] == 3.0
    assert whole[1, 1] == 4.0 and whole[5, 1] == 5.0 and whole[5, 5] == 6.0
    assert np.count_nonzero(whole) == 9 and message.header.frame_id == "map"


def test_more_slip_and_more_speed_make_the_twist_less_certain() -> None:
    fast = odometry_message(Odometry(0.0, Pose2D(0, 0, 0), Twist2D(1.0, 0.0, 0.0)), Slip(distance=0.1)).twist.covariance
    still = odometry_message(Odometry(0.0, Pose2D(0, 0, 0), Twist2D()), Slip(distance=0.1)).twist.covariance
    assert fast[0] - still[0] == pytest.approx(0.01) and still[0] > 0.0


def test_a_scan_keeps_its_rays_and_says_inf_where_there_is_nothing() -> None:
    scan = LaserScan(2.0, np.array([1.0, np.inf, 3.0]), -0.5, 0.5, 0.05, 8.0, Pose2D(0.2, 0.0, 0.0))
    message = scan_message(scan, 0.1)
    assert message.ranges.tolist() == [1.0, np.inf, 3.0] and message.ranges.dtype == np.float32
    assert (message.angle_min, message.angle_max, message.range_max) == (-0.5, 0.5, 8.0)
    assert message.header.frame_id == "laser" and message.header.stamp.sec == 2
    assert len(serialize(message))


def test_the_footprint_is_a_circle_about_the_robot_on_the_map() -> None:
    message = Footprint(0.3).at(Pose2D(5.0, -1.0, 0.7), 1.0)
    corners = np.array([[p.x, p.y, p.z] for p in message.polygon.points])
    np.testing.assert_allclose(np.hypot(corners[:, 0] - 5.0, corners[:, 1] + 1.0), 0.3)
    assert message.header.frame_id == "map" and len(corners) > 11


def test_wheels_turn_by_the_way_over_their_radius() -> None:
    joints = Joints(GEOMETRY)
    for k in range(20):  # a second at 0.15 m/s
        joints.advance(Odometry(k * CONTROL_PERIOD, Pose2D(0, 0, 0), Twist2D(0.15, 0.0, 0.0)))
    assert joints.angles == pytest.approx([2.0] * 4)
    message = joints.message(1.0)
    assert message.name == ["head_pan", *WHEELS]
    np.testing.assert_allclose(message.position, [0.0, *[2.0] * 4])
    np.testing.assert_allclose(message.velocity, [0.0, *[2.0] * 4])


def test_wheels_stay_within_a_turn_and_do_not_jump_when_time_is_set_back() -> None:
    joints = Joints(GEOMETRY)
    for time in (0.0, 100.0, 50.0):
        joints.advance(Odometry(time, Pose2D(0, 0, 0), Twist2D(1.0, 0.0, 0.0)))
    turned = (CONTROL_PERIOD + 100.0) / 0.075
    assert joints.angles == pytest.approx([math.remainder(turned, 2.0 * math.pi)] * 4)
