"""Feet, knees and seats of walking people, by forward kinematics of the legs alone."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Pose2D, wrap_angle
from han_bullet.messages import Posture
from han_bullet.sim.behaviours import Walking
from han_bullet.sim.gait import JOINTS, BodyPose, Gait
from han_bullet.sim.skeleton import Skeleton, leg_angles, skeleton_of
from han_bullet.sim.trigger import RobotNow
from han_bullet.world_schema import Walk

DT = 0.05  # [s]
SIDES = (("left", 1.0), ("right", -1.0))


def turn(axis: str, angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array(
        {
            "x": [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]],
            "y": [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]],
            "z": [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]],
        }[axis]
    )


def foot_in_pelvis(skeleton: Skeleton, hip_y: float, angles: tuple[float, ...]) -> tuple[Array, Array]:
    """Ankle position and foot rotation from hip yaw, roll, pitch, knee, ankle pitch, roll."""
    hip = turn("z", angles[0]) @ turn("x", angles[1]) @ turn("y", angles[2])
    knee = hip @ turn("y", angles[3])
    ankle = np.array([0.0, hip_y, 0.0]) + hip @ [0.0, 0.0, -skeleton.thigh] + knee @ [0.0, 0.0, -skeleton.shin]
    return ankle, knee @ turn("y", angles[4]) @ turn("x", angles[5])


def soles(build: str, body: BodyPose) -> dict[str, Array]:
    """Heel, ball and tip of each sole in the world, (3, 3) [m]."""
    s = skeleton_of(build)
    root = turn("z", body.pose_in_world.yaw) @ turn("y", body.root_pitch)
    origin = np.array([body.pose_in_world.x, body.pose_in_world.y, body.root_height])
    along = np.array([[s.heel, 0.0, -s.ankle], [s.ball, 0.0, -s.ankle], [s.toe, 0.0, s.toe_spring - s.ankle]])
    feet = {}
    for side, sign in SIDES:
        first = JOINTS.index(f"hip_yaw_{side}")
        ankle, foot = foot_in_pelvis(s, sign * s.hip, body.joints[first : first + 6])
        feet[side] = origin + (ankle + along @ foot.T) @ root.T
    return feet


def walk(build: str, speed: float, duration: float, before: float = 0.0, turn_rate: float = 0.0) -> list[BodyPose]:
    """Stand for a while, then walk, from the origin along +x, turning at a rate [rad/s]."""
    gait, pose, bodies = Gait(build), Pose2D(0.0, 0.0, 0.0), []
    for index in range(round((before + duration) / DT)):
        now = speed if index * DT >= before else 0.0
        yaw = pose.yaw + (turn_rate * DT if index * DT >= before else 0.0)
        pose = Pose2D(pose.x + now * DT * math.cos(yaw), pose.y + now * DT * math.sin(yaw), yaw)
        bodies.append(gait.advance(pose, now, DT, Posture.WALKING if now > 0.0 else Posture.STANDING))
    return bodies


def joint_speed(bodies: list[BodyPose]) -> float:
    return float(np.abs(np.diff([body.joints for body in bodies], axis=0)).max() / DT)


@pytest.mark.parametrize("build", ["slim", "broad"])
@pytest.mark.parametrize("speed", [0.35, 0.8, 1.2])
def test_a_stance_foot_stays_put_during_single_support(build: str, speed: float) -> None:
    feet = [soles(build, body) for body in walk(build, speed, 6.0)][40:]
    phases = 0
    for (side, _), (other, _) in (SIDES, SIDES[::-1]):
        single = [foot[other][:, 2].min() > 0.008 for foot in feet]
        for lone, run in itertools.groupby(zip(single, feet, strict=True), key=lambda pair: pair[0]):
            balls = np.array([foot[side][1] for _, foot in run])
            if lone and len(balls) >= 4:
                phases += 1
                assert np.linalg.norm(balls[:, :2] - balls[0, :2], axis=1).max() < 0.015
    assert phases >= 4


@pytest.mark.parametrize("build", ["slim", "broad"])
@pytest.mark.parametrize("speed", [0.2, 0.35, 0.8, 1.2, 1.5])
@pytest.mark.parametrize("turn_rate", [0.0, 0.4])
def test_feet_neither_sink_into_the_floor_nor_hover_over_it(build: str, speed: float, turn_rate: float) -> None:
    for body in walk(build, speed, 6.0, before=0.5, turn_rate=turn_rate):
        lowest = [foot[:, 2].min() for foot in soles(build, body).values()]
        assert min(lowest) > -0.006
        assert min(lowest) < 0.006
        assert max(lowest) < 0.13


@pytest.mark.parametrize("speed", [0.3, 0.35, 1.2])
def test_starting_walking_and_stopping_move_no_joint_faster_than_people_do(speed: float) -> None:
    gait, bodies = Gait("slim"), []
    for index in range(160):
        now = speed if 20 <= index < 120 else 0.0
        x = speed * DT * min(max(index - 20, 0), 100)
        bodies.append(gait.advance(Pose2D(x, 0.0, 0.0), now, DT, Posture.WALKING if now else Posture.STANDING))
    assert joint_speed(bodies) < 10.0
    assert np.abs(np.diff([body.root_height for body in bodies])).max() < 0.045


def test_a_walker_who_stops_ends_with_the_feet_side_by_side() -> None:
    gait = Gait("broad")
    for index in range(100):
        x = 1.2 * DT * min(index, 50)
        body = gait.advance(Pose2D(x, 0.0, 0.0), 1.2 if index < 50 else 0.0, DT, Posture.STANDING)
    feet = soles("broad", body)
    ankles = [foot[0, :2] + (foot[1, :2] - foot[0, :2]) / 3.0 for foot in feet.values()]
    assert all(np.linalg.norm(ankle - [x, 0.0]) < 0.25 for ankle in ankles)
    assert abs(ankles[0][1] - ankles[1][1]) == pytest.approx(0.2, abs=0.06)


def test_slower_walkers_take_shorter_steps() -> None:
    lengths = []
    for speed in (0.3, 0.6, 1.2):
        feet = [soles("slim", body) for body in walk("slim", speed, 6.0)][60:]
        lengths.append(max(abs(foot["left"][1, 0] - foot["right"][1, 0]) for foot in feet))
    assert lengths[0] < lengths[1] < lengths[2]
    assert 0.15 < lengths[0] < 0.40
    assert 0.50 < lengths[2] < 0.80


def test_arms_swing_against_the_legs() -> None:
    bodies = walk("slim", 1.2, 6.0)[60:]
    leg = [soles("slim", body)["left"][1, 0] - body.pose_in_world.x for body in bodies]
    arm = [-body.joints[JOINTS.index("shoulder_pitch_left")] for body in bodies]
    assert np.ptp(arm) > 0.3
    assert np.corrcoef(leg, arm)[0, 1] < -0.9


def test_a_person_turning_on_the_spot_steps_round_without_sliding() -> None:
    gait, bodies = Gait("slim"), []
    for index in range(100):
        bodies.append(gait.advance(Pose2D(0.0, 0.0, min(0.8 * DT * index, 2.0)), 0.0, DT, Posture.STANDING))
    feet = soles("slim", bodies[-1])
    for foot in feet.values():
        direction = math.atan2(foot[1, 1] - foot[0, 1], foot[1, 0] - foot[0, 0])
        assert abs(direction - 2.0) < 0.5
    assert joint_speed(bodies) < 10.0


@pytest.mark.parametrize("speed", [0.35, 0.9, 1.3])
def test_a_walker_who_turns_back_takes_steps_and_no_splits(speed: float) -> None:
    to_and_fro = Walk(waypoints=((1.0, 0.0), (-1.0, 0.0), (1.0, 0.0), (-1.0, 0.0)), speed=speed)
    behaviour, gait, bodies = Walking(Pose2D(-0.3, 0.0, 0.0), to_and_fro), Gait("slim"), []
    nobody = RobotNow(0.0, Pose2D(9.0, 9.0, 0.0), 0.0)
    for _ in range(160):
        for _ in range(12):
            behaviour.advance(nobody, DT / 12.0)
        bodies.append(gait.advance(behaviour.pose_in_world, behaviour.speed, DT, behaviour.posture))
    turns = sum(
        abs(wrap_angle(two.pose_in_world.yaw - one.pose_in_world.yaw)) for one, two in itertools.pairwise(bodies)
    )
    assert turns > math.pi  # it did turn back
    feet = [soles("slim", body) for body in bodies]
    apart = [np.linalg.norm((foot["left"][1] - foot["right"][1])[:2]) for foot in feet]
    assert max(apart) < 1.0  # [m]; a stride at 1.3 m/s is 0.9 m from foot to foot
    assert min(body.root_height for body in bodies) > 0.78
    assert joint_speed(bodies) < 14.0


@pytest.mark.parametrize(("build", "seat"), [("slim", 0.45), ("broad", 0.45)])
def test_a_seated_person_has_the_hips_over_the_seat_and_the_feet_on_the_floor(build: str, seat: float) -> None:
    body = Gait(build).advance(Pose2D(3.0, 1.0, 0.5 * math.pi), 0.0, DT, Posture.SEATED)
    knee, hip = (body.joints[JOINTS.index(f"{name}_left")] for name in ("knee", "hip_pitch"))
    assert (body.pose_in_world.x, body.pose_in_world.y) == (3.0, 1.0)
    assert seat < body.root_height < seat + 0.12
    assert math.degrees(knee) == pytest.approx(90.0, abs=10.0)
    assert math.degrees(hip) + math.degrees(body.root_pitch) == pytest.approx(-90.0, abs=10.0)
    for foot in soles(build, body).values():
        assert abs(foot[:, 2].min()) < 0.02
        assert 0.30 < foot[0, 1] - 1.0 < 0.7


def test_sitting_down_takes_its_time() -> None:
    gait, bodies = Gait("slim"), []
    for index in range(60):
        posture = Posture.STANDING if index < 10 else Posture.SEATED
        bodies.append(gait.advance(Pose2D(0.0, 0.0, 0.0), 0.0, DT, posture))
    assert bodies[0].root_height > 0.85
    assert bodies[-1].root_height < 0.6
    assert joint_speed(bodies) < 4.0


def test_the_same_walk_gives_the_same_joints() -> None:
    assert walk("slim", 0.9, 3.0) == walk("slim", 0.9, 3.0)


def test_an_unknown_build_is_refused() -> None:
    with pytest.raises(BadInputError, match="'slim' or 'broad'"):
        Gait("tall")


@given(
    x=st.floats(-0.35, 0.35),
    y=st.floats(-0.12, 0.12),
    z=st.floats(-0.72, -0.5),
    yaw=st.floats(-0.6, 0.6),
    pitch=st.floats(-0.4, 0.6),
)
@settings(max_examples=200, deadline=None)
def test_leg_angles_put_the_ankle_where_it_was_asked_for(
    x: float, y: float, z: float, yaw: float, pitch: float
) -> None:
    skeleton = skeleton_of("slim")
    angles = leg_angles(skeleton, (x, y, z), yaw, pitch)
    ankle, foot = foot_in_pelvis(skeleton, 0.0, angles)
    assert np.allclose(ankle, (x, y, z), atol=1e-9)
    assert angles[3] >= 0.0
    assert math.asin(-foot[2, 0]) == pytest.approx(pitch, abs=0.05)
