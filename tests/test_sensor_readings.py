"""Sensors' messages as the values of the loop; and the refusals, each with its reason."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from han_bullet.errors import BadInputError
from han_bullet.geometry import Intrinsics, Pose2D, Twist2D
from han_bullet.messages import LaserScan, Odometry
from han_bullet.ros.camera_messages import image_message
from han_bullet.ros.message_types import deserialize, header, make, serialize
from han_bullet.ros.robot_messages import odometry_message, scan_message
from han_bullet.ros.sensor_readings import read_image, read_odometry, read_scan
from han_bullet.world_schema import Slip

LENS = Intrinsics(6, 4, 5.0, 5.0, 3.0, 2.0)
PIXELS = np.random.default_rng(0).integers(0, 256, (4, 6, 3), np.uint8)


def image(encoding: str, data: np.ndarray[Any, Any], step: int, width: int = 6, height: int = 4) -> Any:
    fields = {"header": header(1.0, "c"), "encoding": encoding, "width": width, "height": height, "step": step}
    return make("sensor_msgs/Image", **fields, data=np.ascontiguousarray(data, np.uint8).reshape(-1))


@pytest.mark.parametrize("encoding", ["rgb8", "bgr8", "8UC3"])
def test_an_image_in_colour_comes_out_red_green_blue_whatever_its_order(encoding: str) -> None:
    sent = PIXELS if encoding == "rgb8" else PIXELS[..., ::-1]
    read = read_image(image(encoding, sent, 18), LENS)
    np.testing.assert_array_equal(read, PIXELS)
    assert read.flags.c_contiguous and read.dtype == np.uint8


def test_a_grey_image_has_its_level_in_all_three_colours() -> None:
    read = read_image(image("mono8", PIXELS[..., 0], 6), LENS)
    np.testing.assert_array_equal(read, np.repeat(PIXELS[..., :1], 3, axis=2))


def test_what_fills_up_the_rows_of_an_image_is_left_out() -> None:
    padded = np.full((4, 20), 99, np.uint8)
    padded[:, :18] = PIXELS.reshape(4, 18)
    np.testing.assert_array_equal(read_image(image("rgb8", padded, 20), LENS), PIXELS)


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (image("yuv422", PIXELS, 18), "encoding is 'yuv422'; one of rgb8, bgr8, 8UC3, mono8"),
        (image("rgb8", PIXELS, 18, width=4, height=6), "image is 4 x 6 px; 6 x 4, as calibrated"),
        (image("rgb8", PIXELS[:3], 18), "54 bytes in rows of 18; 4 rows of 18"),
        (image("rgb8", PIXELS, 12), "72 bytes in rows of 12; 4 rows of 18"),
    ],
)
def test_an_image_that_is_not_the_cameras_is_refused(message: Any, reason: str) -> None:
    with pytest.raises(BadInputError, match=reason):
        read_image(message, LENS)


def test_odometry_that_was_sent_by_the_simulator_is_read_as_it_was() -> None:
    odometry = Odometry(3.0, Pose2D(1.5, -2.5, 2.9), Twist2D(0.4, -0.1, 0.2))
    raw = serialize(odometry_message(odometry, Slip()))
    read = read_odometry(deserialize("nav_msgs/Odometry", raw), 3.0)
    assert read.twist_robot_in_body == odometry.twist_robot_in_body
    assert (read.pose_robot_in_odom.x, read.pose_robot_in_odom.y) == (1.5, -2.5)
    assert read.pose_robot_in_odom.yaw == pytest.approx(2.9)


def test_odometry_with_what_is_no_number_or_no_turn_is_refused() -> None:
    good = odometry_message(Odometry(0.0, Pose2D(0.0, 0.0, 0.0), Twist2D()), Slip())
    good.pose.pose.position.x = math.nan
    with pytest.raises(BadInputError, match="odometry is nan"):
        read_odometry(good, 0.0)
    good.pose.pose.orientation.w = 0.0
    with pytest.raises(BadInputError, match="of length 0; 1 would be right"):
        read_odometry(good, 0.0)


def scan(**fields: Any) -> Any:
    usual = {"angle_min": -1.0, "angle_increment": 0.5, "range_min": 0.1, "range_max": 8.0}
    ranges = np.array([1.0, 2.0, 3.0, 4.0, 5.0], np.float32)
    return make("sensor_msgs/LaserScan", **({"header": header(0.0, "laser"), "ranges": ranges} | usual | fields))


def test_a_scan_that_was_sent_by_the_simulator_is_read_as_it_was() -> None:
    mount = Pose2D(0.2, 0.0, 0.0)
    sent = LaserScan(1.0, np.array([1.0, np.inf, 2.5]), -0.5, 0.5, 0.0, 8.0, mount)
    read = read_scan(deserialize("sensor_msgs/LaserScan", serialize(scan_message(sent, 0.1))), 1.0, mount)
    np.testing.assert_array_equal(read.ranges, sent.ranges)
    assert (read.angle_min, read.angle_increment, read.scanner_in_body) == (-0.5, 0.5, mount)


def test_ranges_that_say_nothing_are_infinite_and_what_is_too_near_is_at_the_least_range() -> None:
    ranges = np.array([np.nan, np.inf, -np.inf, 0.0, 9.0], np.float32)
    read = read_scan(scan(ranges=ranges), 0.0, Pose2D(0.0, 0.0, 0.0))
    np.testing.assert_allclose(read.ranges, [np.inf, np.inf, 0.1, np.inf, np.inf])


def test_a_scanner_that_turns_clockwise_is_read_counter_clockwise() -> None:
    read = read_scan(scan(angle_min=1.0, angle_increment=-0.5), 0.0, Pose2D(0.0, 0.0, 0.0))
    np.testing.assert_allclose(read.ranges, [5.0, 4.0, 3.0, 2.0, 1.0])
    np.testing.assert_allclose(read.angles, [-1.0, -0.5, 0.0, 0.5, 1.0])


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"angle_increment": 0.0}, "5 rays from -1 rad on, 0 rad apart"),
        ({"angle_min": math.nan}, "from nan rad on"),
        ({"ranges": np.zeros(1, np.float32)}, "scan has 1 rays"),
        ({"range_max": 0.0}, "ranges go from 0.1 to 0 m"),
    ],
)
def test_a_scan_of_no_scanner_is_refused(fields: dict[str, Any], reason: str) -> None:
    with pytest.raises(BadInputError, match=reason):
        read_scan(scan(**fields), 0.0, Pose2D(0.0, 0.0, 0.0))


def test_an_image_of_the_loop_survives_the_way_there_and_back() -> None:
    from han_bullet.messages import CameraImage

    sent = CameraImage("c", 1.0, PIXELS, LENS, np.eye(4), fixed=True)
    raw = serialize(image_message(sent))
    np.testing.assert_array_equal(read_image(deserialize("sensor_msgs/Image", raw), LENS), PIXELS)
