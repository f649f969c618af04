"""How people stand, walk and sit: joint angles from where a person is, pure numpy.

The feet decide. A planted foot stays where it is in the world until its turn to step; a stepping foot flies to where it
will be needed; inverse kinematics then gives the legs. So feet do not slide, on straight ways and in turns alike, and
starting, stopping and turning on the spot need no cases of their own.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from han_bullet.geometry import Pose2D, wrap_angle
from han_bullet.messages import Posture
from han_bullet.sim.skeleton import leg_angles, reach_height, skeleton_of

_LEG = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")
_ARM = ("shoulder_pitch", "shoulder_roll", "elbow")
JOINTS: tuple[str, ...] = (
    "waist_yaw",
    "waist_pitch",
    "neck_yaw",
    "neck_pitch",
    *(f"{joint}_{side}" for side in ("left", "right") for joint in (*_LEG, *_ARM)),
)

STRIDE_AT_1_MPS = 1.15  # [m]; with the exponent below 0.61 m at 0.35 m/s and 1.28 m at 1.2 m/s, as people walk
STRIDE_EXPONENT = 0.6  # strides lengthen less than speed: faster walkers also step oftener
SWING_FRACTION = 0.38  # of a cycle in which a foot is in the air, at ordinary speed
LONGEST_SWING = 0.6  # [s]; slow walkers stay longer on both feet rather than lifting one in slow motion
FIRST_STEP_HASTE = 1.4  # the first step is a quick one, or the other foot would be left far behind
CORRECTION_TIME = 0.45  # [s] for a step taken while standing
SPEED_FILTER = 0.1  # [s], so that a sudden order to walk or stop does not show as a jerk
STILL_SPEED = 0.05  # [m/s], below this a person stands
MISPLACED = 0.06  # [m] and
MISALIGNED = 0.35  # [rad]: a standing person's foot that is further off takes a step
SIT_TIME = 1.0  # [s] to sit down or stand up
STAGGER = 0.10  # [m] that each foot stands before or behind the hips,
TOE_OUT = 0.12  # [rad] that it points outward: nobody stands to attention
TELEPORT = 0.5  # [m] in one call: the feet start afresh


@dataclass(frozen=True)
class BodyPose:
    """A posed body.

    Attributes:
        pose_in_world: Middle between the hip joints, over the floor, and the direction faced.
        root_height: Of the hip joints above the floor [m].
        root_pitch: Of the pelvis, forward positive [rad].
        joints: Angles in the order of JOINTS [rad].
    """

    pose_in_world: Pose2D
    root_height: float
    root_pitch: float
    joints: tuple[float, ...]


@dataclass
class _Foot:
    """A foot on its way: flat position in the world, and how far its step is (1: planted)."""

    side: float
    x: float
    y: float
    yaw: float
    progress: float = 1.0
    haste: float = 1.0
    lift_pitch: float = 0.0
    pitch: float = 0.0
    clearance: float = 0.0
    ahead: float = 0.0

    @property
    def planted(self) -> bool:
        return self.progress >= 1.0


def _smooth(value: float) -> float:
    value = min(max(value, 0.0), 1.0)
    return value * value * (3.0 - 2.0 * value)


def _planted_pitch(ahead: float) -> float:
    """Return the pitch of a planted sole: on the heel far ahead of the body, on the ball far behind it."""
    return 0.60 * _smooth((-ahead - 0.06) / 0.38) - 0.26 * _smooth((ahead - 0.12) / 0.22)


class Gait:
    """The gait of one person; remembers where the feet are."""

    def __init__(self, build: str) -> None:
        """Start with a build, "slim" or "broad"; the feet are placed by the first call of advance."""
        self._skeleton = skeleton_of(build)
        self._feet: tuple[_Foot, ...] = ()
        self._last_pose = Pose2D(0.0, 0.0, 0.0)
        self._speed = 0.0
        self._since_lift = math.inf
        self._next = 0
        self._seated = 0.0

    def advance(self, pose_in_world: Pose2D, speed: float, dt: float, posture: Posture) -> BodyPose:
        """Move on to a new pose.

        Args:
            pose_in_world: Where the person is now; seated, the declared seat.
            speed: Of the person [m/s].
            dt: Time since the last call [s].
            posture: What the person does.
        """
        moved = math.hypot(pose_in_world.x - self._last_pose.x, pose_in_world.y - self._last_pose.y)
        if not self._feet or moved > TELEPORT:
            self._begin(pose_in_world, speed, posture)
        else:
            self._speed += (speed - self._speed) * (1.0 - math.exp(-dt / SPEED_FILTER))
            towards = 1.0 if posture is Posture.SEATED else -1.0
            self._seated = min(max(self._seated + towards * dt / SIT_TIME, 0.0), 1.0)
            self._step(pose_in_world, moved, dt)
        self._last_pose = pose_in_world
        return self._pose_body(pose_in_world)

    def _begin(self, pose: Pose2D, speed: float, posture: Posture) -> None:
        self._feet = (self._neutral(pose, 1.0), self._neutral(pose, -1.0))
        self._speed, self._since_lift = speed, math.inf
        self._seated = 1.0 if posture is Posture.SEATED else 0.0

    def _neutral(self, pose: Pose2D, side: float) -> _Foot:
        return _Foot(side, *self._place(pose, side, side * STAGGER), pose.yaw + side * TOE_OUT)

    def _place(self, pose: Pose2D, side: float, ahead: float) -> tuple[float, float]:
        """Return the floor point that lies ahead of one hip, its foot's width to the side [m]."""
        across = side * self._skeleton.foot_stance
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        return pose.x + cos * ahead - sin * across, pose.y + sin * ahead + cos * across

    @property
    def _stride(self) -> float:
        return max(STRIDE_AT_1_MPS * math.pow(self._speed, STRIDE_EXPONENT), 0.2)

    @property
    def _swing_time(self) -> float:
        if self._speed < STILL_SPEED:
            return CORRECTION_TIME
        return min(SWING_FRACTION * self._stride / self._speed, LONGEST_SWING)

    def _reach_ahead(self, side: float) -> float:
        """Return how far ahead of the body a foot lands: half its stance, less what people leave behind them [m]."""
        if self._speed < STILL_SPEED:
            return side * STAGGER
        return 0.5 * (self._stride - self._speed * self._swing_time) - 0.07 * self._speed

    def _step(self, pose: Pose2D, moved: float, dt: float) -> None:
        """Lift feet whose turn it is and move those in the air."""
        for foot in self._feet:
            foot.ahead = self._ahead(foot, pose)
        if self._speed < STILL_SPEED:
            self._since_lift = math.inf  # the first step of the next walk comes at once
        if all(foot.planted for foot in self._feet):
            self._lift(pose)
        self._since_lift += moved
        for foot in self._feet:
            if not foot.planted:
                self._swing(foot, pose, dt)
            foot.ahead = self._ahead(foot, pose)
            if foot.planted:
                foot.pitch, foot.clearance = _planted_pitch(foot.ahead), 0.0

    def _lift(self, pose: Pose2D) -> None:
        """Lift a foot: in turns every half stride while walking, the one that stands worse otherwise."""
        if self._speed >= STILL_SPEED:
            first = math.isinf(self._since_lift)
            foot = min(self._feet, key=lambda each: each.ahead) if first else self._feet[self._next]
            lag = self._reach_ahead(foot.side) - (self._stride - self._speed * self._swing_time) - 0.03
            behind = max(each.ahead for each in self._feet) < 0.0  # gathering speed: both feet would be left behind
            lift = self._since_lift >= 0.5 * self._stride or foot.ahead < lag or behind
        else:
            foot = max(self._feet, key=lambda each: self._misplacement(each, pose))
            lift = self._misplacement(foot, pose) > 1.0
        if lift:
            foot.progress, foot.lift_pitch = 0.0, foot.pitch
            foot.haste = FIRST_STEP_HASTE if math.isinf(self._since_lift) else 1.0
            self._since_lift = 0.0
            self._next = 1 - self._feet.index(foot)

    def _misplacement(self, foot: _Foot, pose: Pose2D) -> float:
        best = self._neutral(pose, foot.side)
        aside, turned = math.hypot(foot.x - best.x, foot.y - best.y), abs(wrap_angle(foot.yaw - best.yaw))
        return max(aside / MISPLACED, turned / MISALIGNED)

    def _swing(self, foot: _Foot, pose: Pose2D, dt: float) -> None:
        """Bring a foot in the air nearer to where it will land, as far as its eased progress goes."""
        before = foot.progress
        duration = self._swing_time / foot.haste
        foot.progress = min(before + dt / duration, 1.0)
        share = (_smooth(foot.progress) - _smooth(before)) / max(1.0 - _smooth(before), 1e-9)
        to_come = self._speed * duration * (1.0 - foot.progress)
        ahead = self._reach_ahead(foot.side)
        x, y = self._place(pose, foot.side, ahead + to_come)
        foot.x += share * (x - foot.x)
        foot.y += share * (y - foot.y)
        foot.yaw += share * wrap_angle(pose.yaw + foot.side * TOE_OUT - foot.yaw)
        landing = _planted_pitch(ahead)
        foot.pitch = foot.lift_pitch + _smooth(foot.progress) * (landing - foot.lift_pitch)
        foot.clearance = (0.03 + 0.03 * self._speed) * math.sin(math.pi * foot.progress) ** 2

    def _ahead(self, foot: _Foot, pose: Pose2D) -> float:
        return math.cos(pose.yaw) * (foot.x - pose.x) + math.sin(pose.yaw) * (foot.y - pose.y)

    def _pose_body(self, pose: Pose2D) -> BodyPose:
        """Join legs, arms and trunk; seated people are blended in."""
        ankles = [self._ankle_in_body(foot, pose) for foot in self._feet]
        height = _soft_minimum(
            reach_height(self._skeleton, math.hypot(x, y - foot.side * self._skeleton.hip)) + z
            for foot, (x, y, z) in zip(self._feet, ankles, strict=True)
        )
        swing = self._feet[0].ahead - self._feet[1].ahead
        angles = [0.14 * swing, 0.02 + 0.03 * self._speed, -0.14 * swing, 0.0]
        for foot, (x, y, z) in zip(self._feet, ankles, strict=True):
            ankle_in_hip = (x, y - foot.side * self._skeleton.hip, z - height)
            angles += leg_angles(self._skeleton, ankle_in_hip, wrap_angle(foot.yaw - pose.yaw), foot.pitch)
            angles += self._arm(foot.side, 0.5 * foot.side * swing)
        return self._sit(pose, height, angles)

    def _ankle_in_body(self, foot: _Foot, pose: Pose2D) -> tuple[float, float, float]:
        """Return the ankle joint relative to the floor point under the hips, in the body's axes [m].

        The sole turns about the ball of the foot or about the heel, and its lowest point is on the floor.
        """
        s = self._skeleton
        cos, sin = math.cos(foot.pitch), math.sin(foot.pitch)
        pivot = s.ball if foot.pitch > 0.0 else s.heel
        forward = pivot - (cos * pivot - sin * s.ankle)
        soles = ((s.heel, -s.ankle), (s.ball, -s.ankle), (s.toe, s.toe_spring - s.ankle))
        height = foot.clearance - min(-sin * along + cos * up for along, up in soles)
        x, y = foot.x + math.cos(foot.yaw) * forward, foot.y + math.sin(foot.yaw) * forward
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        return cos * (x - pose.x) + sin * (y - pose.y), -sin * (x - pose.x) + cos * (y - pose.y), height

    def _arm(self, side: float, leg_ahead: float) -> tuple[float, float, float]:
        """Swing an arm against the leg of its side; brisk walkers bend their elbows."""
        return 1.15 * leg_ahead - 0.05, side * 0.09, -0.32 - 0.14 * min(self._speed, 1.5)

    def _sit(self, pose: Pose2D, height: float, angles: list[float]) -> BodyPose:
        s, share = self._skeleton, _smooth(self._seated)
        leg, arm = (0.0, -1.42, 1.56, 0.0), (-0.02, -1.22)
        seated = [0.0, 0.04, 0.0, 0.04]
        for side in (1.0, -1.0):
            seated += [side * 0.06, side * 0.06, *leg[1:], -side * 0.06, arm[0], side * 0.12, arm[1]]
        joints = tuple(a + share * (b - a) for a, b in zip(angles, seated, strict=True))
        return BodyPose(pose, height + share * (s.shin + s.ankle + 0.01 - height), -0.14 * share, joints)


def _soft_minimum(values: Iterable[float]) -> float:
    """Return nearly the least of some heights [m], smoothly: the body shall not jerk when another leg limits it."""
    sharpness = 150.0
    listed = list(values)
    return -math.log(sum(math.exp(-sharpness * value) for value in listed) / len(listed)) / sharpness
