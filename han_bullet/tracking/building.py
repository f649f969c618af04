"""Where in the building people can be."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array
from han_bullet.world_schema import FloorArea

# How far a foot point may err into a wall, a table or off the floor [m]: a large but common error along the ray.
BUILDING_TOLERANCE = 0.3


def on_floor(floor: Sequence[FloorArea], positions: Array, margin: float = BUILDING_TOLERANCE) -> NDArray[np.bool_]:
    """Tell which positions, shape (n, 2) [m], lie on a piece of floor grown by a margin [m]; without floor: all."""
    inside = np.full(len(positions), not floor)
    for area in floor:
        inside |= area.contains(positions, margin)
    return inside
