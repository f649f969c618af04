"""Where the robot goes and has been as ROS messages: goal, plan, trajectory."""

from __future__ import annotations

import math
from collections import deque
from typing import Any

import numpy as np

from han_bullet.geometry import Pose2D, wrap_angle
from han_bullet.messages import Path, PoseEstimate, Scene
from han_bullet.ros.frames import MAP
from han_bullet.ros.message_types import header, make
from han_bullet.ros.placing import pose_message, pose_stamped
from han_bullet.situation import goal_of

PLAN_STEP = 3  # cells between two poses of a published plan, which the robot follows cell by cell
LONGEST_TRAJECTORY = 1000  # poses
TRAJECTORY_STEP = (0.1, 0.2)  # [m], [rad] between two of them


def plan_message(path: Path | None, time: float) -> Any:
    """Return a planned way as a nav_msgs/Path of poses that look along it; empty where there is none."""
    stamp = header(time, MAP)
    poses = [] if path is None else _looking_along(path)
    stamped = [make("geometry_msgs/PoseStamped", header=stamp, pose=pose_message(pose)) for pose in poses]
    return make("nav_msgs/Path", header=stamp, poses=stamped)


def _looking_along(path: Path) -> list[Pose2D]:
    """Return every so many of a way's points, and the last, as poses that look to the next."""
    points = path.points_in_world
    points = np.vstack([points[:-1:PLAN_STEP], points[-1:]])
    steps = np.diff(points, axis=0)
    yaws = np.arctan2(steps[:, 1], steps[:, 0]).tolist()
    return [Pose2D(x, y, yaw) for (x, y), yaw in zip(points.tolist(), [*yaws, *(yaws[-1:] or [0.0])], strict=True)]


def goal_message(scene: Scene) -> Any | None:
    """Return where the robot has to be for its task as a geometry_msgs/PoseStamped; None where nothing leads it."""
    if scene.task is None or scene.pose_robot_in_world is None:
        return None
    return pose_stamped(goal_of(scene.task, scene.pose_robot_in_world), scene.time, MAP)


class Trajectory:
    """Where the robot believes to have been, up to the last `LONGEST_TRAJECTORY` poses."""

    def __init__(self) -> None:
        self._last: Pose2D | None = None
        self._poses: deque[Any] = deque(maxlen=LONGEST_TRAJECTORY)

    def add(self, estimate: PoseEstimate) -> None:
        """Take note of where the robot is, if it has moved on."""
        pose, last = estimate.pose_robot_in_world, self._last
        if last is not None:
            way, turn = math.hypot(pose.x - last.x, pose.y - last.y), abs(wrap_angle(pose.yaw - last.yaw))
            if way < TRAJECTORY_STEP[0] and turn < TRAJECTORY_STEP[1]:
                return
        self._last = pose
        self._poses.append(pose_stamped(pose, estimate.time, MAP))

    def message(self, time: float) -> Any:
        """Return it as a nav_msgs/Path, the oldest pose first."""
        return make("nav_msgs/Path", header=header(time, MAP), poses=list(self._poses))
