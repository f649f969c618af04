"""Points, poses and transforms as ROS messages."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Pose2D
from han_bullet.ros.message_types import header, make

UNIT_WITHIN = 0.05  # how far a quaternion's length may be from 1

Quaternion = tuple[float, float, float, float]  # x, y, z, w


def point(x: float, y: float, z: float = 0.0) -> Any:
    """Return a geometry_msgs/Point [m]."""
    return make("geometry_msgs/Point", x=float(x), y=float(y), z=float(z))


def vector(x: float, y: float, z: float = 0.0) -> Any:
    """Return a geometry_msgs/Vector3."""
    return make("geometry_msgs/Vector3", x=float(x), y=float(y), z=float(z))


def rotation_message(quaternion: Quaternion) -> Any:
    """Return a geometry_msgs/Quaternion."""
    x, y, z, w = quaternion
    return make("geometry_msgs/Quaternion", x=x, y=y, z=z, w=w)


def yaw_message(yaw: float) -> Any:
    """Return the geometry_msgs/Quaternion of a turn about the vertical [rad]."""
    return rotation_message((0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw)))


def pose_message(pose: Pose2D, height: float = 0.0) -> Any:
    """Return a pose on the floor, or at a height [m] above it, as a geometry_msgs/Pose."""
    return make("geometry_msgs/Pose", position=point(pose.x, pose.y, height), orientation=yaw_message(pose.yaw))


def pose_stamped(pose: Pose2D, time: float, frame: str) -> Any:
    """Return a pose on the floor at a time [s] as a geometry_msgs/PoseStamped."""
    return make("geometry_msgs/PoseStamped", header=header(time, frame), pose=pose_message(pose))


def yaw_of(quaternion: Any) -> float:
    """Return the turn about the vertical [rad] of a geometry_msgs/Quaternion.

    Raises:
        BadInputError: It is no turn: its length is not 1, or not finite.
    """
    x, y, z, w = (float(getattr(quaternion, name)) for name in "xyzw")
    length = math.sqrt(x * x + y * y + z * z + w * w)
    if not abs(length - 1.0) <= UNIT_WITHIN:  # nor NaN
        raise BadInputError(f"orientation is ({x:g}, {y:g}, {z:g}, {w:g}), of length {length:g}; 1 would be right")
    return math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)


def transform(parent: Any, child: str, translation: Any, rotation: Any) -> Any:
    """Return a geometry_msgs/TransformStamped of the parent frame's header, a Vector3 and a Quaternion message."""
    moved = make("geometry_msgs/Transform", translation=translation, rotation=rotation)
    return make("geometry_msgs/TransformStamped", header=parent, child_frame_id=child, transform=moved)


def floor_transform(parent: Any, child: str, pose: Pose2D) -> Any:
    """Return the geometry_msgs/TransformStamped that places a child frame at a pose on its parent's floor."""
    return transform(parent, child, vector(pose.x, pose.y), yaw_message(pose.yaw))


def rigid_transform(parent: str, child: str, child_in_parent: Array) -> Any:
    """Return the geometry_msgs/TransformStamped of a rigid transform that never changes, shape (4, 4)."""
    x, y, z = child_in_parent[:3, 3].tolist()
    turned = rotation_message(quaternion_of(child_in_parent[:3, :3]))
    return transform(header(0.0, parent), child, vector(x, y, z), turned)


def quaternion_of(rotation: Array) -> Quaternion:
    """Return the unit quaternion (x, y, z, w), w >= 0, of a rotation matrix, shape (3, 3).

    It is the eigenvector of the largest eigenvalue of a symmetric matrix, which is sound for every angle.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation.tolist()
    symmetric = np.array(
        [
            [xx - yy - zz, 0.0, 0.0, 0.0],
            [yx + xy, yy - xx - zz, 0.0, 0.0],
            [zx + xz, zy + yz, zz - xx - yy, 0.0],
            [zy - yz, xz - zx, yx - xy, xx + yy + zz],
        ]
    )
    _, vectors = np.linalg.eigh(symmetric, UPLO="L")
    x, y, z, w = vectors[:, -1].tolist()
    return (x, y, z, w) if w >= 0.0 else (-x, -y, -z, -w)


def planar_covariance(covariance: Array) -> Array:
    """Return a covariance of (x, y, yaw), shape (3, 3), as that of (x, y, z, roll, pitch, yaw), shape (36,)."""
    whole = np.zeros((6, 6))
    whole[np.ix_((0, 1, 5), (0, 1, 5))] = covariance
    return whole.ravel()
