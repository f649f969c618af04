"""The tree of frames: map -> odom -> base_link -> wheels, head, laser and cameras."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from han_bullet.geometry import Pose2D
from han_bullet.messages import Odometry, PoseEstimate
from han_bullet.ros.frames import BASE, LASER, MAP, ODOM, optical_frame
from han_bullet.ros.message_types import header, make
from han_bullet.ros.placing import floor_transform, rigid_transform, rotation_message, transform, vector
from han_bullet.ros.robot_description import Joint, RobotDescription
from han_bullet.world_schema import Camera, Laser, World


def map_to_odom(estimate: PoseEstimate, odometry: Odometry) -> Pose2D:
    """Return where the odom frame is on the map, so that odometry and map agree on where the robot is."""
    odom_in_body = odometry.pose_robot_in_odom.relative(Pose2D(0.0, 0.0, 0.0))
    return estimate.pose_robot_in_world.compose(odom_in_body)


class Transforms:
    """The tree of frames of a world's robot and cameras.

    Args:
        world: With the cameras in use.
        robot: Its robot.
    """

    def __init__(self, world: World, robot: RobotDescription) -> None:
        self._world = world
        self._wheels = [_Wheel(joint) for joint in robot.wheels]
        turning = {joint.name for joint in robot.wheels}
        self._still = [joint for joint in robot.joints if joint.name not in turning]  # the head never turns

    def static(self) -> Any:
        """Return what never moves as a tf2_msgs/TFMessage."""
        robot = [rigid_transform(joint.parent, joint.child, joint.child_in_parent) for joint in self._still]
        laser = self._world.robot.laser
        scanner = [] if laser is None else [_laser(laser)]
        return make("tf2_msgs/TFMessage", transforms=[*robot, *scanner, *map(_camera, self._world.cameras)])

    def moving(self, estimate: PoseEstimate, odometry: Odometry, wheel_angles: Sequence[float]) -> Any:
        """Return what moves as a tf2_msgs/TFMessage.

        Args:
            estimate: Where the robot believes itself to be.
            odometry: Of the same time.
            wheel_angles: In the order of WHEELS [rad].
        """
        time, stamp = odometry.time, header(odometry.time, BASE)
        places = [
            floor_transform(header(time, MAP), ODOM, map_to_odom(estimate, odometry)),
            floor_transform(header(time, ODOM), BASE, odometry.pose_robot_in_odom),
        ]
        wheels = [wheel.at(stamp, angle) for wheel, angle in zip(self._wheels, wheel_angles, strict=True)]
        return make("tf2_msgs/TFMessage", transforms=[*places, *wheels])


class _Wheel:
    """The frame of a wheel, which hangs on the base, unturned, and turns about an axis of its own."""

    def __init__(self, joint: Joint) -> None:
        assert joint.axis is not None
        self._child = joint.child
        self._axis = joint.axis.tolist()
        self._place = vector(*joint.child_in_parent[:3, 3].tolist())

    def at(self, stamp: Any, angle: float) -> Any:
        s, c = math.sin(0.5 * angle), math.cos(0.5 * angle)
        x, y, z = self._axis
        return transform(stamp, self._child, self._place, rotation_message((s * x, s * y, s * z, c)))


def _camera(camera: Camera) -> Any:
    return rigid_transform(MAP if camera.fixed else BASE, optical_frame(camera.name), camera.mount)


def _laser(laser: Laser) -> Any:
    mount = np.eye(4)
    mount[:3, 3] = laser.forward, 0.0, laser.height
    return rigid_transform(BASE, LASER, mount)
