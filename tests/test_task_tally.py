"""Success, shortest ways, SPL and progress, on ticks whose figures can be worked out by hand."""

from collections.abc import Iterable

import numpy as np
import pytest
from ticks import make_world, person, tick

from han_bullet.episode import Tick
from han_bullet.messages import Contact, Status
from han_bullet.metrics import Metrics, Value


def measure(ticks: Iterable[Tick], *people: str, **world: object) -> dict[str, Value]:
    """The figures of a run in a room of 20 m x 4 m; the goal is (18, 0)."""
    metrics = Metrics(make_world(*people, **world))
    for one in ticks:
        metrics.record(one)
    return {metric.name: metric.value for metric in metrics.results()}


def along(*places: tuple[float, float], arrives: bool = True) -> list[Tick]:
    last = Status.ARRIVED if arrives else Status.BLOCKED
    return [
        tick(i, robot=(*place, 0.0), status=last if i == len(places) - 1 else Status.MOVING)
        for i, place in enumerate(places)
    ]


def test_a_run_succeeds_where_it_arrives_and_touches_nothing() -> None:
    assert measure(along((1.0, 0.0), (18.0, 0.0)))["success"] is True
    assert measure(along((1.0, 0.0), (18.0, 0.0), arrives=False))["success"] is False


def test_a_run_succeeds_only_where_the_robot_truly_is_at_its_goal() -> None:
    near, far = (measure(along((1.0, 0.0), (18.0, y))) for y in (0.29, 0.31))
    assert (near["success"], near["goal_distance"]) == (True, pytest.approx(0.29))
    assert (far["success"], far["spl"], far["outcome"]) == (False, 0.0, "arrived")
    turned = measure([tick(0), tick(1, robot=(18.0, 0.0, -3.0), status=Status.ARRIVED), tick(2, robot=(9.0, 0.0, 0.0))])
    assert (turned["goal_distance"], turned["goal_yaw_error"]) == (0.0, pytest.approx(3.0))
    assert measure(along((1.0, 0.0), (18.0, 0.0), arrives=False))["goal_distance"] is None


@pytest.mark.parametrize("kind", ["wall", "object", "person"])
def test_a_robot_that_hit_something_on_its_way_did_not_succeed(kind: str) -> None:
    scene = {"twist": (0.5, 0.0, 0.0), "people": [person(x=0.5)], "contacts": [Contact("walker", kind, -0.01)]}
    values = measure([tick(0, **scene), tick(1, robot=(18.0, 0.0, 0.0), status=Status.ARRIVED)], "walker")
    assert (values["outcome"], values["success"], values["spl"]) == ("arrived", False, 0.0)


def test_a_robot_that_somebody_walked_into_may_have_succeeded() -> None:
    contact = Contact("walker", "person", -0.01)
    ticks = [
        tick(0, people=[person(x=0.5, yaw=np.pi, speed=0.5)], contacts=[contact]),
        tick(1, robot=(18.0, 0.0, 0.0), status=Status.ARRIVED),
    ]
    values = measure(ticks, "walker")
    assert (values["contacts_by_person"], values["success"]) == (1, True)


def test_spl_is_the_shortest_way_over_ones_own() -> None:
    # Out to (9.5, 1.5) and back: 2 sqrt(8.5^2 + 1.5^2) = 17.263 m instead of 17 m.
    values = measure(along((1.0, 0.0), (9.5, 1.5), (18.0, 0.0)))
    assert values["shortest_path_length"] == pytest.approx(17.0)
    assert values["path_length"] == pytest.approx(17.2627, abs=1e-4)
    assert values["spl"] == pytest.approx(17.0 / 17.2627, abs=1e-5)


def test_who_stops_short_within_the_tolerance_gains_nothing() -> None:
    assert measure(along((1.0, 0.0), (17.9, 0.0)))["spl"] == 1.0


def test_an_episode_that_begins_at_its_goal_has_an_spl_of_one() -> None:
    values = measure(along((18.0, 0.0), (18.0, 0.0)))
    assert (values["shortest_path_length"], values["spl"]) == (0.0, 1.0)


def test_the_shortest_way_goes_around_walls_at_the_robots_radius() -> None:
    # The wall is 0.1 m thick and ends at y = 0.5: the disc of 0.3 m passes its corners (9.45 and 9.55, 0.5). By hand:
    # tangents of sqrt(8.45^2 + 0.5^2 - 0.3^2) = 8.4595 m from (1, 0) and (18, 0) to circles of 0.3 m about them, two
    # arcs of 0.3 (atan(0.5 / 8.45) + asin(0.3 / 8.4648)) = 0.0284 m, and 0.1 m between: 17.0757 m.
    wall = {"walls": [{"start": [9.5, -2.0], "end": [9.5, 0.5]}]}
    values = measure(along((1.0, 0.0), (18.0, 0.0)), **wall)
    assert values["shortest_path_length"] == pytest.approx(17.0757, abs=0.02)


def test_where_walls_leave_no_way_there_is_no_shortest_one_to_compare_with() -> None:
    values = measure(along((1.0, 0.0), (9.0, 0.0), arrives=False), walls=[{"start": [9.5, -2.0], "end": [9.5, 2.0]}])
    assert [values[name] for name in ("shortest_path_length", "spl", "failure_to_progress")] == [None, None, None]


def test_of_a_hand_over_the_stop_before_the_person_is_the_goal() -> None:
    task = {"task": {"kind": "hand_over", "place": [6.0, 0.0], "distance": 0.9}}
    assert measure(along((1.0, 0.0), (5.1, 0.0)), "walker", **task)["shortest_path_length"] == pytest.approx(4.1)


def drive(*speeds: float) -> list[Tick]:
    """5 s of each speed along x, from x = 1."""
    places = 1.0 + 0.05 * np.cumsum(np.concatenate([[0.0], np.repeat(speeds, 100)]))
    return [tick(i, robot=(x, 0.0, 0.0)) for i, x in enumerate(places)]


def test_failures_to_progress_are_windows_of_five_seconds_with_less_than_a_tenth_of_a_metre() -> None:
    # 0.5 m, 0.095 m, -0.5 m, 0.105 m and an unfinished window of nothing.
    ticks = [*drive(0.1, 0.019, -0.1, 0.021), *(tick(401 + i, robot=(1.2, 0.0, 0.0)) for i in range(90))]
    assert measure(ticks)["failure_to_progress"] == 2


def test_windows_of_progress_end_with_the_arrival() -> None:
    arrived = [tick(101 + i, robot=(1.5, 0.0, 0.0), status=Status.ARRIVED) for i in range(300)]
    assert measure([*drive(0.1), *arrived])["failure_to_progress"] == 0


def test_a_detour_that_leads_away_from_the_goal_is_progress() -> None:
    # From the pocket of a U that opens away from the goal, out and around: the straight distance grows.
    walls = [
        {"start": [9.0, -1.0], "end": [9.0, 1.0]},
        {"start": [6.0, 1.0], "end": [9.0, 1.0]},
        {"start": [6.0, -1.0], "end": [9.0, -1.0]},
    ]
    ticks = [tick(i, robot=(8.5 - 0.005 * i, 0.0, 0.0)) for i in range(401)]
    assert measure(ticks, walls=walls)["failure_to_progress"] == 0
    back = [tick(i, robot=(6.5 + 0.005 * i, 0.0, 0.0)) for i in range(401)]
    assert measure(back, walls=walls)["failure_to_progress"] == 4
