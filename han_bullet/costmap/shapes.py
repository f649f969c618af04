"""The two shapes that costs around people are made of: asymmetric Gaussian and disc [Kirby2010], [Mateus2019]."""

from __future__ import annotations

import math

import numba
import numpy as np

from han_bullet.costmap.grid import SOCIAL_MAX, Costmap, Costs
from han_bullet.geometry import Array

# In deviations: beyond it 252 g rounds to 0.
REACH = math.sqrt(2.0 * math.log(2.0 * SOCIAL_MAX))


@numba.njit(cache=True)
def asym_gauss(u: float, v: float, ahead: float, side: float, rear: float) -> float:
    """Return exp(-u^2 / (2 b^2) - v^2 / (2 side^2)), b = ahead where u > 0, else rear.

    Args:
        u: Coordinate along the lobe, from the person [m].
        v: Coordinate across it [m].
        ahead: Standard deviation [m] where u > 0.
        side: Standard deviation across [m].
        rear: Standard deviation [m] where u < 0; zero closes that side with a half plane.
    """
    if u < 0.0 and rear == 0.0:
        return 0.0
    b = ahead if u >= 0.0 else rear
    return math.exp(-0.5 * ((u / b) ** 2 + (v / side) ** 2))


def raise_asym_gauss(
    costmap: Costmap, position_in_world: Array, direction: float, ahead: float, side: float, rear: float
) -> None:
    """Raise a map by an asymmetric Gaussian with its peak, 1, at a person.

    A deviation below one cell cannot be sampled: the value of the one cell that it reaches would depend on where in
    the cell the person stands. Such a rear is a half plane, sampled at cell centres.

    Args:
        costmap: The map.
        position_in_world: Of the peak, shape (2,) [m].
        direction: Of the lobe [rad].
        ahead: Standard deviation along the direction [m].
        side: Across it [m].
        rear: Against it [m].
    """
    x, y = float(position_in_world[0]), float(position_in_world[1])
    if rear < costmap.resolution:
        rear = 0.0
    c, s = math.cos(direction), math.sin(direction)
    tip, tail, half = REACH * ahead, -REACH * rear, REACH * side
    x_span = (x + min(c * tip, c * tail) - abs(s) * half, x + max(c * tip, c * tail) + abs(s) * half)
    y_span = (y + min(s * tip, s * tail) - abs(c) * half, y + max(s * tip, s * tail) + abs(c) * half)
    rows, columns = costmap.window(x_span, y_span)
    left = float(costmap.origin_in_world[0]) + columns.start * costmap.resolution - x
    bottom = float(costmap.origin_in_world[1]) + rows.start * costmap.resolution - y
    _raise_gauss(costmap.cost[rows, columns], left, bottom, costmap.resolution, c, s, ahead, side, rear)


def raise_disc(costmap: Costmap, centre_in_world: Array, radius: float, value: int) -> None:
    """Raise the cells whose centres lie within a radius [m] of a point, shape (2,) [m], to a value."""
    window, x, y = costmap.centres_in_window(centre_in_world, radius)
    inside = (x - centre_in_world[0]) ** 2 + (y - centre_in_world[1]) ** 2 <= radius**2
    costmap.raise_to(window, inside * np.uint8(value))


@numba.njit(cache=True)
def _raise_gauss(
    cost: Costs,
    left: float,
    bottom: float,
    resolution: float,
    c: float,
    s: float,
    ahead: float,
    side: float,
    rear: float,
) -> None:
    """Raise a window whose lower left corner lies at (left, bottom) from the peak [m]; blocked cells stay."""
    rows, columns = cost.shape
    for i in range(rows):
        y = bottom + (i + 0.5) * resolution
        for j in range(columns):
            if cost[i, j] > SOCIAL_MAX:
                continue
            x = left + (j + 0.5) * resolution
            g = asym_gauss(c * x + s * y, c * y - s * x, ahead, side, rear)
            cost[i, j] = max(cost[i, j], np.uint8(SOCIAL_MAX * g + 0.5))
