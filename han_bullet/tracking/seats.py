"""Where the map says that people sit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array, rotation
from han_bullet.messages import Seat

# How far a sitting area reaches behind the middle of the seat [m]: half a couch.
DEPTH_BEHIND = 0.4
# Closer than this along a seat two people cannot sit [m]: adults' shoulders are as broad.
SITTER_WIDTH = 0.45


def in_sitting_area(seat: Seat, positions: Array, margin: float = 0.0) -> NDArray[np.bool_]:
    """Tell which floor points, shape (..., 2) [m], lie on a seat or where the feet before it stand.

    Args:
        seat: The sitting area.
        positions: In the world.
        margin: Added on all four sides [m].
    """
    in_seat = (positions - seat.position_in_world) @ rotation(seat.facing)
    forward, sideways = in_seat[..., 0], in_seat[..., 1]
    inside: NDArray[np.bool_] = (
        (forward >= -DEPTH_BEHIND - margin)
        & (forward <= seat.reach_in_front + margin)
        & (np.abs(sideways) <= 0.5 * seat.width + margin)
    )
    return inside


def has_room_for(seat: Seat, one: Array, other: Array) -> bool:
    """Tell whether two people, shape (2,) [m] each, can sit beside one another on a seat, so far apart along it."""
    along_seat = rotation(seat.facing)[:, 1]
    return bool(abs(along_seat @ (one - other)) >= SITTER_WIDTH)
