"""Walls and furniture as arrays: what all of them hide and hold, found at once."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array, SolidBox


class Solids:
    """Some boxes of the building.

    Args:
        boxes: Walls and furniture.
    """

    def __init__(self, boxes: Sequence[SolidBox] = ()) -> None:
        self._centres = np.array([box.centre_in_world for box in boxes], float).reshape(-1, 3)
        self._halves = 0.5 * np.array([box.size for box in boxes], float).reshape(-1, 3)
        self._yaws = np.array([box.yaw for box in boxes], float)

    def hide(self, eye: Array, targets: Array) -> NDArray[np.bool_]:
        """Tell which straight lines from a camera, (3,), to targets, (n, 3) [m], pass through a box.

        A box whose footprint holds the camera hides nothing: the camera is let into it, or hangs above.
        """
        lines = np.ascontiguousarray(eye), np.ascontiguousarray(targets)
        hidden: NDArray[np.bool_] = _hidden(self._centres, self._halves, self._yaws, *lines)
        return hidden

    def hold(self, places: Array, margin: float) -> NDArray[np.bool_]:
        """Tell which floor points, shape (n, 2) [m], lie inside a footprint grown by a margin [m]."""
        held: NDArray[np.bool_] = _held(self._centres, self._halves, self._yaws, np.ascontiguousarray(places), margin)
        return held


@numba.njit(cache=True)
def _hidden(centres: Array, halves: Array, yaws: Array, eye: Array, targets: Array) -> NDArray[np.bool_]:
    """Do for k boxes what `SolidBox.blocks` does for one that does not hold the eye.

    Args:
        centres: Of the boxes, shape (k, 3) [m].
        halves: Of their sizes, shape (k, 3) [m].
        yaws: Shape (k,) [rad].
        eye: The camera.
        targets: What it looks at.
    """
    hidden = np.zeros(len(targets), np.bool_)
    start, along = np.empty(3), np.empty(3)
    for k in range(len(centres)):
        c, s = math.cos(yaws[k]), math.sin(yaws[k])
        x, y = eye[0] - centres[k, 0], eye[1] - centres[k, 1]
        start[0], start[1], start[2] = x * c + y * s, y * c - x * s, eye[2] - centres[k, 2]
        if abs(start[0]) <= halves[k, 0] and abs(start[1]) <= halves[k, 1]:
            continue
        for i in range(len(targets)):
            x, y = targets[i, 0] - eye[0], targets[i, 1] - eye[1]
            along[0], along[1], along[2] = x * c + y * s, y * c - x * s, targets[i, 2] - eye[2]
            enter, leave = -math.inf, math.inf
            for axis in range(3):
                step = along[axis] if abs(along[axis]) >= 1e-12 else 1e-12
                first, second = (-halves[k, axis] - start[axis]) / step, (halves[k, axis] - start[axis]) / step
                enter, leave = max(enter, min(first, second)), min(leave, max(first, second))
            hidden[i] |= enter < leave and leave > 0.0 and enter < 1.0
    return hidden


@numba.njit(cache=True)
def _held(centres: Array, halves: Array, yaws: Array, places: Array, margin: float) -> NDArray[np.bool_]:
    """Do for k boxes what `SolidBox.contains` does for one; arguments as above."""
    held = np.zeros(len(places), np.bool_)
    for k in range(len(centres)):
        c, s = math.cos(yaws[k]), math.sin(yaws[k])
        for i in range(len(places)):
            x, y = places[i, 0] - centres[k, 0], places[i, 1] - centres[k, 1]
            held[i] |= abs(x * c + y * s) <= halves[k, 0] + margin and abs(y * c - x * s) <= halves[k, 1] + margin
    return held
