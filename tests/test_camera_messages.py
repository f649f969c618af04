"""Cameras as ROS messages."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.annotated import annotate
from han_bullet.geometry import Intrinsics, project
from han_bullet.messages import CameraImage, Detections
from han_bullet.ros.camera_messages import calibration_message, image_message, image_with_boxes
from han_bullet.ros.message_types import deserialize, serialize

INTRINSICS = Intrinsics(64, 48, 50.0, 55.0, 31.0, 25.5)


def taken(pixels: np.ndarray) -> CameraImage:
    return CameraImage("hall", 1.5, pixels, INTRINSICS, np.eye(4), True)


def colours() -> np.ndarray:
    return np.random.default_rng(0).integers(0, 256, (48, 64, 3), dtype=np.uint8)


def test_an_image_comes_back_from_the_wire_pixel_by_pixel() -> None:
    pixels = colours()
    message = image_message(taken(pixels))
    assert message.data.ndim == 1 and message.data.dtype == np.uint8
    back = deserialize("sensor_msgs/Image", bytes(serialize(message)))
    np.testing.assert_array_equal(np.frombuffer(back.data, np.uint8).reshape(back.height, back.width, 3), pixels)
    assert (back.encoding, back.step, back.header.frame_id) == ("rgb8", 192, "hall_optical_frame")
    assert (back.header.stamp.sec, back.header.stamp.nanosec) == (1, 500_000_000)


def test_an_image_is_not_copied_unless_its_rows_are_apart() -> None:
    pixels = colours()
    assert np.shares_memory(image_message(taken(pixels)).data, pixels)
    part = pixels[:, ::2]
    np.testing.assert_array_equal(image_message(taken(part)).data, part.reshape(-1))


def test_boxes_are_drawn_into_a_copy() -> None:
    pixels = colours()
    before = pixels.copy()
    found = Detections(np.array([[10.0, 8.0, 20.0, 30.0]]), np.array([3.0]), np.array([0.9]))
    shown = image_with_boxes(taken(pixels), found).data.reshape(pixels.shape)
    np.testing.assert_array_equal(shown, annotate(before, found))
    np.testing.assert_array_equal(pixels, before)
    assert (shown != before).any()


@given(st.floats(-2, 2), st.floats(-2, 2), st.floats(0.5, 20))
def test_camera_info_finds_a_point_in_the_same_pixel_as_the_intrinsics(x: float, y: float, z: float) -> None:
    (u, v), _ = project(np.array([x, y, z]), INTRINSICS, np.eye(4))
    message = calibration_message(INTRINSICS, "hall", 0.0)
    across, down, depth = message.P.reshape(3, 4) @ [x, y, z, 1.0]
    # The middle of the first pixel is (0, 0) on ROS and (0.5, 0.5) here.
    assert (across / depth + 0.5, down / depth + 0.5) == pytest.approx((u, v), abs=1e-9)
    np.testing.assert_array_equal(message.K.reshape(3, 3), message.P.reshape(3, 4)[:, :3])


def test_camera_info_has_no_distortion_and_the_size_of_the_image() -> None:
    message = calibration_message(INTRINSICS, "hall", 0.0)
    assert (message.width, message.height, message.distortion_model) == (64, 48, "plumb_bob")
    assert message.D.tolist() == [0.0] * 5 and message.R.tolist() == np.eye(3).ravel().tolist()
    assert message.header.frame_id == "hall_optical_frame" and len(serialize(message))
