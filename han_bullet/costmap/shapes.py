"""The two shapes that costs around people are made of: asymmetric Gaussian and disc [Kirby2010], [Mateus2019]."""

from __future__ import annotations

import math

import numba
import numpy as np

from han_bullet.costmap.grid import SOCIAL_MAX, Costmap, Costs
from han_bullet.geometry import Array

# In deviations: beyond it 252 g rounds to 0.
REACH = math.sqrt(2.0 * math.log(2.0 * SOCIAL_MAX))
# By a cell's cost: from this squared distance in deviations on, a Gaussian does not raise it, for 252 g + 0.5 is below
# the cost's next number. The hair is for the rounding of exp and log. Blocked cells stay at any distance.
ENOUGH = np.full(256, -1.0)
ENOUGH[: SOCIAL_MAX + 1] = 2.0 * np.log(SOCIAL_MAX / (np.arange(SOCIAL_MAX + 1) + 0.5)) + 1e-9


@numba.njit(cache=True)
def squared_distance(u: float, v: float, ahead: float, side: float, rear: float) -> float:
    """Return u^2 / b^2 + v^2 / side^2, b = ahead where u > 0, else rear: exp(-1/2 of it) is the asymmetric Gaussian.

    Args:
        u: Coordinate along the lobe, from the person [m].
        v: Coordinate across it [m].
        ahead: Standard deviation [m] where u > 0.
        side: Standard deviation across [m].
        rear: Standard deviation [m] where u < 0; zero closes that side with a half plane.
    """
    if u < 0.0 and rear == 0.0:
        return math.inf
    b = ahead if u >= 0.0 else rear
    return (u / b) ** 2 + (v / side) ** 2


def raise_asym_gauss(
    costmap: Costmap,
    position_in_world: Array,
    direction: float,
    ahead: float,
    side: float,
    rear: float,
    amplitude: float = 1.0,
) -> None:
    """Raise a map by an asymmetric Gaussian with its peak at a person.

    A deviation below one cell cannot be sampled: the value of the one cell that it reaches would depend on where in
    the cell the person stands. Such a rear is a half plane, sampled at cell centres.

    Args:
        costmap: The map.
        position_in_world: Of the peak, shape (2,) [m].
        direction: Of the lobe [rad].
        ahead: Standard deviation along the direction [m].
        side: Across it [m].
        rear: Against it [m].
        amplitude: The peak, in [0, 1].
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
    _raise_gauss(costmap.cost[rows, columns], left, bottom, costmap.resolution, c, s, ahead, side, rear, amplitude)


def raise_disc(costmap: Costmap, centre_in_world: Array, radius: float, value: int) -> None:
    """Raise the cells whose centres lie within a radius [m] of a point, shape (2,) [m], to a value."""
    x, y = float(centre_in_world[0]), float(centre_in_world[1])
    rows, columns = costmap.window((x - radius, x + radius), (y - radius, y + radius))
    first, origin = (rows.start, columns.start), tuple(costmap.origin_in_world.tolist())
    window = costmap.cost[rows, columns]
    _raise_disc(window, first, origin, costmap.resolution, (x, y), float(radius) ** 2, np.uint8(value))


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
    amplitude: float,
) -> None:
    """Raise a window whose lower left corner lies at (left, bottom) from the peak [m]; blocked cells stay.

    The exponential is most of the time, so only cells that it can raise are asked for theirs.
    """
    rows, columns = cost.shape
    if amplitude <= 0.0:
        return
    nearer = 2.0 * math.log(amplitude)  # by so much less a lower peak reaches
    for i in range(rows):
        y = bottom + (i + 0.5) * resolution
        for j in range(columns):
            x = left + (j + 0.5) * resolution
            distance = squared_distance(c * x + s * y, c * y - s * x, ahead, side, rear)
            if distance < ENOUGH[cost[i, j]] + nearer:
                cost[i, j] = max(cost[i, j], np.uint8(SOCIAL_MAX * amplitude * math.exp(-0.5 * distance) + 0.5))


@numba.njit(cache=True)
def _raise_disc(
    cost: Costs,
    first: tuple[int, int],
    origin: tuple[float, float],
    resolution: float,
    centre: tuple[float, float],
    squared_radius: float,
    value: np.uint8,
) -> None:
    """Raise the cells of a window that begins at a row and column of the map; centres as `Costmap` computes them."""
    rows, columns = cost.shape
    for i in range(rows):
        dy = origin[1] + (first[0] + i + 0.5) * resolution - centre[1]
        for j in range(columns):
            dx = origin[0] + (first[1] + j + 0.5) * resolution - centre[0]
            if dx**2 + dy**2 <= squared_radius:
                cost[i, j] = max(cost[i, j], value)
