"""Where a posed body's legs are: forward kinematics from hips to ankles, pure numpy."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from han_bullet.geometry import Array
from han_bullet.sim.gait import JOINTS, BodyPose
from han_bullet.sim.skeleton import Skeleton

SHIN_RADIUS, THIGH_RADIUS = 0.06, 0.08  # [m]; of the drawn trousers, halfway along
_FIRST_JOINT = {side: JOINTS.index(f"hip_yaw_{side}") for side in ("left", "right")}


@dataclass(frozen=True)
class LegBone:
    """A thigh or a shin as a round bar.

    Attributes:
        upper, lower: Its ends in the world, each of shape (3,) [m].
        radius: Of the clothed limb [m].
    """

    upper: Array
    lower: Array
    radius: float


def leg_bones(skeleton: Skeleton, body_pose: BodyPose) -> tuple[LegBone, ...]:
    """Return left thigh and shin, then right thigh and shin."""
    pose = body_pose.pose_in_world
    pelvis = _turn_z(pose.yaw) @ _turn_y(body_pose.root_pitch)
    origin = np.array([pose.x, pose.y, body_pose.root_height])
    bones: list[LegBone] = []
    for side, sign in (("left", 1.0), ("right", -1.0)):
        yaw, roll, pitch, bend = body_pose.joints[_FIRST_JOINT[side] : _FIRST_JOINT[side] + 4]
        thigh = pelvis @ _turn_z(yaw) @ _turn_x(roll) @ _turn_y(pitch)
        shin = thigh @ _turn_y(bend)
        hip = origin + pelvis @ np.array([0.0, sign * skeleton.hip, 0.0])
        knee = hip - skeleton.thigh * thigh[:, 2]
        ankle = knee - skeleton.shin * shin[:, 2]
        bones += [LegBone(hip, knee, THIGH_RADIUS), LegBone(knee, ankle, SHIN_RADIUS)]
    return tuple(bones)


def _turn_x(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _turn_y(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def _turn_z(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
