"""The grid: cells and metres, floor and no floor, raising."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.costmap.grid import FREE, SOCIAL_MAX, UNKNOWN, Costmap, social_cost
from han_bullet.errors import BadInputError

CORRIDOR = ((0.0, 16.0), (-1.5, 1.5))
ROOM = ((16.0, 23.0), (-3.5, 3.5))


def test_a_corridor_of_16_by_3_metres_has_320_by_60_cells_of_5_centimetres() -> None:
    costmap = Costmap.covering([CORRIDOR], 0.05)
    assert costmap.shape == (60, 320)
    assert costmap.origin_in_world.tolist() == [0.0, -1.5]
    assert (costmap.cost == FREE).all()


def test_cells_on_no_floor_area_are_unknown_and_the_open_border_between_two_areas_is_free() -> None:
    costmap = Costmap.covering([CORRIDOR, ROOM], 0.05)
    assert costmap.shape == (140, 460)
    assert costmap.cost_at(np.array([[8.0, 2.0], [8.0, 0.0], [20.0, 3.0]])).tolist() == [UNKNOWN, FREE, FREE]
    assert (costmap.costs_on_line(np.array([15.5, 0.0]), np.array([16.5, 0.0])) == FREE).all()


def test_points_off_the_map_are_unknown() -> None:
    costmap = Costmap.covering([CORRIDOR], 0.05)
    assert costmap.cost_at(np.array([[-0.01, 0.0], [16.01, 0.0], [5.0, 1.51], [5.0, -1.51]])).tolist() == [UNKNOWN] * 4


def test_social_costs_are_what_people_add_to_the_building() -> None:
    costmap = Costmap.covering([CORRIDOR], 0.05)
    building = np.zeros(costmap.shape, np.uint8)
    building[:, :100] = 90  # x < 5 m
    costmap.raise_building_to(building)
    costmap.raise_to((slice(0, 60), slice(60, 80)), np.uint8(60))  # 3 m < x < 4 m, hidden by the building's 90
    costmap.raise_to((slice(0, 60), slice(80, 120)), np.uint8(120))  # 4 m < x < 6 m
    points = np.array([[2.5, 0.0], [3.5, 0.0], [4.5, 0.0], [5.5, 0.0], [7.0, 0.0], [7.0, 2.0]])
    assert costmap.cost_at(points).tolist() == [90, 90, 120, 120, FREE, UNKNOWN]
    assert costmap.social_cost_at(points).tolist() == [FREE, FREE, 120, 120, FREE, FREE]


@given(row=st.integers(0, 59), column=st.integers(0, 319), dx=st.floats(-0.49, 0.49), dy=st.floats(-0.49, 0.49))
def test_every_point_of_a_cell_maps_to_it_and_its_centre_is_less_than_half_a_diagonal_away(
    row: int, column: int, dx: float, dy: float
) -> None:
    costmap = Costmap.covering([CORRIDOR], 0.05)
    centre = costmap.cell_to_world(np.array([row, column]))
    assert costmap.world_to_cell(centre + 0.05 * np.array([dx, dy])).tolist() == [row, column]
    assert centre == pytest.approx([0.05 * column + 0.025, 0.05 * row - 1.475])


def test_a_window_at_the_border_is_cut_and_one_off_the_map_is_empty() -> None:
    costmap = Costmap.covering([CORRIDOR], 0.05)
    window, x, y = costmap.centres_in_window(np.array([0.11, -1.41]), 0.18)
    assert costmap.cost[window].shape == (y.shape[0], x.shape[1]) == (6, 6)
    assert x[0, 0] == pytest.approx(0.025) and y[0, 0] == pytest.approx(-1.475)
    window, _, _ = costmap.centres_in_window(np.array([40.0, 0.0]), 0.2)
    assert costmap.cost[window].size == 0


def test_raising_takes_the_larger_value_and_leaves_the_building_and_the_original_alone() -> None:
    free = Costmap.covering([CORRIDOR], 0.05)
    costmap = free.copy()
    window, x, y = costmap.centres_in_window(np.array([3.0, 0.0]), 0.1)
    costmap.raise_to(window, np.full((y.size, x.size), 100, np.uint8))
    costmap.raise_to(window, np.full((y.size, x.size), 40, np.uint8))
    assert costmap.cost[window].min() == 100
    assert costmap.building.max() == FREE
    assert free.cost.max() == FREE


def test_social_costs_round_and_end_below_the_blocked_values() -> None:
    assert social_cost(np.array([0.0, 0.001, 0.002, 0.5, 1.0])).tolist() == [0, 0, 1, 126, SOCIAL_MAX]


@pytest.mark.parametrize(
    ("floor", "resolution", "message"),
    [([], 0.05, "at least one"), ([CORRIDOR], 0.0, "0.0"), ([((2.0, 1.0), (0.0, 1.0))], 0.05, r"\[2.0, 1.0\]")],
)
def test_a_map_over_nothing_is_refused(
    floor: list[tuple[tuple[float, float], ...]], resolution: float, message: str
) -> None:
    with pytest.raises(BadInputError, match=message):
        Costmap.covering(floor, resolution)
