"""Seats that a fixed camera shows to be empty: where somebody seated would be, nothing differs from its empty scene.

That nobody was detected on a seat says little, for seated people are the hardest to detect. That not even the pixels
have changed says that nobody is there. Robot or people before or behind the seat change them too, and then it says
nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.still_scene import Changes
from han_bullet.geometry import Array, Intrinsics, SolidBox, project, rotation, wrap_angle
from han_bullet.messages import Seat

# Of the box that somebody seated fills [m]: across the seat, behind its middle, before it, and from floor to crown.
WIDTH, BEHIND, BEFORE, HEIGHT = 0.5, 0.2, 0.6, 1.25
# Between the places on a seat that are looked at [m].
STEP = 0.25
# Points of that box, along and across the seat and upwards, that must be in the image and not hidden: so many of them.
GRID = (3, 3, 6)
LEAST_IN_VIEW = 0.8
# The furniture that one sits in hides nothing of who looks at most so far past the camera [rad].
LARGEST_TURN = math.radians(60.0)
# Lower boxes have too few cells to tell [px].
SMALLEST_BOX = 64.0
# A larger part changed of any of the boxes on a seat, and it may be taken. Under noise of 2 and 6 grey levels
# the empty couch of real3 and sim2 changes 0.0000 of them (1280 pictures, 8 seeds), somebody on it at least 0.36 (640
# pictures, every outfit and build, at five places), and their head alone, were all else of the couch's colour, 0.04.
LARGEST_CHANGED_PART = 0.01


@dataclass(frozen=True)
class SeatInView:
    """A seat that a fixed camera has in view.

    Attributes:
        name: Of the sitting area.
        boxes: Of people who would sit there side by side, shape (n, 4): x, y, width, height [px].
    """

    name: str
    boxes: Array

    def is_empty(self, changes: Changes) -> bool:
        """Tell whether nobody sits there nor hides it in an image that differs so from the empty scene."""
        return bool(changes.part_of(self.boxes).max() <= LARGEST_CHANGED_PART)


def seats_in_view(
    seats: Sequence[Seat], obstacles: Sequence[SolidBox], intrinsics: Intrinsics, camera_in_world: Array
) -> tuple[SeatInView, ...]:
    """Return the seats of which a fixed camera sees enough to tell that they are empty.

    Args:
        seats: Sitting areas of the map.
        obstacles: Walls and furniture.
        intrinsics: The camera.
        camera_in_world: Its pose, shape (4, 4).
    """
    in_view = ((seat, _boxes_in_view(seat, obstacles, intrinsics, camera_in_world)) for seat in seats)
    return tuple(SeatInView(seat.name, boxes) for seat, boxes in in_view if boxes is not None)


def _boxes_in_view(
    seat: Seat, obstacles: Sequence[SolidBox], intrinsics: Intrinsics, camera_in_world: Array
) -> Array | None:
    """Return the boxes of those who would sit there, (n, 4) [px]; None where too little of one of them would show."""
    bodies = _bodies(seat)
    pixels, depths = project(bodies, intrinsics, camera_in_world)
    if (depths <= 0.0).any():
        return None
    size = np.array([intrinsics.width, intrinsics.height])
    inside = ((pixels >= 0.0) & (pixels <= size)).all(axis=-1)
    shown = inside & ~_hidden(bodies, seat, obstacles, camera_in_world[:3, 3])
    corners, sizes = pixels.min(axis=1), np.ptp(pixels, axis=1)
    if shown.mean(axis=1).min() < LEAST_IN_VIEW or sizes[:, 1].min() < SMALLEST_BOX:
        return None
    return np.hstack([corners, sizes])


def _bodies(seat: Seat) -> Array:
    """Return points all over the boxes that people fill who sit side by side, shape (people, points, 3) [m]."""
    room = max(0.5 * (seat.width - WIDTH), 0.0)
    middles = np.linspace(-room, room, 1 + int(np.ceil(2.0 * room / STEP)))
    ends = ((-BEHIND, BEFORE), (-0.5 * WIDTH, 0.5 * WIDTH), (0.0, HEIGHT))
    axes = [np.linspace(*end, count) for end, count in zip(ends, GRID, strict=True)]
    body = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
    in_seat = np.array([body + np.array([0.0, middle, 0.0]) for middle in middles])
    on_floor = seat.position_in_world + in_seat[..., :2] @ rotation(seat.facing).T
    return np.concatenate([on_floor, in_seat[..., 2:]], axis=-1)


def _hidden(bodies: Array, seat: Seat, obstacles: Sequence[SolidBox], eye: Array) -> NDArray[np.bool_]:
    """Tell which points, shape (people, points, 3) [m], walls and furniture hide from a camera at (3,) [m]."""
    hidden = np.zeros(bodies.shape[:2], bool)
    to_eye = eye[:2] - seat.position_in_world
    from_front = abs(wrap_angle(math.atan2(to_eye[1], to_eye[0]) - seat.facing)) <= LARGEST_TURN
    for box in obstacles:
        holds_them = from_front and bool(box.contains(seat.position_in_world))
        if not holds_them and not box.contains(eye[:2]):  # a camera may be let into a wall
            hidden |= box.blocks(eye, bodies.reshape(-1, 3)).reshape(hidden.shape)
    return hidden
