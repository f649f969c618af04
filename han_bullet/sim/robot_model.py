"""The robot's URDF in a PyBullet client: where its parts are, and how it is posed for a picture."""

from __future__ import annotations

import math

import numpy as np
import pybullet

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Pose2D, rotated
from han_bullet.mecanum import WHEELS, MecanumWheels
from han_bullet.sim.room import urdf_path, yaw_quaternion
from han_bullet.sim.scene_state import RobotPosture

HEAD = "head_pan"


class RobotModel:
    """The robot in one client.

    Attributes:
        body: Its id in that client.
        joints: Joint index by name.
    """

    def __init__(self, client: int, urdf: str, pose_in_world: Pose2D, *, fixed: bool) -> None:
        """Load the robot.

        Args:
            client: PyBullet client.
            urdf: File in urdf/; its origin is on the floor, in the middle of the base.
            pose_in_world: Where it stands first.
            fixed: Whether the base is held, as in a client that only draws.

        Raises:
            BadInputError: The file or one of its wheel and head joints is missing.
        """
        self._client = client
        start = [pose_in_world.x, pose_in_world.y, 0.0]
        quaternion = yaw_quaternion(pose_in_world.yaw)
        path = str(urdf_path(urdf))
        # Without these flags a cylinder becomes a hull of points and the inertia is made up from it.
        flags = pybullet.URDF_USE_IMPLICIT_CYLINDER | pybullet.URDF_USE_INERTIA_FROM_FILE
        self.body: int = pybullet.loadURDF(
            path, start, quaternion, useFixedBase=fixed, flags=flags, physicsClientId=client
        )
        self.joints = self._joints_by_name()
        missing = sorted({*WHEELS, HEAD} - set(self.joints))
        if missing:
            raise BadInputError(f"URDF {urdf!r} lacks the joint {missing[0]!r}; it needs {', '.join((*WHEELS, HEAD))}")
        self._base_to_centre_of_mass = self._base_inertial_offset()

    def place(self, posture: RobotPosture) -> None:
        """Pose the robot for a picture."""
        pose, offset = posture.pose_in_world, self._base_to_centre_of_mass
        x, y = pose.to_world(np.array(offset[:2]))
        pybullet.resetBasePositionAndOrientation(
            self.body, [x, y, offset[2]], yaw_quaternion(pose.yaw), physicsClientId=self._client
        )
        for name, angle in zip((HEAD, *WHEELS), (posture.head_pan, *posture.wheel_angles), strict=True):
            pybullet.resetJointState(self.body, self.joints[name], angle, physicsClientId=self._client)

    def pose_in_world(self) -> Pose2D:
        """Return where the robot stands."""
        position, quaternion = pybullet.getBasePositionAndOrientation(self.body, physicsClientId=self._client)
        qx, qy, qz, qw = quaternion
        yaw = math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz))
        x, y = rotated(*self._base_to_centre_of_mass[:2], yaw)
        return Pose2D(position[0] - x, position[1] - y, yaw)

    def wheels(self) -> MecanumWheels:
        """Read the wheels' geometry: they stand on the floor, so an axle is as high as its wheel's radius."""
        pose = self.pose_in_world()
        axle = self._joint_position(self.joints[WHEELS[0]])
        forward, left = pose.to_body(axle[:2])
        return MecanumWheels(float(axle[2]), float(forward), float(left))

    def _joint_position(self, joint: int) -> Array:
        state = pybullet.getLinkState(self.body, joint, computeForwardKinematics=True, physicsClientId=self._client)
        return np.array(state[4])

    def _joints_by_name(self) -> dict[str, int]:
        count = pybullet.getNumJoints(self.body, physicsClientId=self._client)
        infos = (pybullet.getJointInfo(self.body, index, physicsClientId=self._client) for index in range(count))
        return {info[1].decode(): info[0] for info in infos}

    def _base_inertial_offset(self) -> tuple[float, float, float]:
        offset: tuple[float, float, float] = pybullet.getDynamicsInfo(self.body, -1, physicsClientId=self._client)[3]
        return offset
