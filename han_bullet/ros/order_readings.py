"""What orders from ROS say, as our values: every number checked, every refusal a sentence."""

from __future__ import annotations

import math
from typing import Any

from han_bullet.errors import BadInputError
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.ros.frames import MAP
from han_bullet.ros.placing import yaw_of

LEVEL_WITHIN = 0.1  # how much of a quaternion may tilt the robot


def pose_on_floor(stamped: Any) -> Pose2D:
    """Return a geometry_msgs/PoseStamped as a pose on the floor of the map.

    Raises:
        BadInputError: It is in another frame, not finite, or no direction on the floor.
    """
    frame = stamped.header.frame_id.lstrip("/")
    if frame != MAP:
        raise BadInputError(f"the pose is in frame {frame[:60]!r}; {MAP!r} would be right")
    position, turn = stamped.pose.position, stamped.pose.orientation
    yaw = yaw_of(turn)
    if not (math.isfinite(position.x) and math.isfinite(position.y)):
        raise BadInputError(f"the pose is at x {position.x}, y {position.y}; not finite")
    if math.hypot(turn.x, turn.y) > LEVEL_WITHIN:
        raise BadInputError(f"the pose's quaternion has x {turn.x:g}, y {turn.y:g}, which tilts the robot; 0 is right")
    return Pose2D(float(position.x), float(position.y), yaw)


def twist_in_body(twist: Any) -> Twist2D:
    """Return a geometry_msgs/Twist as a planar one; what points out of the plane is left out.

    Raises:
        BadInputError: It is not finite.
    """
    numbers = (twist.linear.x, twist.linear.y, twist.angular.z)
    if not all(map(math.isfinite, numbers)):
        raise BadInputError(f"the twist is {numbers}; not finite")
    return Twist2D(*map(float, numbers))
