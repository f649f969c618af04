"""Which places are on the floor."""

import numpy as np

from han_bullet.tracking.building import on_floor
from han_bullet.world_schema import FloorArea

CORRIDOR = FloorArea(x=(0.0, 16.0), y=(-1.5, 1.5), texture="tiles")
ROOM = FloorArea(x=(16.0, 23.0), y=(-3.5, 3.5), texture="parquet")


def test_a_place_is_on_the_floor_if_it_is_on_any_piece_or_just_beside_one() -> None:
    places = np.array([[8.0, 0.0], [8.0, 1.7], [8.0, 2.0], [18.0, 2.0], [23.2, 0.0], [23.4, 0.0]])
    assert on_floor([CORRIDOR, ROOM], places).tolist() == [True, True, False, True, True, False]


def test_a_floor_area_ends_with_its_edge_and_takes_single_points_and_arrays_of_any_shape() -> None:
    assert CORRIDOR.contains(np.array([16.0, -1.5]))
    assert not CORRIDOR.contains(np.array([16.0, -1.51]))
    assert CORRIDOR.contains(np.array([16.0, -1.51]), margin=0.02)
    assert CORRIDOR.contains(np.array([[[0.0, 0.0], [-0.1, 0.0]], [[8.0, 1.6], [8.0, 1.5]]])).tolist() == [
        [True, False],
        [False, True],
    ]


def test_without_a_floor_plan_people_may_be_everywhere() -> None:
    assert on_floor([], np.array([[99.0, -99.0]])).tolist() == [True]
