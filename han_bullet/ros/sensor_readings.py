"""What sensors say on ROS, as the values of the loop; what cannot be used is refused with the reason."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from han_bullet.errors import BadInputError
from han_bullet.geometry import Intrinsics, Pose2D, Twist2D
from han_bullet.messages import LaserScan, Odometry
from han_bullet.ros.placing import yaw_of

# Channels, and their order that gives red, green, blue. 8UC3 is what programs with OpenCV send, in whose order it is.
ENCODINGS = {"rgb8": (3, (0, 1, 2)), "bgr8": (3, (2, 1, 0)), "8UC3": (3, (2, 1, 0)), "mono8": (1, (0, 0, 0))}
MOST_RAYS = 100_000


def read_image(message: Any, intrinsics: Intrinsics) -> NDArray[np.uint8]:
    """Return the pixels of a sensor_msgs/Image, shape (height, width, 3), RGB.

    Args:
        message: Of one of ENCODINGS.
        intrinsics: Of the camera that it should be of.

    Raises:
        BadInputError: Another encoding, not the camera's size, or fewer bytes than it says.
    """
    if message.encoding not in ENCODINGS:
        raise BadInputError(f"encoding is {message.encoding!r}; one of {', '.join(ENCODINGS)} would be right")
    width, height, step = int(message.width), int(message.height), int(message.step)
    if (width, height) != (intrinsics.width, intrinsics.height):
        raise BadInputError(
            f"image is {width} x {height} px; {intrinsics.width} x {intrinsics.height}, as calibrated, would be right"
        )
    channels, order = ENCODINGS[message.encoding]
    if step < width * channels or len(message.data) != step * height:
        raise BadInputError(
            f"image has {len(message.data)} bytes in rows of {step}; {height} rows of {width * channels} would be right"
        )
    rows = np.asarray(message.data, np.uint8).reshape(height, step)[:, : width * channels]
    return np.ascontiguousarray(rows.reshape(height, width, channels)[..., order])


def read_odometry(message: Any, time: float) -> Odometry:
    """Return a nav_msgs/Odometry, taken at a time [s] on the loop's clock.

    Raises:
        BadInputError: It holds what is no number, or a quaternion that is no turn.
    """
    position, twist = message.pose.pose.position, message.twist.twist
    yaw = yaw_of(message.pose.pose.orientation)
    numbers = (position.x, position.y, yaw, twist.linear.x, twist.linear.y, twist.angular.z)
    if not all(map(math.isfinite, numbers)):
        raise BadInputError(f"odometry is {', '.join(f'{n:g}' for n in numbers)}; six finite numbers would be right")
    x, y, yaw, vx, vy, omega = map(float, numbers)
    return Odometry(time, Pose2D(x, y, yaw), Twist2D(vx, vy, omega))


def read_scan(message: Any, time: float, scanner_in_body: Pose2D) -> LaserScan:
    """Return a sensor_msgs/LaserScan, taken at a time [s] on the loop's clock, counter-clockwise.

    A range that is NaN, below `range_min` or beyond `range_max` counts as nothing met; -inf, which by REP 117 is too
    near to be measured, as `range_min`.

    Raises:
        BadInputError: Its limits or angles are of no scanner.
    """
    low, high, first, step = (
        float(v) for v in (message.range_min, message.range_max, message.angle_min, message.angle_increment)
    )
    ranges = np.asarray(message.ranges, np.float64)
    if not (math.isfinite(first) and 0.0 < abs(step) < math.pi and 2 <= len(ranges) <= MOST_RAYS):
        raise BadInputError(
            f"scan has {len(ranges)} rays from {first:g} rad on, {step:g} rad apart; a sweep of at least 2 is right"
        )
    if not 0.0 <= low < high < math.inf:
        raise BadInputError(f"scan's ranges go from {low:g} to {high:g} m; a positive, finite interval would be right")
    too_near = ranges == -math.inf
    with np.errstate(invalid="ignore"):
        met = (ranges >= low) & (ranges <= high)
    ranges = np.where(too_near, low, np.where(met, ranges, math.inf))
    if step < 0.0:
        ranges, first, step = ranges[::-1].copy(), first + step * (len(ranges) - 1), -step
    return LaserScan(time, ranges, first, step, low, high, scanner_in_body)
