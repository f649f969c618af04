"""When the planner searches, what it keeps, whom it follows."""

import math
from collections.abc import Sequence

import numpy as np
import pytest

from han_bullet.costmap.grid import INSCRIBED, LETHAL, Costmap
from han_bullet.costmap.layers import standard_layers
from han_bullet.errors import BadInputError
from han_bullet.messages import HandOver, Path, Posture, Scene, TrackedPerson
from han_bullet.planning.astar import astar
from han_bullet.planning.planner import FOLLOW_GAP, Planner, survey

START, GOAL = np.array([0.5, 0.0]), np.array([9.5, 0.0])


def corridor() -> Costmap:
    return Costmap.covering([((0.0, 10.0), (-1.5, 1.5))], 0.05)


def raised(costmap: Costmap, x: float, y: float, radius: float, value: int) -> Costmap:
    window, xs, ys = costmap.centres_in_window(np.array([x, y]), radius)
    costmap.raise_to(window, (value * (np.hypot(xs - x, ys - y) <= radius)).astype(np.uint8))
    return costmap


def side(points: np.ndarray, x: float = 5.0) -> float:
    """y of a way where it passes x."""
    return float(points[np.abs(points[:, 0] - x).argmin(), 1])


def searched(path: Path | None) -> bool:
    """Whether a search ran for a way: one that is only kept has expanded no cell."""
    assert path is not None
    return path.expanded > 0


def test_it_searches_once_per_period_and_at_once_when_it_is_urgent() -> None:
    planner, costmap = Planner(replan_period=0.25), corridor()
    ways = [planner.update(costmap, START, GOAL, 0.05 * tick, urgent=False) for tick in range(20)]
    assert [tick for tick, way in enumerate(ways) if searched(way)] == [0, 5, 10, 15]
    assert searched(planner.update(costmap, START, GOAL, 1.0, urgent=False))
    assert searched(planner.update(costmap, START, GOAL, 1.05, urgent=True))
    assert not searched(planner.update(costmap, START, GOAL, 1.1, urgent=False))


def test_the_way_begins_at_the_robot_and_loses_what_lies_behind_it() -> None:
    planner, costmap = Planner(), corridor()
    planner.update(costmap, START, GOAL, 0.0, urgent=False)
    robot = np.array([3.013, 0.06])
    path = planner.update(costmap, robot, GOAL, 0.05, urgent=False)
    assert path is not None and not searched(path)
    assert np.array_equal(path.points_in_world[0], robot)
    assert path.points_in_world[1:, 0].min() > 3.0
    assert path.points_in_world[-1] == pytest.approx(costmap.cell_to_world(costmap.world_to_cell(GOAL)))
    assert path.cost == pytest.approx(6.52, abs=0.03)


def two_lanes(left: int, right: int) -> Costmap:
    """A pillar at (5, 0) with a metre of costs to its left and to its right; 25 of them are a tenth of the way."""
    costmap = corridor()
    costmap.cost[34:, 90:110], costmap.cost[:26, 90:110], costmap.cost[26:34, 90:110] = left, right, LETHAL
    return costmap


@pytest.mark.parametrize(("gain", "flips_for_a_bit"), [(0.1, False), (0.0, True)])
def test_the_old_way_is_kept_while_it_is_no_more_than_a_tenth_dearer(gain: float, flips_for_a_bit: bool) -> None:
    planner = Planner(switch_gain=gain)
    ways = [
        planner.update(two_lanes(left, right), START, GOAL, time, urgent=False)
        for time, left, right in [(0.0, 10, 60), (1.0, 40, 30), (2.0, 200, 30)]
    ]
    sides = [side(way.points_in_world) for way in ways if way is not None]
    assert sides[0] > 0.15 and sides[2] < -0.15
    assert (sides[1] < -0.15) == flips_for_a_bit
    assert (sides[1] > 0.15) == (not flips_for_a_bit)


def test_a_kept_way_that_gets_blocked_is_replaced_at_once() -> None:
    planner = Planner()
    planner.update(corridor(), START, GOAL, 0.0, urgent=False)
    path = planner.update(raised(corridor(), 5.0, 0.1, 0.6, LETHAL), START, GOAL, 0.05, urgent=False)
    assert searched(path)
    assert path is not None and side(path.points_in_world) < -0.4


def test_without_a_free_way_there_is_none_and_it_is_looked_for_every_period() -> None:
    planner, closed = Planner(replan_period=0.25), corridor()
    planner.update(closed, START, GOAL, 0.0, urgent=False)
    closed.cost[:, 100] = LETHAL
    ways = [planner.update(closed, START, GOAL, 0.05 * tick, urgent=False) for tick in range(1, 21)]
    assert ways == [None] * 20
    # Lost at 0.05 s, looked for at 0.30, 0.55, 0.80 s and now at 1.05 s.
    assert planner.update(closed, START, GOAL, 1.05, urgent=False) is None
    open_again = [planner.update(corridor(), START, GOAL, 1.05 + 0.05 * tick, urgent=False) for tick in range(1, 6)]
    assert [way is None for way in open_again] == [True] * 4 + [False]


def test_a_goal_that_creeps_takes_the_end_of_the_way_along_and_one_that_jumps_makes_a_new_way() -> None:
    planner, costmap = Planner(), corridor()
    planner.update(costmap, START, GOAL, 0.0, urgent=False)
    crept = planner.update(costmap, START, GOAL + np.array([0.0, 0.1]), 0.05, urgent=False)
    assert crept is not None and not searched(crept)
    assert np.abs(crept.points_in_world[-1] - GOAL - [0.0, 0.1]).max() <= 0.025 + 1e-9
    assert searched(planner.update(costmap, START, GOAL - np.array([2.0, 0.0]), 0.1, urgent=False))


def test_a_robot_pushed_off_its_way_plans_anew() -> None:
    planner, costmap = Planner(), corridor()
    planner.update(costmap, START, GOAL, 0.0, urgent=False)
    assert searched(planner.update(costmap, START + np.array([1.0, 0.9]), GOAL, 0.05, urgent=False))


def abreast(posture: Posture) -> tuple[Costmap, list[TrackedPerson]]:
    costmap, people = corridor(), []
    for index, y in enumerate((-0.75, 0.75)):
        raised(costmap, 5.0, y, 0.78, LETHAL)
        people.append(
            TrackedPerson(index, 0.0, np.array([5.0, y]), np.array([0.4, 0.0]), 0.01 * np.eye(4), posture, 0.0)
        )
    assert astar(costmap, START, GOAL) is None
    return costmap, people


def test_two_people_who_walk_abreast_are_followed_at_a_distance() -> None:
    costmap, people = abreast(Posture.WALKING)
    planner = Planner()
    for tick in range(4):
        path = planner.update(costmap, START, GOAL, 0.05 * tick, False, people)
        assert path is not None
        end = path.points_in_world[-1]
        blocked = costmap.cell_to_world(np.argwhere(costmap.cost >= INSCRIBED))
        assert 0.3 < np.hypot(*(blocked - end).T).min() <= FOLLOW_GAP + 0.05
        assert 1.0 < np.hypot(*(people[0].position_in_world - end)) < 1.5
        assert survey(costmap, path.points_in_world, 10.0)[1]


def test_two_people_who_stand_abreast_leave_no_way() -> None:
    costmap, people = abreast(Posture.STANDING)
    assert Planner().update(costmap, START, GOAL, 0.0, False, people) is None


def test_a_closed_building_is_not_followed_through() -> None:
    costmap, people = abreast(Posture.WALKING)
    costmap.raise_building_to(np.where(np.arange(200) == 150, np.uint8(LETHAL), np.uint8(0))[None, :])
    assert Planner().update(costmap, START, GOAL, 0.0, False, people) is None


def bystander(x: float, y: float, posture: Posture = Posture.STANDING) -> TrackedPerson:
    speed = 0.4 if posture is Posture.WALKING else 0.0
    return TrackedPerson(0, 0.0, np.array([x, y]), np.array([speed, 0.0]), 4e-4 * np.eye(4), posture, None)


def among(*people: TrackedPerson, task: HandOver | None = None, without: Sequence[str] = ()) -> Costmap:
    costmap = corridor()
    for layer in standard_layers([], robot_radius=0.3, without=without):
        layer.apply(costmap, Scene(0.0, people, task=task))
    return costmap


@pytest.mark.parametrize("posture", [Posture.STANDING, Posture.WALKING])  # on the goal, or in front and followed
def test_a_disc_is_opened_that_is_as_large_as_the_planner_was_told(posture: Posture) -> None:
    person = bystander(9.4, 0.0, posture)
    costmap = raised(corridor(), 9.4, 0.0, 1.45, LETHAL)  # as wide as the corridor
    assert Planner(largest_body=0.8).update(costmap, START, GOAL, 0.0, False, [person]) is None
    path = Planner(largest_body=1.5).update(costmap, START, GOAL, 0.0, False, [person])
    assert path is not None and 6.5 < path.points_in_world[-1, 0] < 8.0


@pytest.mark.parametrize("beside", [0.0, 0.5, 0.9])  # on the goal, in reach of it, near it
def test_a_goal_beside_somebody_is_approached_to_where_g_is_a_fifth(beside: float) -> None:
    person = bystander(GOAL[0], beside)
    costmap = among(person)
    assert costmap.cost_at(GOAL) > 0.2 * 252
    path = Planner().update(costmap, START, GOAL, 0.0, False, [person])
    assert path is not None
    costs = costmap.cost_at(path.points_in_world)
    assert costs[-1] <= 0.2 * 252 and (costs < INSCRIBED).all()
    # g2 is 0.2 at 1.005 m; the way ends between that and two cells, in a diagonal, before it.
    assert 1.0 <= math.dist(path.points_in_world[-1], person.position_in_world) <= 1.005 + 2.5 * 0.071
    assert path.cost == pytest.approx(survey(costmap, path.points_in_world, 10.0)[0])


def test_the_opening_admits_the_robot_to_the_stop_before_the_person_of_the_hand_over() -> None:
    person = bystander(9.0, 0.0)
    stop, task = np.array([8.1, 0.0]), HandOver(np.array([9.0, 0.0]), person=0, heading=math.pi)
    refused = Planner().update(among(person), START, stop, 0.0, False, [person])
    admitted = Planner().update(among(person, task=task), START, stop, 0.0, False, [person])
    assert refused is not None and refused.points_in_world[-1, 0] < 8.0
    assert admitted is not None
    assert admitted.points_in_world[-1] == pytest.approx(stop, abs=0.026)


def test_costs_of_the_building_and_of_people_passed_on_the_way_cut_nothing_off() -> None:
    wall = np.zeros(corridor().shape, np.uint8)
    wall[:, 150:] = 120  # as dear as g = 0.48, from x = 7.5 m to beyond the goal
    costmap = among(bystander(5.0, 0.0))
    costmap.raise_building_to(wall)
    path = Planner().update(costmap, START, GOAL, 0.0, False, [bystander(5.0, 0.0)])
    assert path is not None and costmap.cost_at(path.points_in_world[-1]) == 120
    assert path.points_in_world[-1] == pytest.approx(GOAL, abs=0.026)
    passing = among(bystander(5.0, 1.0), bystander(5.0, -1.0), without=["body"])
    path = Planner().update(passing, START, GOAL, 0.0, False)
    assert path is not None and passing.cost_at(path.points_in_world).max() > 0.2 * 252
    assert path.points_in_world[-1] == pytest.approx(GOAL, abs=0.026)


def test_a_robot_that_somebody_joins_before_the_goal_stands_where_it_is() -> None:
    planner, robot = Planner(), np.array([9.1, 0.0])
    assert planner.update(corridor(), robot, GOAL, 0.0, False) is not None
    person = bystander(9.5, 0.5)
    path = planner.update(among(person), robot, GOAL, 0.05, False, [person])
    assert path is not None and path.points_in_world.tolist() == [[9.1, 0.0]]
    gone = planner.update(corridor(), robot, GOAL, 0.1, False)
    assert gone is not None and gone.points_in_world[-1] == pytest.approx(GOAL, abs=0.026)


def test_nobody_who_blocks_the_way_is_walked_through_for_a_goal_that_somebody_else_stands_on() -> None:
    people = [bystander(5.0, -0.6), bystander(5.0, 0.6), bystander(*GOAL)]
    assert Planner().update(among(*people), START, GOAL, 0.0, False, people) is None
    walkers = [bystander(5.0, y, Posture.WALKING) for y in (-0.6, 0.6)]
    costmap = among(*walkers, people[2])
    followed = Planner().update(costmap, START, GOAL, 0.0, False, [*walkers, people[2]])
    assert followed is not None and 3.0 < followed.points_in_world[-1, 0] < 4.5
    assert (costmap.cost_at(followed.points_in_world) < INSCRIBED).all()


def test_the_cost_of_a_way_agrees_with_the_search() -> None:
    costmap = raised(raised(corridor(), 5.0, 0.3, 1.4, 90), 3.0, -0.5, 0.8, 160)
    path = astar(costmap, START, GOAL, weight=10.0)
    assert path is not None and path.cost > 10.0
    cost, free = survey(costmap, path.points_in_world, 10.0)
    assert cost == pytest.approx(path.cost, abs=1e-9)
    assert free


def test_a_way_is_not_free_where_it_touches_a_blocked_cell_or_leaves_the_map() -> None:
    costmap = corridor()
    costmap.cost[30, 100] = INSCRIBED
    assert survey(costmap, np.array([[4.0, 0.02], [6.0, 0.02]]), 10.0) == (pytest.approx(2.0 + 0.05 * 99), False)
    assert survey(costmap, np.array([[4.0, 0.06], [6.0, 0.06]]), 10.0) == (pytest.approx(2.0), True)
    assert not survey(costmap, np.array([[9.0, 0.0], [10.5, 0.0]]), 10.0)[1]


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"replan_period": 0.0}, "replan_period is 0.0"),
        ({"replan_period": 0.6}, "replan_period is 0.6"),
        ({"switch_gain": -0.1}, "switch_gain is -0.1"),
        ({"weight": -1.0}, "weight is -1.0"),
        ({"largest_body": 0.0}, "largest_body is 0.0"),
    ],
)
def test_wrong_settings_are_refused(keywords: dict[str, float], message: str) -> None:
    with pytest.raises(BadInputError, match=message):
        Planner(**keywords)
