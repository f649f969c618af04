"""Costs as ROS's occupancy."""

import numpy as np

from han_bullet.ros.message_types import deserialize, serialize
from han_bullet.ros.occupancy import changed_window, grid_message, occupancy, update_message

# costmap_2d's table, from its documentation and source: 0, 253, 254, 255, and 1 + 97 (cost - 1) / 251 in whole numbers.
KNOWN = {0: 0, 1: 1, 10: 4, 50: 19, 77: 30, 100: 39, 128: 50, 200: 77, 252: 98, 253: 99, 254: 100, 255: -1}
# Costs from which on occupancy is one more, by exact fractions: the least cost with 97 (cost - 1) >= 251 k.
STEPS = [1 + -(-251 * k // 97) for k in range(1, 98)]


def test_every_cost_has_the_occupancy_that_costmap_2d_gives_it() -> None:
    cells = occupancy(np.arange(256, dtype=np.uint8))
    assert {cost: int(cells[cost]) for cost in KNOWN} == KNOWN
    expected = [0, *(1 + sum(step <= cost for step in STEPS) for cost in range(1, 253)), 99, 100, -1]
    assert cells.tolist() == expected


def test_unknown_cells_go_over_the_wire_as_minus_one() -> None:
    cost = np.array([[0, 255], [254, 253]], np.uint8)
    message = grid_message(occupancy(cost), np.array([-1.0, 2.0]), 0.05, 3.0)
    raw = bytes(serialize(message))
    assert raw[-4:] == bytes([0, 0xFF, 100, 99])
    assert deserialize("nav_msgs/OccupancyGrid", raw).data.tolist() == [0, -1, 100, 99]


def test_a_grid_has_its_lower_left_corner_as_origin_and_rows_one_after_the_other() -> None:
    cells = np.arange(6, dtype=np.int8).reshape(2, 3)  # two rows of three columns
    message = grid_message(cells, np.array([-1.0, 2.0]), 0.1, 3.5)
    assert (message.info.width, message.info.height, message.info.resolution) == (3, 2, 0.1)
    assert (message.info.origin.position.x, message.info.origin.position.y) == (-1.0, 2.0)
    assert message.info.origin.orientation.w == 1.0
    assert message.data.tolist() == [0, 1, 2, 3, 4, 5] and message.data.dtype == np.int8
    assert message.header.frame_id == "map" and message.header.stamp.sec == 3


def test_the_changed_window_is_the_smallest_one_with_all_changes() -> None:
    before = np.zeros((8, 9), np.int8)
    after = before.copy()
    after[2, 7], after[5, 3] = 1, -1
    assert changed_window(before, after) == (slice(2, 6), slice(3, 8))
    assert changed_window(before, before.copy()) is None


def test_an_update_counts_columns_as_x_and_rows_as_y() -> None:
    cells = np.arange(20, dtype=np.int8).reshape(4, 5)
    update = update_message(cells, (slice(1, 3), slice(2, 5)), 0.0)
    assert (update.x, update.y, update.width, update.height) == (2, 1, 3, 2)
    assert update.data.tolist() == [7, 8, 9, 12, 13, 14]
