"""What people and programs send over ROS, as our values: every number checked, every refusal a sentence."""

from __future__ import annotations

import math
from typing import Any

from han_bullet.errors import BadInputError
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.ros.frames import MAP

UNIT_WITHIN = 0.1  # how far a quaternion's norm may be from 1
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
    quaternion = (turn.x, turn.y, turn.z, turn.w)
    if not all(map(math.isfinite, (position.x, position.y, *quaternion))):
        raise BadInputError(f"the pose is x {position.x}, y {position.y}, quaternion {quaternion}; not finite")
    norm = math.sqrt(sum(part * part for part in quaternion))
    if abs(norm - 1.0) > UNIT_WITHIN:
        raise BadInputError(f"the pose's quaternion {quaternion} has the norm {norm:g}; 1 would be right")
    if math.hypot(turn.x, turn.y) > LEVEL_WITHIN:
        raise BadInputError(f"the pose's quaternion {quaternion} tilts the robot; x and y 0 would be right")
    return Pose2D(position.x, position.y, 2.0 * math.atan2(turn.z, turn.w))


def twist_in_body(twist: Any) -> Twist2D:
    """Return a geometry_msgs/Twist as a planar one; what points out of the plane is left out.

    Raises:
        BadInputError: It is not finite.
    """
    numbers = (twist.linear.x, twist.linear.y, twist.angular.z)
    if not all(map(math.isfinite, numbers)):
        raise BadInputError(f"the twist is {numbers}; not finite")
    return Twist2D(*map(float, numbers))
