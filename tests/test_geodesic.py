"""Shortest ways at any angle, against ways worked out by hand and against A*."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.costmap.grid import LETHAL, Costmap
from han_bullet.planning.astar import astar
from han_bullet.planning.geodesic import Geodesic
from han_bullet.static_map import static_costmap
from han_bullet.world_file import load_world


def room(*blocked: tuple[float, float, float, float]) -> Costmap:
    """A 10 m x 10 m map of cells of 0.1 m with blocked rectangles: x from, x to, y from, y to."""
    costmap = Costmap.covering([((0.0, 10.0), (0.0, 10.0))], 0.1)
    for x_from, x_to, y_from, y_to in blocked:
        window = costmap.window((x_from + 0.01, x_to - 0.01), (y_from + 0.01, y_to - 0.01))
        costmap.raise_building_to(np.zeros_like(costmap.cost))
        costmap.cost[window] = LETHAL
        costmap.building[window] = LETHAL
    return costmap


def length(costmap: Costmap, start: tuple[float, float], goal: tuple[float, float]) -> float:
    return Geodesic(costmap, np.array(goal)).length_from(np.array(start))


@pytest.mark.parametrize("goal", [(9.0, 1.0), (9.0, 9.0), (8.39, 4.06), (4.06, 8.39), (1.0, 1.0)])
def test_in_the_open_it_is_the_straight_line_at_every_angle(goal: tuple[float, float]) -> None:
    assert length(room(), (1.0, 1.0), goal) == pytest.approx(math.dist((1.0, 1.0), goal))


def test_the_octile_length_of_a_line_at_22_5_degrees_is_eight_percent_longer() -> None:
    start, goal = np.array([1.05, 1.05]), np.array([8.45, 4.15])  # 74 columns and 31 rows
    way = astar(room(), start, goal, weight=0.0)
    assert way is not None
    assert way.cost / length(room(), (1.05, 1.05), (8.45, 4.15)) == pytest.approx(1.082, abs=0.001)


def test_around_a_wall_it_is_taut_at_the_walls_end() -> None:
    wall = room((4.9, 5.1, 0.0, 5.0))  # its end's corners are the cells at (4.85, 5.05) and (5.15, 5.05)
    expected = 2.0 * math.dist((1.0, 1.0), (4.85, 5.05)) + 0.3
    assert length(wall, (1.0, 1.0), (9.0, 1.0)) == pytest.approx(expected)


def test_of_two_ways_around_it_takes_the_shorter() -> None:
    box = room((4.0, 6.0, 3.0, 9.0))
    below = 2.0 * math.dist((3.0, 5.0), (3.95, 2.95)) + 2.1
    assert length(box, (3.0, 5.0), (7.0, 5.0)) == pytest.approx(below)


def test_where_there_is_no_way_it_is_infinite() -> None:
    assert length(room((4.0, 4.5, 0.0, 10.0)), (1.0, 1.0), (9.0, 1.0)) == math.inf


def test_a_blocked_end_is_taken_to_be_the_nearest_free_cell() -> None:
    wall = room((4.0, 5.0, 0.0, 10.0))
    assert length(wall, (1.05, 1.05), (4.15, 1.05)) == pytest.approx(3.95 - 1.05)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_it_is_never_longer_than_the_ways_of_a_star_and_never_shorter_than_a_straight_line(seed: int) -> None:
    rng = np.random.default_rng(seed)
    costmap = Costmap.covering([((0.0, 4.0), (0.0, 4.0))], 0.1)
    for _ in range(12):
        row, column = rng.integers(0, 36, 2)
        height, width = rng.integers(1, 12, 2)
        costmap.cost[row : row + height, column : column + width] = LETHAL
        costmap.building[row : row + height, column : column + width] = LETHAL
    costmap.cost[:2, :2] = costmap.building[:2, :2] = costmap.cost[-2:, -2:] = costmap.building[-2:, -2:] = 0
    start, goal = np.array([0.05, 0.05]), np.array([3.95, 3.95])
    way = astar(costmap, start, goal, weight=0.0)
    ours = Geodesic(costmap, goal).length_from(start)
    if way is None:
        assert ours == math.inf or ours >= math.dist(start, goal)
    else:
        assert math.dist(start, goal) - 1e-9 <= ours <= way.cost + 1e-9


def test_in_the_shipped_building_the_way_to_the_room_is_shorter_than_the_grids() -> None:
    costmap, start, goal = static_costmap(load_world("sim2")), np.array([1.5, 0.0]), np.array([21.5, 2.0])
    way = astar(costmap, start, goal, weight=0.0)
    assert way is not None
    ours = Geodesic(costmap, goal).length_from(start)
    assert math.dist(start, goal) <= ours < way.cost
