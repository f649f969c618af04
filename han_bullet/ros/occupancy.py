"""Costs as ROS's occupancy: costmap_2d's own table, whole grids, and the part of a grid that has changed."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from han_bullet.costmap.grid import INSCRIBED, LETHAL, UNKNOWN, Costs, Window
from han_bullet.geometry import Array
from han_bullet.ros.frames import MAP
from han_bullet.ros.message_types import header, make, stamp
from han_bullet.ros.placing import point, yaw_message

Cells = NDArray[np.int8]


def _table() -> Cells:
    """Return costmap_2d's occupancy of each cost: 1..252 become 1..98, 253 is 99, 254 is 100, 255 is -1."""
    cost = np.arange(256)
    table = 1 + 97 * (cost - 1) // 251
    table[0], table[INSCRIBED], table[LETHAL], table[UNKNOWN] = 0, 99, 100, -1
    return table.astype(np.int8)


TABLE = _table()


def occupancy(cost: Costs) -> Cells:
    """Return the occupancy of costs, any shape: 0 free, 1..98, 99 inscribed, 100 lethal, -1 unknown."""
    cells: Cells = TABLE[cost]
    return cells


def grid_message(cells: Cells, origin_in_world: Array, resolution: float, time: float) -> Any:
    """Return a nav_msgs/OccupancyGrid.

    Args:
        cells: Row = y, column = x, shape (rows, columns), int8.
        origin_in_world: Lower left corner of the first cell, shape (2,) [m].
        resolution: Side of a cell [m].
        time: [s].
    """
    rows, columns = cells.shape
    origin = make("geometry_msgs/Pose", position=point(*origin_in_world.tolist()), orientation=yaw_message(0.0))
    info = make(
        "nav_msgs/MapMetaData",
        map_load_time=stamp(time),
        resolution=float(resolution),
        width=columns,
        height=rows,
        origin=origin,
    )
    return make("nav_msgs/OccupancyGrid", header=header(time, MAP), info=info, data=cells.ravel())


def update_message(cells: Cells, window: Window, time: float) -> Any:
    """Return a map_msgs/OccupancyGridUpdate of a window of a grid."""
    part, (rows, columns) = cells[window], window
    return make(
        "map_msgs/OccupancyGridUpdate",
        header=header(time, MAP),
        x=columns.start,
        y=rows.start,
        width=columns.stop - columns.start,
        height=rows.stop - rows.start,
        data=part.ravel(),
    )


def changed_window(before: Cells, after: Cells) -> Window | None:
    """Return the smallest window with all cells that differ between two grids of one shape; None where none does."""
    changed = before != after
    rows = np.flatnonzero(changed.any(axis=1))
    if not len(rows):
        return None
    inside = slice(int(rows[0]), int(rows[-1]) + 1)
    columns = np.flatnonzero(changed[inside].any(axis=0))
    return inside, slice(int(columns[0]), int(columns[-1]) + 1)
