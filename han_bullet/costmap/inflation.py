"""Distance from walls and furniture, as costmap_2d has it [MarderEppstein2010]."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from han_bullet.costmap.grid import FREE, INSCRIBED, LETHAL, SOCIAL_MAX, Costmap, Costs
from han_bullet.costmap.layer import Layer
from han_bullet.errors import BadInputError, check_positive
from han_bullet.geometry import Array
from han_bullet.messages import Scene


class InflationLayer(Layer):
    """INSCRIBED within the robot's radius of the building, then 252 exp(-factor (d - radius)), nothing further out.

    It belongs after the static layer and before the people: it inflates what is LETHAL or has no floor when it runs.
    """

    name = "inflation"

    def __init__(
        self, *, robot_radius: float, inflation_radius: float = 0.55, cost_scaling_factor: float = 10.0
    ) -> None:
        """Configure the decay.

        Args:
            robot_radius: Of the footprint [m].
            inflation_radius: Where the cost ends [m]; at least the robot's radius.
            cost_scaling_factor: Decay [1/m].
        """
        check_positive(f"layer {self.name}", robot_radius=robot_radius, inflation_radius=inflation_radius)
        check_positive(f"layer {self.name}", cost_scaling_factor=cost_scaling_factor)
        if inflation_radius < robot_radius:
            raise BadInputError(
                f"layer inflation: inflation_radius is {inflation_radius!r} m; it must be at least the robot's radius, "
                f"{robot_radius!r} m"
            )
        self.robot_radius = robot_radius
        self.inflation_radius = inflation_radius
        self.cost_scaling_factor = cost_scaling_factor
        self._building: Costs = np.zeros((0, 0), np.uint8)
        self._resolution = 0.0
        self._inflated: Costs = self._building

    def apply(self, costmap: Costmap, scene: Scene) -> None:
        """Raise the cells near the building; computed anew only where the building has changed."""
        if costmap.shape != self._building.shape or costmap.resolution != self._resolution:
            self._building, self._resolution = costmap.building.copy(), costmap.resolution
            self._inflated = self._inflate(distance_to_obstacles(self._building >= LETHAL, costmap.resolution))
        elif not np.array_equal(costmap.building, self._building):
            changed = np.nonzero(costmap.building != self._building)
            self._building = costmap.building.copy()
            self._inflate_around(*changed)
        costmap.raise_building_to(self._inflated)

    def _inflate_around(self, rows: NDArray[np.int64], columns: NDArray[np.int64]) -> None:
        """Inflate anew all that some cells reach, by all that reaches there: twice the radius around them."""
        reach = math.ceil(self.inflation_radius / self._resolution) + 1  # cells
        inner = _around(rows, reach), _around(columns, reach)
        wide = _around(rows, 2 * reach), _around(columns, 2 * reach)
        distance = distance_to_obstacles(self._building[wide] >= LETHAL, self._resolution)
        start_row, start_column = inner[0].start - wide[0].start, inner[1].start - wide[1].start
        target = self._inflated[inner]
        target[:] = self._inflate(distance)[start_row:, start_column:][: target.shape[0], : target.shape[1]]

    def _inflate(self, distance: Array) -> Costs:
        decay = np.exp(-self.cost_scaling_factor * (distance - self.robot_radius))
        values = np.floor(SOCIAL_MAX * np.minimum(decay, 1.0) + 0.5)
        values[distance > self.inflation_radius] = FREE
        values[distance <= self.robot_radius + 1e-9] = INSCRIBED
        inflated: Costs = values.astype(np.uint8)
        return inflated


def _around(indices: NDArray[np.int64], reach: int) -> slice:
    """Return the rows or columns from the first to the last of some, and so many more on both sides."""
    return slice(max(int(indices.min()) - reach, 0), int(indices.max()) + reach + 1)


def distance_to_obstacles(obstacles: NDArray[np.bool_], resolution: float) -> Array:
    """Return the distance [m] from each cell's centre to the nearest obstacle cell's square; beyond the map is none.

    costmap_2d measures from centre to centre, which lets a body overlap an obstacle by up to 0.7 of a cell.
    """
    padded = np.pad(obstacles, 1, constant_values=True)
    _, nearest = distance_transform_edt(~padded, return_indices=True)
    gap = np.abs(nearest - np.indices(padded.shape)) - 0.5
    distance: Array = resolution * np.hypot(*np.maximum(gap, 0.0))[1:-1, 1:-1]
    return distance
