"""Sides, seats, televisions and hand-overs, on ticks whose figures can be worked out by hand."""

import math

import numpy as np
import pytest
from ticks import person, tick

from han_bullet.geometry import Pose2D
from han_bullet.messages import Device, Path, Scene, Seat, Status
from han_bullet.metrics.hand_over import HandOverTally
from han_bullet.metrics.passing import PassingTally
from han_bullet.metrics.seated import SeatedTally, TransitTally, behind_seated
from han_bullet.world_schema import HandOverTask

COUCH = Seat("couch", np.array([0.0, 0.0]), 0.0, 0.8, 1.9, "tv")


@pytest.mark.parametrize(("lateral", "side"), [(0.8, "left"), (-0.8, "right")])
@pytest.mark.parametrize("yaw", [0.0, 2.0])
def test_the_side_is_that_of_the_robots_motion_when_nearest_wherever_it_faces(
    lateral: float, side: str, yaw: float
) -> None:
    tally = PassingTally(["anna"])
    for index, x in enumerate(np.arange(-3.0, 3.0, 0.05)):
        twist = (math.cos(yaw), -math.sin(yaw), 0.0)  # along the world's x axis
        tally.record(tick(index, robot=(x, 0.0, yaw), twist=twist, people=[person("anna", 0.0, lateral)]))
    assert tally.values() == {"passing_side.anna": side}


def test_a_robot_that_never_moved_passed_nobody() -> None:
    tally = PassingTally(["anna"])
    tally.record(tick(people=[person("anna", 1.0, 1.0)]))
    assert tally.values() == {"passing_side.anna": None}


def test_behind_a_seated_person_is_a_lobe_that_ends_at_their_shoulders() -> None:
    viewer = person(x=1.0, y=2.0, yaw=0.5 * math.pi, posture="seated")
    assert behind_seated(viewer, np.array([1.0, 0.8])) == pytest.approx(math.exp(-0.5))
    assert behind_seated(viewer, np.array([1.8, 2.0 - 1e-9])) == pytest.approx(math.exp(-0.5))
    assert behind_seated(viewer, np.array([1.0, 2.1])) == 0.0
    assert behind_seated(viewer, np.array([1.0, 0.0])) < 0.25  # 2.0 m behind


def test_only_seated_people_have_somebody_behind_them_and_the_worst_moment_counts() -> None:
    tally = SeatedTally(["viewer"])
    for index, x in enumerate((-3.0, -1.2, -2.0)):
        posture = "seated" if index < 2 else "standing"
        tally.record(tick(index, robot=(x, 0.0, 0.0), people=[person("viewer", posture=posture)]))
    assert tally.values() == {"behind_seated.viewer": pytest.approx(math.exp(-0.5))}


def scene(on: bool) -> Scene:
    return Scene(0.0, devices=(Device("tv", np.array([3.0, 0.0]), on),))


def test_time_between_a_viewer_and_the_television_is_told_apart_by_its_state() -> None:
    tally = TransitTally([COUCH], {"tv": np.array([3.0, 0.0])}, {"viewer": "couch"})
    viewer = person("viewer", posture="seated")
    places = [(1.5, 1.4), (1.5, 1.6), (2.9, 0.0), (1.5, -1.4)]  # in the disc of radius 1.5 about (1.5, 0) but for one
    for index, (x, y) in enumerate(places):
        tally.record(tick(index, robot=(x, y, 0.0), people=[viewer], devices_on=[("tv", index == 3)]))
    assert tally.values()["transit_time_off.tv"] == pytest.approx(0.10)
    assert tally.values()["transit_time_on.tv"] == pytest.approx(0.05)


def test_nobody_on_the_couch_means_nothing_to_cross() -> None:
    tally = TransitTally([COUCH], {"tv": np.array([3.0, 0.0])}, {"viewer": "couch"})
    tally.record(tick(robot=(1.5, 0.0, 0.0), people=[person("viewer")], devices_on=[("tv", True)]))
    tally.record(tick(1, robot=(1.5, 0.0, 0.0), people=[person("other", posture="seated")], devices_on=[("tv", True)]))
    assert tally.values()["transit_time_on.tv"] == 0.0


def test_the_delay_of_a_new_plan_ends_with_a_search_that_knows_the_new_state() -> None:
    tally = TransitTally([COUCH], {"tv": np.array([3.0, 0.0])}, {})
    way = np.array([[0.0, 0.0], [1.0, 0.0]])
    searched, kept = Path(way, 1.0, expanded=9), Path(way, 1.0)
    for index, (on, known, path) in enumerate(
        [(False, False, searched), (True, False, searched), (True, True, kept), (True, True, searched)]
    ):
        tally.record(tick(index, devices_on=[("tv", on)], scene=scene(known), path=path))
    assert tally.values()["replan_delay.tv"] == pytest.approx(0.10)


def test_a_television_that_stays_off_has_no_delay() -> None:
    tally = TransitTally([COUCH], {"tv": np.array([3.0, 0.0])}, {})
    tally.record(tick(devices_on=[("tv", False)], scene=scene(False)))
    assert tally.values()["replan_delay.tv"] is None


def hand_over(*ticks: tuple[Pose2D, float, Status]) -> HandOverTally:
    """A person at (5, 0) with some yaw, and somebody else farther from the place."""
    tally = HandOverTally(HandOverTask(place=(5.3, 0.0)))
    for index, (robot, yaw, status) in enumerate(ticks):
        people = [person("other", 7.0, 0.0), person("taker", 5.0, 0.0, yaw)]
        tally.record(tick(index, robot=(robot.x, robot.y, robot.yaw), people=people, status=status))
    return tally


def test_a_hand_over_is_measured_at_its_end_and_when_it_first_came_near() -> None:
    values = hand_over(
        (Pose2D(2.0, 0.0, 0.0), 0.0, Status.MOVING),
        (Pose2D(3.9, 0.0, 0.0), math.pi - 0.5, Status.MOVING),
        (Pose2D(4.1, 0.0, 0.1), math.pi + 0.2, Status.ARRIVED),
    ).values()
    assert values["hand_over_distance"] == pytest.approx(0.9)
    assert values["hand_over_bearing"] == pytest.approx(0.2)
    assert values["hand_over_facing"] == pytest.approx(0.1)
    assert values["hand_over_early_bearing"] == pytest.approx(0.5)


def test_a_hand_over_that_never_arrives_has_no_figures() -> None:
    assert set(hand_over((Pose2D(2.0, 0.0, 0.0), 0.0, Status.MOVING)).values().values()) == {None}
