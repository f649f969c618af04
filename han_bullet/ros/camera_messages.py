"""Cameras as ROS messages: the image, the image with what was found in it, and the calibration."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from han_bullet.annotated import annotate
from han_bullet.geometry import Intrinsics
from han_bullet.messages import CameraImage, Detections
from han_bullet.ros.frames import optical_frame
from han_bullet.ros.message_types import header, make


def image_message(image: CameraImage, pixels: NDArray[np.uint8] | None = None) -> Any:
    """Return a sensor_msgs/Image, rgb8, of an image or of other pixels in its place.

    Its data is a view of the pixels, not a copy. An observation's images are arrays of its own, which nobody writes to
    once the observation is there, so the message is good for as long as anyone keeps it.
    """
    shown = image.image if pixels is None else pixels
    height, width = shown.shape[:2]
    return make(
        "sensor_msgs/Image",
        header=header(image.time, optical_frame(image.camera)),
        height=height,
        width=width,
        encoding="rgb8",
        step=3 * width,
        data=np.ascontiguousarray(shown).reshape(-1),
    )


def image_with_boxes(image: CameraImage, found: Detections) -> Any:
    """Return a sensor_msgs/Image with boxes and scores drawn into a copy."""
    return image_message(image, annotate(image.image, found))


def calibration_message(intrinsics: Intrinsics, camera: str, time: float) -> Any:
    """Return a sensor_msgs/CameraInfo of a camera without distortion.

    The middle of the first pixel is (0, 0) on ROS and (0.5, 0.5) in `Intrinsics`, so the principal point differs by
    half a pixel: both find a point of the world in the same pixel.
    """
    fx, fy, cx, cy = intrinsics.fx, intrinsics.fy, intrinsics.cx - 0.5, intrinsics.cy - 0.5
    return make(
        "sensor_msgs/CameraInfo",
        header=header(time, optical_frame(camera)),
        height=intrinsics.height,
        width=intrinsics.width,
        distortion_model="plumb_bob",
        D=np.zeros(5),
        K=np.array([fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]),
        R=np.eye(3).ravel(),
        P=np.array([fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]),
    )
