"""The map at the scanner's height: boxes, floor and what is unknown."""

import numpy as np
import pytest
from simulated_laser import FLOOR, ROOM, block

from han_bullet.errors import BadInputError
from han_bullet.geometry import SolidBox
from han_bullet.localization.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid


def at(grid: OccupancyGrid, x: float, y: float) -> int:
    column, row = np.floor((np.array([x, y]) - grid.origin_in_world) / grid.resolution).astype(int)
    return int(grid.cells[row, column])


def test_walls_that_lie_on_the_cells_borders_take_just_their_cells() -> None:
    grid = OccupancyGrid.of_building([FLOOR], ROOM[:4], scan_height=0.25)
    assert grid.cells.shape == (124, 164)
    assert grid.origin_in_world == pytest.approx([-0.1, -0.1])
    assert (grid.cells[2:-2, 2:-2] == FREE).all()
    assert (grid.cells == OCCUPIED).sum() == 124 * 164 - 120 * 160


@pytest.mark.parametrize(("height", "seen"), [(0.25, FREE), (0.7, OCCUPIED), (0.9, FREE)])
def test_a_table_top_is_seen_only_by_a_scanner_at_its_height(height: float, seen: int) -> None:
    top = SolidBox("top", "object", np.array([4.0, 3.0, 0.7]), np.array([1.0, 1.0, 0.1]), 0.0)
    assert at(OccupancyGrid.of_building([FLOOR], [top], scan_height=height), 4.0, 3.0) == seen


def test_a_turned_box_takes_each_cell_that_holds_one_of_its_points() -> None:
    box = block(4.0, 3.0, 2.0, 0.3, 0.6)
    grid = OccupancyGrid.of_building([FLOOR], [box], scan_height=0.25)
    inside = np.random.default_rng(0).uniform(-0.5, 0.5, (2000, 2)) * box.size[:2]
    turn = np.array([[np.cos(0.6), -np.sin(0.6)], [np.sin(0.6), np.cos(0.6)]])
    assert {at(grid, *point) for point in inside @ turn.T + [4.0, 3.0]} == {OCCUPIED}
    assert (grid.cells == OCCUPIED).sum() * grid.resolution**2 < 2.3 * (0.3 + 2 * 0.07)


def test_where_there_is_no_floor_is_unknown() -> None:
    grid = OccupancyGrid.of_building([((0.0, 2.0), (0.0, 1.0)), ((2.0, 3.0), (0.0, 3.0))], [], scan_height=0.25)
    assert [at(grid, 1.0, 0.5), at(grid, 2.5, 2.5), at(grid, 1.0, 2.0)] == [FREE, FREE, UNKNOWN]


@pytest.mark.parametrize(
    ("floor", "resolution", "told"),
    [([FLOOR], 0.0, "resolution is 0.0 m"), ([], 0.05, "floor area"), ([FLOOR], 1e-5, "800000 x 600000 cells")],
)
def test_a_map_that_cannot_be_is_told(floor: list[object], resolution: float, told: str) -> None:
    with pytest.raises(BadInputError, match=told):
        OccupancyGrid.of_building(floor, [], scan_height=0.25, resolution=resolution)  # type: ignore[arg-type]
