"""How likely a scan is from a pose, by how far its beams end from the map's surfaces [Thrun2005]."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from han_bullet.geometry import Array
from han_bullet.localization.beams import Beams
from han_bullet.localization.occupancy_grid import FREE, OCCUPIED, OccupancyGrid

FAR = 1e3  # of a map without anything in it [m]
SHORT = 0.05  # likelihood of a beam that ends where the map has nothing: at people, at what was put there
BLOCKED = 0.01  # of a beam that went through what the map has: rarer, since few things go away
MARGIN = 0.3  # a beam must go this far [m] beyond a surface before it counts as gone through


@dataclass(frozen=True, eq=False)
class LikelihoodField:
    """Distances from the surfaces of a map; a beam that ends at one is likely.

    Attributes:
        distance: From each cell's centre to the nearest surface: outside of it, of occupied cells, positive; behind it
            to the nearest free cell, negative, so that what overshoots a wall is drawn back; shape (rows, columns) [m].
        clearance: To the nearest occupied cell, 0 within; where nothing is known, too; same shape [m].
        origin_in_world: Lower left corner of the first cell, shape (2,) [m].
        resolution: Side of a cell [m].
    """

    distance: Array
    clearance: Array
    origin_in_world: Array
    resolution: float

    @classmethod
    def of_map(cls, grid: OccupancyGrid) -> LikelihoodField:
        """Measure the distances of a map."""
        # From centre to centre; the surface is half a cell before the other's.
        clearance = _to_nearest(grid.cells == OCCUPIED) * grid.resolution - 0.5 * grid.resolution
        behind = _to_nearest(grid.cells == FREE) * grid.resolution - 0.5 * grid.resolution
        distance = np.where(grid.cells == FREE, clearance, -behind)
        return cls(distance, np.maximum(clearance, 0.0), grid.origin_in_world, grid.resolution)

    def likelihoods(self, poses_in_world: Array, beams: Beams, deviation: float) -> tuple[Array, Array, Array]:
        """Return how well a scan fits to each pose (x, y, yaw), shape (n, 3).

        Returns:
            The sum over the beams of log p, with p = exp(-d^2 / (2 deviation^2)) (1 - SHORT) + SHORT at the distance d
            of the beam's end [m], or BLOCKED of a beam that went through a surface; the number of beams that end at a
            surface, or nowhere, as they should; the number that went through one; each of shape (n,).
        """
        poses = np.ascontiguousarray(poses_in_world, float)
        origin, ends = beams.origin_in_body, np.ascontiguousarray(beams.ends_in_body)
        returned = np.ascontiguousarray(beams.returned)
        x, y = self.origin_in_world
        found: tuple[Array, Array, Array] = _likelihoods(
            self.distance, self._strides, x, y, self.resolution, poses, origin, ends, returned, deviation
        )
        return found

    @functools.cached_property
    def _strides(self) -> Array:
        """How far a ray may go from anywhere in a cell without missing a surface [cells]; 0 in occupied ones."""
        free = self.clearance / self.resolution
        return np.where(free > 0.0, np.maximum(free - 0.71, 1.0), 0.0)  # as far as is free from the farthest corner


def _to_nearest(there: NDArray[np.bool_]) -> Array:
    """Return how many cells away the nearest of some is, 0 at these."""
    if not there.any():
        return np.full(there.shape, FAR)
    distances: Array = ndimage.distance_transform_edt(~there)
    return distances


@numba.njit(cache=True)
def _likelihoods(
    distance: Array,
    strides: Array,
    origin_x: float,
    origin_y: float,
    resolution: float,
    poses: Array,
    scanner: Array,
    ends: Array,
    returned: NDArray[np.bool_],
    deviation: float,
) -> tuple[Array, Array, Array]:
    """Return of each pose the log-likelihood, the number of beams that fit and the number that went through."""
    rows, columns = distance.shape
    total, hits, through = np.zeros(len(poses)), np.zeros(len(poses)), np.zeros(len(poses))
    for i in range(len(poses)):
        c, s = math.cos(poses[i, 2]) / resolution, math.sin(poses[i, 2]) / resolution
        x, y = (poses[i, 0] - origin_x) / resolution, (poses[i, 1] - origin_y) / resolution
        from_x, from_y = x + c * scanner[0] - s * scanner[1], y + s * scanner[0] + c * scanner[1]
        for k in range(len(ends)):
            to_x, to_y = x + c * ends[k, 0] - s * ends[k, 1], y + s * ends[k, 0] + c * ends[k, 1]
            reach = math.hypot(to_x - from_x, to_y - from_y)  # all in cells from here on
            if _blocked(strides, from_x, from_y, to_x, to_y, reach, reach - MARGIN / resolution):
                total[i] += math.log(BLOCKED)
                through[i] += 1.0
            elif returned[k]:
                row, column = math.floor(to_y), math.floor(to_x)
                d = FAR
                if 0 <= row < rows and 0 <= column < columns:
                    d = abs(distance[row, column])
                total[i] += math.log(math.exp(-0.5 * (d / deviation) ** 2) * (1.0 - SHORT) + SHORT)
                hits[i] += d < 2.0 * deviation
            else:
                hits[i] += 1.0
    return total, hits, through


@numba.njit(cache=True)
def _blocked(strides: Array, x: float, y: float, to_x: float, to_y: float, reach: float, stop: float) -> bool:
    """Tell whether a line, so long as its ends are apart, meets an occupied cell before it went so far; in cells."""
    if stop <= 0.0:
        return False
    rows, columns = strides.shape
    along_x, along_y = (to_x - x) / reach, (to_y - y) / reach
    gone = 0.0
    while gone < stop:
        row, column = math.floor(y + gone * along_y), math.floor(x + gone * along_x)
        if not (0 <= row < rows and 0 <= column < columns):
            return False
        if strides[row, column] == 0.0:
            return True
        gone += strides[row, column]
    return False
