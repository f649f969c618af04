import json
import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.device_channel import EmbeddedChannel
from han_bullet.geometry import Pose2D, wrap_angle
from han_bullet.messages import Posture
from han_bullet.sim.behaviours import Behaviour, Sitting, Standing, Walking, behaviour_of
from han_bullet.sim.devices import Television
from han_bullet.sim.trigger import RobotNow, StartSignal
from han_bullet.world_file import load_world
from han_bullet.world_schema import TV, Person, Sit, Trigger, Walk

STEP = 1.0 / 240.0
FAR_ROBOT = Pose2D(-50.0, 0.0, 0.0)


def robot(
    time: float = 0.0, pose: Pose2D = FAR_ROBOT, speed: float = 0.0, asks: bool = False, wants_way: bool = False
) -> RobotNow:
    return RobotNow(time, pose, speed, asks, wants_way)


def let_go_on(behaviour: Behaviour, seconds: float, start: float = 0.0, **around: object) -> list[Pose2D]:
    poses = []
    for step in range(round(seconds / STEP)):
        behaviour.advance(robot(start + step * STEP, **around), STEP)  # type: ignore[arg-type]
        poses.append(behaviour.pose_in_world)
    return poses


def test_a_walker_reaches_its_speed_in_half_a_second_and_keeps_it() -> None:
    walker = Walking(Pose2D(0.0, 0.0, 0.0), Walk(waypoints=((5.0, 0.0),), speed=0.8))
    let_go_on(walker, 0.25)
    assert walker.speed == pytest.approx(0.4, abs=0.01)
    assert walker.posture is Posture.WALKING
    let_go_on(walker, 0.35)
    assert walker.speed == pytest.approx(0.8)
    assert walker.velocity_in_world == pytest.approx([0.8, 0.0])


def test_a_walker_ends_standing_at_the_last_waypoint() -> None:
    walker = Walking(Pose2D(0.0, 0.0, 0.0), Walk(waypoints=((1.5, 0.0), (1.5, 2.0)), speed=0.6))
    let_go_on(walker, 9.0)
    assert walker.pose_in_world.distance_to(np.array([1.5, 2.0])) < 0.05
    assert walker.speed == pytest.approx(0.0, abs=1e-6)
    assert walker.posture is Posture.STANDING
    assert walker.pose_in_world.yaw == pytest.approx(0.5 * math.pi, abs=0.1)


@settings(max_examples=25, deadline=None)
@given(
    yaw=st.floats(-3.1, 3.1),
    speed=st.floats(0.2, 1.2),
    points=st.lists(st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)), min_size=1, max_size=3),
)
def test_walkers_move_smoothly_and_arrive_wherever_they_are_sent(
    yaw: float, speed: float, points: list[tuple[float, float]]
) -> None:
    walker = Walking(Pose2D(0.0, 0.0, yaw), Walk(waypoints=tuple(points), speed=speed))
    corners = np.array([(0.0, 0.0), *points])
    length = float(np.linalg.norm(np.diff(corners, axis=0), axis=1).sum())
    poses = [Pose2D(0.0, 0.0, yaw), *let_go_on(walker, length / speed + 4.0 * len(points) + 2.0)]
    assert walker.pose_in_world.distance_to(np.array(points[-1])) < 0.1
    places = np.array([(pose.x, pose.y) for pose in poses])
    velocities = np.diff(places, axis=0) / STEP
    assert np.linalg.norm(velocities, axis=1).max() <= speed * 1.001
    turns = np.array([wrap_angle(after.yaw - before.yaw) for before, after in pairwise(poses)])
    assert np.abs(turns).max() / STEP <= 2.001  # [rad/s]
    assert np.abs(np.diff(turns)).max() / STEP**2 <= 8.01  # [rad/s^2]
    assert np.linalg.norm(np.diff(velocities, axis=0), axis=1).max() / STEP < 2.0 * speed + 2.0 * speed + 0.1


def test_a_walker_waits_for_the_robot_to_move_and_then_for_the_delay() -> None:
    trigger = Trigger(when="robot_moves", delay=1.0)
    walker = Walking(Pose2D(0.0, 0.0, 0.0), Walk(waypoints=((5.0, 0.0),), speed=0.5, starts=trigger))
    let_go_on(walker, 2.0, speed=0.04)
    assert walker.speed == 0.0
    let_go_on(walker, 0.1, start=2.0, speed=0.06)
    let_go_on(walker, 0.85, start=2.1)  # the robot stands again: the event counts, not the state
    assert walker.speed == 0.0
    let_go_on(walker, 0.6, start=2.95)
    assert walker.speed == pytest.approx(0.5)


def test_a_trigger_by_time_fires_at_its_delay() -> None:
    signal = StartSignal(Trigger(when="time", delay=3.0))
    here = np.zeros(2)
    assert not signal.given(robot(2.99), here)
    assert signal.given(robot(3.0), here)


def test_a_trigger_by_nearness_fires_within_its_distance_of_the_one_who_waits() -> None:
    signal = StartSignal(Trigger(when="robot_near", distance=2.0, delay=0.5))
    here = np.array([1.0, 1.0])
    assert not signal.given(robot(1.0, Pose2D(1.0, 3.1, 0.0)), here)
    assert not signal.given(robot(2.0, Pose2D(1.0, 2.9, 0.0)), here)
    assert not signal.given(robot(2.4, Pose2D(9.0, 9.0, 0.0)), here)
    assert signal.given(robot(2.5, Pose2D(9.0, 9.0, 0.0)), here)


def test_a_walker_makes_way_once_asked_and_does_not_come_back_when_the_robot_asks_no_more() -> None:
    walk = Walk(waypoints=((0.0, 1.0),), speed=0.7, starts=Trigger(when="robot_asks", delay=0.5))
    walker = Walking(Pose2D(0.0, 0.0, 0.0), walk)
    assert all(pose == Pose2D(0.0, 0.0, 0.0) for pose in let_go_on(walker, 2.0, pose=Pose2D(-1.0, 0.0, 0.0), asks=True))
    let_go_on(walker, 0.1, start=2.0, wants_way=True)
    let_go_on(walker, 0.35, start=2.1)
    assert walker.speed == 0.0
    let_go_on(walker, 6.0, start=2.45)
    assert walker.pose_in_world.distance_to(np.array([0.0, 1.0])) < 0.05


def test_someone_asked_for_a_hand_over_turns_to_the_robot_within_its_rate() -> None:
    person = Standing(Pose2D(0.0, 0.0, 0.0), turns_to_robot=True)
    there = Pose2D(-3.0, 0.5, 0.0)
    assert all(pose.yaw == 0.0 for pose in let_go_on(person, 1.0, pose=there))
    poses = let_go_on(person, 4.0, pose=there, asks=True)
    yaws = np.unwrap([pose.yaw for pose in poses])
    assert np.abs(np.diff(yaws)).max() / STEP <= 1.501
    assert person.pose_in_world.yaw == pytest.approx(math.atan2(0.5, -3.0), abs=0.02)
    let_go_on(person, 1.0, pose=Pose2D(3.0, 0.0, 0.0))
    assert person.pose_in_world.yaw == pytest.approx(math.atan2(0.5, -3.0), abs=0.02)


def test_someone_asked_for_a_hand_over_does_not_turn_on_after_a_robot_nearer_than_two_metres() -> None:
    person = Standing(Pose2D(0.0, 0.0, 0.0), turns_to_robot=True)
    let_go_on(person, 4.0, pose=Pose2D(0.0, 2.1, 0.0), asks=True)
    let_go_on(person, 4.0, pose=Pose2D(-1.5, 0.0, 0.0), asks=True, start=4.0)
    assert person.pose_in_world.yaw == pytest.approx(math.pi / 2, abs=0.02)
    let_go_on(person, 1.0, pose=Pose2D(-1.5, 0.0, 0.0), start=8.0)
    let_go_on(person, 4.0, pose=Pose2D(-1.5, 0.0, 0.0), asks=True, start=9.0)  # asked anew, and by one that is near
    assert abs(person.pose_in_world.yaw) == pytest.approx(math.pi, abs=0.02)


def test_someone_who_was_not_told_to_turn_does_not() -> None:
    person = Standing(Pose2D(0.0, 0.0, 0.3))
    let_go_on(person, 1.0, pose=Pose2D(-2.0, 0.0, 0.0), asks=True)
    assert person.pose_in_world == Pose2D(0.0, 0.0, 0.3)


def test_someone_seated_has_the_seats_pose() -> None:
    world = load_world("real2")
    person = Person(name="viewer", start=(1.0, 1.0, 0.0), behaviour=Sit(on="couch"))
    seated = behaviour_of(person, world)
    assert isinstance(seated, Sitting)
    let_go_on(seated, 0.5)
    assert seated.pose_in_world == Pose2D(19.5, -0.4, -1.5708)
    assert seated.posture is Posture.SEATED


def test_a_television_tells_its_state_at_first_when_it_changes_and_every_second() -> None:
    television = Television(TV(name="tv", position=(0.0, 0.0), facing=0.0, turns_on=Trigger(delay=1.5)))
    channel, told = EmbeddedChannel(), []
    for tick in range(50):
        television.advance(robot(0.05 * tick))
        television.tell(0.05 * tick, channel)
        told += [json.loads(payload) for payload in channel.receive()]
    assert [(round(one["time"], 9), one["on"]) for one in told] == [(0.0, False), (1.0, False), (1.5, True)]
