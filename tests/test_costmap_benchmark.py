"""The benchmark of the costmap: its scenes give every layer work, and its table shows what was measured."""

import numpy as np
import pytest

from benchmarks.costmap import COPY, RESOLUTION, SIDE, TOTAL, building, measure, rows, scene, update_times
from han_bullet.costmap.grid import Costmap
from han_bullet.costmap.layers import STANDARD, standard_layers
from han_bullet.messages import Posture

LAYERS = [layer.name for layer in STANDARD]


def test_the_room_has_400_by_400_cells_and_with_three_people_every_layer_raises_some() -> None:
    costmap = Costmap.covering([((0.0, SIDE), (0.0, SIDE))], RESOLUTION)
    assert costmap.shape == (400, 400)
    scans = [scene(3, np.random.default_rng(0), number) for number in range(5)]
    for layer in standard_layers(building(), robot_radius=0.3):
        before = costmap.cost.copy()
        for one in scans:  # a hit alone marks nothing
            layer.apply(costmap, one)
        assert (costmap.cost > before).sum() > 20, layer.name


def test_a_third_of_the_people_walk_a_third_stand_and_a_third_sit_on_a_seat_of_their_own() -> None:
    people = scene(48, np.random.default_rng(0)).people
    assert [sum(person.posture is posture for person in people) for posture in Posture] == [16, 16, 16]
    assert len({person.seat for person in people if person.posture is Posture.SEATED}) == 16
    positions = np.array([person.position_in_world for person in people])
    assert positions.min() > 0.5 and positions.max() < SIDE - 0.5
    assert len(np.unique(positions, axis=0)) == 48


def test_the_parts_of_an_update_add_up_to_the_whole() -> None:
    free_space = Costmap.covering([((0.0, 4.0), (0.0, 4.0))], RESOLUTION)
    scenes = [scene(2, np.random.default_rng(seed)) for seed in range(3)]
    times = update_times(free_space, standard_layers([], robot_radius=0.3), scenes)
    assert list(times) == [TOTAL, COPY, *LAYERS]
    assert {len(taken) for taken in times.values()} == {3}
    assert np.sum([times[name] for name in (COPY, *LAYERS)], axis=0) == pytest.approx(times[TOTAL])


def test_the_table_has_a_line_for_each_part_and_a_column_for_each_number_of_people() -> None:
    table = rows({1: {"static": [0.001, 0.002, 0.003]}, 5: {"static": [0.01] * 3}})
    assert table == [["static", "2.000 (2.900)", "10.000 (10.000)"]]
    assert [line[0] for line in rows(measure([1], updates=1, seed=0))] == [TOTAL, COPY, *LAYERS]
