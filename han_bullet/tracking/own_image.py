"""Where the robot itself shows in a fixed camera's image: what ends there tells nothing of a person's feet."""

from __future__ import annotations

import math

import numpy as np

from han_bullet.geometry import Array, Pose2D, SolidBox, project
from han_bullet.messages import Frame
from han_bullet.tracking.field_of_view import ROBOT_HEIGHT

RIM_POINTS = 16  # of the cylinder's two circles
MARGIN = 0.1  # [m] by which the robot is wider than its footprint: wheels, rim, and the error of its pose
BELOW = 6.0  # [px] below the robot in which its changes may still end: a blurred edge, an uneven floor


def robot_body(pose_robot_in_world: Pose2D, robot_radius: float) -> SolidBox:
    """Return the robot as a box that hides the feet of who is behind it.

    Args:
        pose_robot_in_world: From the localization port.
        robot_radius: Of its footprint [m].
    """
    size = np.array([2.0 * robot_radius, 2.0 * robot_radius, ROBOT_HEIGHT])
    centre = np.array([*pose_robot_in_world.position, 0.5 * ROBOT_HEIGHT])
    return SolidBox("robot", "object", centre, size, pose_robot_in_world.yaw)


def rows_not_of_robot(
    frame: Frame, boxes: Array, known_rows: Array, pose_robot_in_world: Pose2D, robot_radius: float
) -> Array:
    """Return the rows where feet end; NaN also where the robot shows in the columns of the box at that row.

    Args:
        frame: The camera.
        boxes: Shape (n, 4): x, y, width, height [px].
        known_rows: Shape (n,) [px], NaN where nobody knows.
        pose_robot_in_world: From the localization port.
        robot_radius: Of its footprint [m].
    """
    angles = 2.0 * math.pi * np.arange(RIM_POINTS) / RIM_POINTS
    circle = (robot_radius + MARGIN) * np.column_stack([np.cos(angles), np.sin(angles)])
    rim = pose_robot_in_world.position + circle
    cylinder = np.vstack([np.column_stack([rim, np.full(RIM_POINTS, z)]) for z in (0.0, ROBOT_HEIGHT)])
    pixels, depths = project(cylinder, frame.intrinsics, frame.camera_in_world)
    if (depths <= 0.0).any():  # beside the camera or behind it
        return known_rows
    (left, top), (right, bottom) = pixels.min(axis=0), pixels.max(axis=0)
    beside = (boxes[:, 0] < right) & (boxes[:, 0] + boxes[:, 2] > left)
    return np.where(beside & (known_rows >= top) & (known_rows <= bottom + BELOW), np.nan, known_rows)
