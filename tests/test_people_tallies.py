"""Zones, intrusion and time to collision, on ticks whose figures can be worked out by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ticks import person, tick

from han_bullet.metrics.collision_course import CollisionCourseTally, time_to_collision
from han_bullet.metrics.distances import DistanceTally
from han_bullet.metrics.intrusion import IntrusionTally, kirbys_gaussian

REACH = 0.3 + 0.25


def zones(*gaps: float) -> list[object]:
    """Intimate, personal, social and public share of ticks with these gaps between the surfaces [m]."""
    tally = DistanceTally(["near", "far"], 0.3)
    for index, gap in enumerate(gaps):
        tally.record(tick(index, people=[person("far", 9.0), person("near", 0.0, gap + REACH)]))
    values = tally.values()
    return [values[f"{zone}_zone_share"] for zone in ("intimate", "personal", "social", "public")]


def test_zones_are_told_by_the_gap_to_the_nearest_person_lower_ends_included() -> None:
    assert zones(-0.1, 0.0, 0.449, 0.4501) == [0.75, 0.25, 0.0, 0.0]
    assert zones(1.199, 1.2001, 3.599, 3.6001) == [0.0, 0.25, 0.5, 0.25]


def test_without_people_everything_is_public() -> None:
    tally = DistanceTally([], 0.3)
    tally.record(tick(0))
    assert tally.values()["public_zone_share"] == 1.0


@given(st.lists(st.floats(-0.5, 8.0), min_size=1, max_size=20))
def test_the_four_zones_sum_to_one(gaps: list[float]) -> None:
    assert sum(zones(*gaps)) == pytest.approx(1.0)  # type: ignore[arg-type]


@pytest.mark.parametrize(("speed", "ahead"), [(0.0, 0.5), (0.25, 0.5), (0.6, 1.2)])
def test_kirbys_gaussian_falls_to_exp_of_minus_a_half_at_its_deviations(speed: float, ahead: float) -> None:
    walker = person(x=1.0, y=2.0, yaw=0.8, speed=speed)
    places = walker.pose_in_world.to_world(np.array([[ahead, 0.0], [0.0, 2 * ahead / 3], [-ahead / 2, 0.0]]))
    assert [kirbys_gaussian(walker, place) for place in places] == pytest.approx([math.exp(-0.5)] * 3)
    assert kirbys_gaussian(walker, walker.pose_in_world.position) == 1.0


def test_intrusion_is_the_mean_over_ticks_of_the_deepest() -> None:
    tally = IntrusionTally(["anna", "bob"])
    # Anna faces the robot at 0.5 m: exp(-1/2). Bob has it at 1/3 m beside him: exp(-1/2). Then both are far.
    at_anna = [person("anna", 0.5, yaw=math.pi), person("bob", -50.0)]
    at_bob = [person("anna", 50.0), person("bob", 0.0, 1.0 / 3.0)]
    both = [person("anna", 0.5, yaw=math.pi), person("bob", 0.0, 1.0 / 3.0)]
    nobody = [person("anna", 50.0), person("bob", 50.0)]
    for index, people in enumerate([at_anna, at_bob, both, nobody]):
        tally.record(tick(index, people=people))
    values, depth = tally.values(), math.exp(-0.5)
    assert values["personal_space_intrusion"] == pytest.approx(3.0 * depth / 4.0)
    assert values["personal_space_intrusion.anna"] == pytest.approx(2.0 * depth / 4.0)
    assert values["personal_space_intrusion.bob"] == pytest.approx(2.0 * depth / 4.0)


def test_two_discs_that_meet_head_on_touch_when_the_gap_is_closed() -> None:
    assert time_to_collision(np.array([3.0, 0.0]), np.array([-1.0, 0.0]), 0.5) == pytest.approx(2.5)


def test_off_the_centre_line_they_touch_later_and_beyond_the_reach_never() -> None:
    # 0.4 m aside with a reach of 0.5 m: they touch 0.3 m before they are level.
    assert time_to_collision(np.array([3.0, 0.4]), np.array([-1.0, 0.0]), 0.5) == pytest.approx(2.7)
    assert time_to_collision(np.array([3.0, 0.51]), np.array([-1.0, 0.0]), 0.5) == math.inf
    assert time_to_collision(np.array([3.0, 0.0]), np.array([1.0, 0.0]), 0.5) == math.inf
    assert time_to_collision(np.array([3.0, 0.0]), np.array([0.0, 0.0]), 0.5) == math.inf
    assert time_to_collision(np.array([3.0, 0.0]), np.array([-1e-20, 0.0]), 0.5) == math.inf


def test_discs_that_overlap_have_no_time_left() -> None:
    assert time_to_collision(np.array([0.3, 0.0]), np.array([1.0, 0.0]), 0.5) == 0.0


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(-2, 2), st.floats(-2, 2))
def test_at_the_time_to_collision_the_discs_touch(x: float, y: float, vx: float, vy: float) -> None:
    offset, velocity = np.array([x, y]), np.array([vx, vy])
    time = time_to_collision(offset, velocity, 0.55)
    if 0.0 < time < math.inf:
        assert math.hypot(*(offset + time * velocity)) == pytest.approx(0.55, abs=1e-6)


def test_the_least_time_over_ticks_and_people_counts() -> None:
    tally = CollisionCourseTally(0.3)
    people = [person("anna", 4.55, yaw=math.pi, speed=0.5), person("bob", 0.0, 9.0)]
    tally.record(tick(0, twist=(0.5, 0.0, 0.0), people=people))  # 4 m at 1 m/s
    tally.record(tick(1, robot=(0.0, 0.0, math.pi / 2), twist=(0.5, 0.0, 0.0), people=people))  # towards bob: 16.9 s
    assert tally.values()["minimum_time_to_collision"] == pytest.approx(4.0)
