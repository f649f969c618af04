"""The costmap: uint8 costs on the floor, row = y, column = x. Values follow costmap_2d [MarderEppstein2010]."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array

FREE = 0
SOCIAL_MAX = 252  # the dearest cell that the robot may still enter
INSCRIBED = 253  # the robot's centre here means that its body touches something; from here on, cells are blocked
LETHAL = 254
UNKNOWN = 255  # no floor

Interval = tuple[float, float]
Window = tuple[slice, slice]
Costs = NDArray[np.uint8]


def social_cost(g: Array) -> Costs:
    """Return round(252 g) for costs g in [0, 1], any shape: what they are worth on the grid."""
    return np.floor(SOCIAL_MAX * np.asarray(g, float) + 0.5).astype(np.uint8)


@dataclass(frozen=True, eq=False)
class Costmap:
    """Costs of a rectangle of floor.

    Attributes:
        cost: Shape (rows, columns), uint8.
        building: Same shape: what walls, furniture and missing floor alone cost. A robot that finds itself inside a
            person's disc may leave through it, but not through what blocks here.
        origin_in_world: Lower left corner of the first cell, shape (2,) [m].
        resolution: Side of a cell [m].
    """

    cost: Costs
    building: Costs
    origin_in_world: Array
    resolution: float

    @classmethod
    def covering(cls, floor: Sequence[tuple[Interval, Interval]], resolution: float) -> Costmap:
        """Build the smallest map over some floor areas, each an x and a y interval [m]; where there is none, UNKNOWN.

        Raises:
            BadInputError: No area, an empty one, or a resolution that is not positive.
        """
        _check_covering(floor, resolution)
        areas = np.array(floor, float)  # (n, 2: x and y, 2: from and to)
        origin, end = areas[:, :, 0].min(axis=0), areas[:, :, 1].max(axis=0)
        # A hair less, so that 16 m / 0.05 m is 320 cells and not 321.
        columns, rows = np.ceil((end - origin) / resolution - 1e-9).astype(int)
        cost = np.full((rows, columns), UNKNOWN, np.uint8)
        x = origin[0] + (np.arange(columns) + 0.5) * resolution
        y = origin[1] + (np.arange(rows) + 0.5) * resolution
        for (x_from, x_to), (y_from, y_to) in floor:
            cost[np.ix_((y_from <= y) & (y <= y_to), (x_from <= x) & (x <= x_to))] = FREE
        return cls(cost, cost.copy(), origin, resolution)

    @property
    def shape(self) -> tuple[int, int]:
        """Return (rows, columns)."""
        rows, columns = self.cost.shape
        return rows, columns

    def copy(self) -> Costmap:
        """Return a map that layers may raise without changing this one."""
        return Costmap(self.cost.copy(), self.building.copy(), self.origin_in_world, self.resolution)

    def world_to_cell(self, points_in_world: Array) -> NDArray[np.int64]:
        """Return the (row, column) of points, shape (..., 2) [m]; outside the map they count on beyond its borders."""
        offset = np.floor((np.asarray(points_in_world, float) - self.origin_in_world) / self.resolution)
        return offset[..., ::-1].astype(np.int64)

    def cell_to_world(self, cells: NDArray[np.int64]) -> Array:
        """Return the centres, shape (..., 2) [m], of cells (row, column), shape (..., 2)."""
        centres: Array = self.origin_in_world + (np.asarray(cells)[..., ::-1] + 0.5) * self.resolution
        return centres

    def cost_at(self, points_in_world: Array) -> Costs:
        """Return the costs at points, shape (..., 2) [m]; UNKNOWN outside the map."""
        return self._values_at(points_in_world, self.cost)

    def social_cost_at(self, points_in_world: Array) -> Costs:
        """Return what people alone cost at points, shape (..., 2) [m]; 0 where the building costs as much or more."""
        cost = self.cost_at(points_in_world)
        return np.where(cost > self._values_at(points_in_world, self.building), cost, np.uint8(FREE))

    def _values_at(self, points_in_world: Array, values: Costs) -> Costs:
        points = np.ascontiguousarray(points_in_world, float)
        x, y = self.origin_in_world
        return _sampled(values, points.reshape(-1, 2), x, y, self.resolution).reshape(points.shape[:-1])

    def costs_on_line(self, start_in_world: Array, end_in_world: Array) -> Costs:
        """Return the costs along a straight line, both ends (2,) [m] included, sampled twice per cell or more."""
        length = math.hypot(end_in_world[0] - start_in_world[0], end_in_world[1] - start_in_world[1])
        steps = np.linspace(0.0, 1.0, 2 + int(2.0 * length / self.resolution))[:, None]
        return self.cost_at(start_in_world + steps * (end_in_world - start_in_world))

    def centres_in_window(self, centre_in_world: Array, radius: float) -> tuple[Window, Array, Array]:
        """Return the window of cells around a point, (2,) [m], that covers a radius [m], and its cells' centres.

        Returns:
            The window, and the centres' x, shape (1, columns), and y, shape (rows, 1) [m]; empty off the map.
        """
        x, y = float(centre_in_world[0]), float(centre_in_world[1])
        rows, columns = self.window((x - radius, x + radius), (y - radius, y + radius))
        centres_x = self.origin_in_world[0] + (np.arange(columns.start, columns.stop) + 0.5) * self.resolution
        centres_y = self.origin_in_world[1] + (np.arange(rows.start, rows.stop) + 0.5) * self.resolution
        return (rows, columns), centres_x[None, :], centres_y[:, None]

    def window(self, x: Interval, y: Interval) -> Window:
        """Return the rows and columns of the cells that a rectangle [m] touches; empty off the map."""
        spans = []
        for axis, (low, high) in ((1, y), (0, x)):
            origin, size = float(self.origin_in_world[axis]), self.cost.shape[1 - axis]
            start = math.floor((low - origin) / self.resolution)
            stop = math.floor((high - origin) / self.resolution) + 1
            spans.append(slice(min(max(start, 0), size), min(max(stop, 0), size)))
        return spans[0], spans[1]

    def raise_to(self, window: Window, values: Costs) -> None:
        """Raise the cells of a window to values where those are higher; lower nothing."""
        np.maximum(self.cost[window], values, out=self.cost[window])

    def raise_building_to(self, values: Costs) -> None:
        """Raise the whole map, shape (rows, columns), by what walls, furniture and missing floor cost."""
        np.maximum(self.cost, values, out=self.cost)
        np.maximum(self.building, values, out=self.building)


def _check_covering(floor: Sequence[tuple[Interval, Interval]], resolution: float) -> None:
    if not 0.0 < resolution < math.inf:
        raise BadInputError(f"costmap resolution is {resolution!r} m; it must be positive, such as 0.05")
    if not floor:
        raise BadInputError("a costmap needs at least one floor area; none was given")
    for x, y in floor:
        if not (x[0] < x[1] and y[0] < y[1]):
            raise BadInputError(f"floor area x {list(x)}, y {list(y)} is empty; write [smaller, larger]")


@numba.njit(cache=True)
def _sampled(values: Costs, points: Array, origin_x: float, origin_y: float, resolution: float) -> Costs:
    """Return the values at points, shape (n, 2) [m]; UNKNOWN outside the map."""
    rows, columns = values.shape
    found = np.full(len(points), UNKNOWN, np.uint8)
    for i in range(len(points)):
        column = math.floor((points[i, 0] - origin_x) / resolution)
        row = math.floor((points[i, 1] - origin_y) / resolution)
        if 0 <= row < rows and 0 <= column < columns:
            found[i] = values[row, column]
    return found
