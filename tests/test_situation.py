import math

import numpy as np
import pytest

from han_bullet.device_payload import write_payload
from han_bullet.errors import BadInputError
from han_bullet.geometry import Pose2D
from han_bullet.known_devices import KnownDevices
from han_bullet.messages import Device, DeviceMessage, GoTo, HandOver, PoseEstimate, Posture, TrackedPerson
from han_bullet.situation import Situation

TV = Device("tv", np.array([0.0, 3.0]), on=False)


def at(time: float, pose: Pose2D = Pose2D(0.0, 0.0, 0.0)) -> PoseEstimate:
    return PoseEstimate(time, pose)


def person(x: float, y: float, posture: Posture = Posture.STANDING, number: int = 0) -> TrackedPerson:
    return TrackedPerson(number, 0.0, np.array([x, y]), np.zeros(2), np.eye(4) * 0.01, posture, None)


def test_a_device_that_says_it_is_on_is_on_in_the_scene_and_asks_for_a_new_plan() -> None:
    situation = Situation(task=GoTo(Pose2D(1.0, 0.0, 0.0)), devices=KnownDevices([TV]))
    assert not situation.update(at(0.0), [], [write_payload(DeviceMessage("tv", 0.0, False))]).devices[0].on
    assert not situation.changed
    assert situation.update(at(1.0), [], [write_payload(DeviceMessage("tv", 1.0, True))]).devices[0].on
    assert situation.changed
    situation.update(at(1.1), [])
    assert not situation.changed


def test_a_late_message_does_not_undo_a_newer_one() -> None:
    situation = Situation(task=GoTo(Pose2D(1.0, 0.0, 0.0)), devices=KnownDevices([TV]))
    situation.update(at(2.0), [], [write_payload(DeviceMessage("tv", 2.0, True))])
    assert situation.update(at(2.1), [], [write_payload(DeviceMessage("tv", 1.5, False))]).devices[0].on


def test_a_message_of_an_unknown_device_changes_nothing() -> None:
    situation = Situation(task=GoTo(Pose2D(1.0, 0.0, 0.0)), devices=KnownDevices([TV]))
    scene = situation.update(at(1.0), [], [write_payload(DeviceMessage("radio", 1.0, True))])
    assert [device.name for device in scene.devices] == ["tv"] and not situation.changed


def test_a_change_of_posture_asks_for_a_new_plan_but_a_new_person_does_not() -> None:
    situation = Situation(task=GoTo(Pose2D(1.0, 0.0, 0.0)))
    situation.update(at(0.0), [person(2.0, 0.0)])
    assert not situation.changed
    situation.update(at(0.1), [person(2.0, 0.0, Posture.WALKING)])
    assert situation.changed


def test_a_hand_over_takes_the_nearest_person_to_the_place_and_keeps_their_id() -> None:
    situation = Situation(task=HandOver(np.array([5.0, 0.0])))
    scene = situation.update(at(0.0), [person(5.9, 0.0, number=3), person(5.2, 0.0, number=4)])
    assert scene.task is not None and isinstance(scene.task, HandOver) and scene.task.person == 4
    scene = situation.update(at(0.1), [person(5.0, 0.0, number=3), person(6.0, 0.0, number=4)])
    assert isinstance(scene.task, HandOver) and scene.task.person == 4


@pytest.mark.parametrize(("distance", "meant"), [(1.45, 3), (1.55, None)])
def test_only_somebody_within_one_and_a_half_metres_of_the_place_is_meant(distance: float, meant: int | None) -> None:
    situation = Situation(task=HandOver(np.array([5.0, 0.0])))
    scene = situation.update(at(0.0), [person(5.0, distance, number=3)])
    assert isinstance(scene.task, HandOver) and scene.task.person == meant


def test_the_heading_follows_the_robot_up_to_two_metres_and_no_nearer() -> None:
    """Whatever way the person faced before: from the request on they turn to the robot."""
    situation = Situation(task=HandOver(np.array([5.0, 0.0])))
    taker = TrackedPerson(0, 0.0, np.array([5.0, 0.0]), np.zeros(2), np.eye(4) * 0.01, Posture.STANDING, 0.0)
    headings = []
    for k, (x, y) in enumerate([(5.0, 5.0), (5.0 - 2.1, 0.0), (5.0, -1.9), (5.0, 1.9), (5.0 + 2.1, 0.0)]):
        task = situation.update(at(0.1 * k, pose=Pose2D(x, y, 0.0)), [taker]).task
        assert isinstance(task, HandOver) and task.heading is not None
        headings.append(abs(math.degrees(task.heading)))
    assert headings == pytest.approx([90.0, 180.0, 180.0, 180.0, 0.0])


def test_the_robot_stops_before_the_person_it_hands_over_to_and_faces_them() -> None:
    situation = Situation(task=HandOver(np.array([5.0, 0.0]), distance=0.9))
    situation.update(at(0.0), [person(5.0, 0.0)])
    goal = situation.goal()
    assert (goal.x, goal.y) == pytest.approx((4.1, 0.0))
    assert math.cos(goal.yaw) == pytest.approx(1.0)


def test_the_persons_heading_is_frozen_when_the_robot_is_near() -> None:
    situation = Situation(task=HandOver(np.array([5.0, 0.0])))
    situation.update(at(0.0), [person(5.0, 0.0)])
    scene = situation.update(at(1.0, pose=Pose2D(5.0, 1.5, 0.0)), [person(5.0, 0.0)])
    assert isinstance(scene.task, HandOver) and scene.task.heading is not None
    assert abs(scene.task.heading) == pytest.approx(math.pi)


def test_while_nobody_is_seen_at_the_place_the_robot_comes_near_enough_to_look_and_no_nearer() -> None:
    situation = Situation(task=HandOver(np.array([10.0, 0.0])))
    situation.update(at(0.0), [])
    assert (situation.goal().x, situation.goal().y) == (10.0, 0.0)
    situation.update(at(9.0, pose=Pose2D(8.0, 1.0, 0.3)), [])
    goal = situation.goal()
    assert (goal.x, goal.y) == (8.0, 1.0)
    assert goal.yaw == pytest.approx(math.atan2(-1.0, 2.0))
    assert not situation.goal_is_final


def test_a_person_of_a_hand_over_who_is_out_of_sight_is_still_where_they_were() -> None:
    situation = Situation(task=HandOver(np.array([5.0, 0.0]), distance=0.9))
    situation.update(at(0.0), [person(5.2, 0.1, number=3)])
    situation.update(at(1.0, pose=Pose2D(2.0, 2.0, 0.0)), [])
    goal = situation.goal()
    assert math.dist((goal.x, goal.y), (5.2, 0.1)) == pytest.approx(0.9)
    assert not situation.goal_is_final
    scene = situation.update(at(2.0, pose=Pose2D(2.0, 2.0, 0.0)), [person(5.3, 0.1, number=8)])
    assert isinstance(scene.task, HandOver) and scene.task.person == 8
    assert situation.goal_is_final


def test_somebody_else_at_the_place_gets_a_heading_of_their_own() -> None:
    situation = Situation(task=HandOver(np.array([5.0, 0.0])))
    situation.update(at(0.0), [person(5.0, 0.0, number=3)])
    scene = situation.update(at(1.0, pose=Pose2D(6.5, 0.0, 0.0)), [person(5.0, 0.8, number=8)])
    assert isinstance(scene.task, HandOver) and scene.task.heading == pytest.approx(math.atan2(-0.8, 1.5))


def test_who_has_walked_on_is_looked_for_where_they_were_last_and_then_at_the_place() -> None:
    situation = Situation(task=HandOver(np.array([5.0, 0.0]), distance=0.9))
    situation.update(at(0.0), [person(5.0, 0.0, number=3)])
    situation.update(at(1.0), [person(9.0, 0.0, number=3)])
    scene = situation.update(at(2.0), [person(9.3, 0.0, number=4)])
    assert isinstance(scene.task, HandOver) and scene.task.person == 4
    situation.update(at(3.0, pose=Pose2D(8.3, 0.0, 0.0)), [])
    assert situation.goal().position == pytest.approx([5.0, 0.0])


def test_without_a_task_there_is_no_goal_and_the_scene_has_none() -> None:
    situation = Situation(task=None)
    assert situation.update(at(0.0), [person(2.0, 0.0)]).task is None
    assert situation.goal() is None


def test_another_hand_over_forgets_whom_the_old_one_had_chosen() -> None:
    situation = Situation(task=HandOver(np.array([5.0, 0.0])))
    people = [person(5.0, 0.0, number=3), person(9.0, 0.0, number=4)]
    old = situation.update(at(0.0), people).task
    assert isinstance(old, HandOver) and old.heading is not None
    situation.take(HandOver(np.array([9.0, 0.0]), heading=old.heading, position_in_world=old.position_in_world))
    task = situation.update(at(0.1), people).task
    assert isinstance(task, HandOver) and task.person == 4 and task.position_in_world == pytest.approx([9.0, 0.0])


def test_a_hand_over_to_somebody_is_meant_where_they_are_now() -> None:
    situation = Situation(task=None)
    situation.update(at(0.0), [person(5.0, 0.0, number=3), person(5.2, 0.0, number=4)])
    meant = situation.take(HandOver(np.array([5.0, 0.0]), person=4))
    assert isinstance(meant, HandOver) and meant.place_in_world == pytest.approx([5.2, 0.0])
    task = situation.update(at(0.1), [person(5.0, 0.0, number=3), person(5.4, 0.0, number=4)]).task
    assert isinstance(task, HandOver) and task.person == 4


def test_a_hand_over_to_nobody_is_refused_and_the_old_task_stays() -> None:
    situation = Situation(task=GoTo(Pose2D(1.0, 2.0, 0.0)))
    for people, right in (([], "a place, as nobody is tracked now,"), ([person(1.0, 0.0, number=2)], "one of 2")):
        situation.update(at(0.0), people)
        with pytest.raises(BadInputError, match=f"person 7 of the hand-over is not tracked; {right} would be right"):
            situation.take(HandOver(np.array([5.0, 0.0]), person=7))
        assert situation.goal() == Pose2D(1.0, 2.0, 0.0)
