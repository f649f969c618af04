"""The map that a level laser scanner sees: which cells of the floor are free, occupied or unknown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, SolidBox, rotation

FREE = 0
OCCUPIED = 100
UNKNOWN = -1  # the three values of ROS's nav_msgs/OccupancyGrid

MOST_CELLS = 100_000_000  # a map of 500 m by 500 m with cells of 5 cm; more is a slip of the pen

Interval = tuple[float, float]


@dataclass(frozen=True, eq=False)
class OccupancyGrid:
    """A rectangle of floor, cut at the height of the scanner.

    Attributes:
        cells: FREE, OCCUPIED or UNKNOWN, row = y, column = x, shape (rows, columns), int8.
        origin_in_world: Lower left corner of the first cell, shape (2,) [m].
        resolution: Side of a cell [m].
    """

    cells: NDArray[np.int8]
    origin_in_world: Array
    resolution: float

    @classmethod
    def of_building(
        cls,
        floor: Sequence[tuple[Interval, Interval]],
        boxes: Sequence[SolidBox],
        *,
        scan_height: float,
        resolution: float = 0.05,
    ) -> OccupancyGrid:
        """Draw the boxes that a scanner at a height [m] sees on floor areas, each an x and a y interval [m].

        Raises:
            BadInputError: No floor, a resolution that is not positive, or one too fine for such a floor.
        """
        seen = [box for box in boxes if abs(scan_height - box.centre_in_world[2]) <= 0.5 * box.size[2]]
        grid = cls._unknown(floor, seen, resolution)
        x, y = grid.centres()
        for (x_from, x_to), (y_from, y_to) in floor:
            grid.cells[((y_from <= y) & (y <= y_to)) & ((x_from <= x) & (x <= x_to))] = FREE
        for box in seen:
            grid.cells[box.touches_cells(x, y, resolution)] = OCCUPIED
        return grid

    @classmethod
    def _unknown(
        cls, floor: Sequence[tuple[Interval, Interval]], boxes: Sequence[SolidBox], resolution: float
    ) -> OccupancyGrid:
        if not 0.0 < resolution < math.inf:
            raise BadInputError(f"the map's resolution is {resolution!r} m; it must be positive, such as 0.05")
        if not floor:
            raise BadInputError("a map needs at least one floor area; none was given")
        corners = [np.array(floor, float).transpose(0, 2, 1).reshape(-1, 2), *map(_corners, boxes)]
        points = np.concatenate(corners)
        # Whole multiples of the resolution, to which walls are often drawn, and a hair for rounding.
        first = np.floor(points.min(axis=0) / resolution + 1e-6)
        last = np.ceil(points.max(axis=0) / resolution - 1e-6)
        columns, rows = (int(n) for n in last - first)
        if rows * columns > MOST_CELLS:
            raise BadInputError(
                f"the map would have {columns} x {rows} cells of {resolution} m; at most {MOST_CELLS} would be right"
            )
        return cls(np.full((rows, columns), UNKNOWN, np.int8), first * resolution, resolution)

    def centres(self) -> tuple[Array, Array]:
        """Return the cells' centres, x of shape (1, columns) and y of shape (rows, 1) [m]."""
        rows, columns = self.cells.shape
        x = self.origin_in_world[0] + (np.arange(columns) + 0.5) * self.resolution
        y = self.origin_in_world[1] + (np.arange(rows) + 0.5) * self.resolution
        return x[None, :], y[:, None]


def _corners(box: SolidBox) -> Array:
    half = 0.5 * box.size[:2]
    corners: Array = box.centre_in_world[:2] + (half * [[1, 1], [1, -1], [-1, 1], [-1, -1]]) @ rotation(box.yaw).T
    return corners
