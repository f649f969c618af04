"""How long a person's bones are, and the joint angles that put a foot where it should be: pure numpy.

Both builds follow the body segment lengths of [Winter2009] (fractions of the height, shoes included). The script that
makes the meshes and the gait read the same numbers, so a foot that the gait puts on the floor is drawn on the floor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from han_bullet.errors import BadInputError


@dataclass(frozen=True)
class Skeleton:
    """Lengths of one build.

    The pelvis frame sits midway between the hip joints; x forward, y left, z up. Standing straight, all joint angles
    are zero.

    Attributes:
        height: From the floor to the crown [m].
        hip: Half the distance between the hip joints [m].
        thigh, shin: Hip to knee, knee to ankle [m].
        ankle: Height of the ankle joint above the sole [m].
        foot_stance: Sideways distance of each foot from the middle when standing [m].
        heel, ball, toe: Along the foot from the ankle: back end, where it rolls off, tip [m].
        toe_spring: How far the sole has risen at the tip [m].
        waist: Height of the waist joint above the hips [m].
        shoulder: Half the distance between the shoulder joints [m].
        shoulder_height: Above the waist joint [m].
        neck: Height of the neck joint above the waist joint [m].
        upper_arm, forearm: Shoulder to elbow, elbow to wrist [m].
    """

    height: float
    hip: float
    thigh: float
    shin: float
    ankle: float
    foot_stance: float
    heel: float
    ball: float
    toe: float
    toe_spring: float
    waist: float
    shoulder: float
    shoulder_height: float
    neck: float
    upper_arm: float
    forearm: float

    @property
    def leg(self) -> float:
        """Return the length of the straight leg from hip to ankle [m]."""
        return self.thigh + self.shin


def _winter(height: float, hip: float, shoulder: float) -> Skeleton:
    return Skeleton(
        height=height,
        hip=hip,
        thigh=0.245 * height,
        shin=0.246 * height,
        ankle=0.047 * height,
        foot_stance=hip + 0.01,
        heel=-0.042 * height,
        ball=0.070 * height,
        toe=0.112 * height,
        toe_spring=0.015,
        waist=0.085 * height,
        shoulder=shoulder,
        shoulder_height=0.193 * height,
        neck=0.247 * height,
        upper_arm=0.176 * height,
        forearm=0.146 * height,
    )


def skeleton_of(build: str) -> Skeleton:
    """Return the lengths of the build "slim" (1.70 m) or "broad" (1.80 m)."""
    if build == "slim":
        return _winter(1.70, hip=0.085, shoulder=0.172)
    if build == "broad":
        return _winter(1.80, hip=0.092, shoulder=0.200)
    raise BadInputError(f"build is {build!r}; it must be 'slim' or 'broad'")


def reach_height(skeleton: Skeleton, horizontal: float) -> float:
    """Return how high above an ankle, a horizontal distance [m] away, the hip may be so that the knee stays bent [m].

    A knee a little short of full reach turns by a bounded angle per metre; a straight one does not.
    """
    longest = 0.993 * skeleton.leg
    return math.sqrt(max(longest**2 - horizontal**2, (0.6 * skeleton.leg) ** 2))


def leg_angles(
    skeleton: Skeleton, ankle_in_hip: tuple[float, float, float], foot_yaw: float, foot_pitch: float
) -> tuple[float, float, float, float, float, float]:
    """Return the six joint angles of a leg that hold the foot where it should be.

    Args:
        skeleton: The lengths.
        ankle_in_hip: Ankle joint relative to the hip joint, axes of the pelvis [m]; cut to the leg's reach.
        foot_yaw: Direction of the foot relative to the pelvis [rad].
        foot_pitch: Of the sole, toes down positive [rad].

    Returns:
        Hip yaw, roll and pitch, knee, ankle pitch and roll [rad]; pitch angles turn about y (left), so a bent hip is
        negative and a bent knee is positive.
    """
    cos, sin = math.cos(foot_yaw), math.sin(foot_yaw)
    x = cos * ankle_in_hip[0] + sin * ankle_in_hip[1]
    y = -sin * ankle_in_hip[0] + cos * ankle_in_hip[1]
    roll = math.atan2(y, -ankle_in_hip[2])
    down = math.hypot(y, ankle_in_hip[2])
    distance = min(math.hypot(x, down), 0.999 * skeleton.leg)
    thigh, shin = skeleton.thigh, skeleton.shin
    bend = math.pi - math.acos(max(-1.0, (thigh**2 + shin**2 - distance**2) / (2.0 * thigh * shin)))
    hip = math.atan2(-x, down) - math.atan2(shin * math.sin(bend), thigh + shin * math.cos(bend))
    return foot_yaw, roll, hip, bend, foot_pitch - hip - bend, -roll
