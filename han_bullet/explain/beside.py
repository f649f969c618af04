"""One way beside another: how far to its left or right it lies, and on which side it has people."""

from __future__ import annotations

import math

import numpy as np

from han_bullet.explain.explanation import Shift
from han_bullet.geometry import Array, arc_lengths, feet_on, points_at

# Between the points at which ways are compared [m].
STEP = 0.05
# Whoever is farther from a way is not passed [m].
PASSED_WITHIN = 3.0


def length_of(way: Array | None) -> float:
    """Return the length of a polyline, shape (n, 2) [m]; 0 where there is none."""
    return 0.0 if way is None else float(arc_lengths(way)[-1])


def resampled(way: Array) -> Array:
    """Return points every `STEP` or closer along a polyline, shape (n, 2) [m], its two ends included."""
    arcs = arc_lengths(way)
    return points_at(np.linspace(0.0, arcs[-1], 2 + int(arcs[-1] / STEP)), way, arcs)


def shift_between(way: Array | None, other: Array | None) -> Shift | None:
    """Return how far a way lies beside another, to whose left is positive; None where one of them is missing.

    Every point is held against the nearest one of the other way. Beyond the other's ends only what is across counts: a
    way that is merely shorter is not moved.
    """
    if way is None or other is None or min(length_of(way), length_of(other)) < STEP:
        return None
    points = resampled(way)
    beside = np.array([_beside(point, other) for point in points])
    at = int(np.abs(beside).argmax())
    return Shift(float(beside[at]), float(np.abs(beside).mean()), (float(points[at, 0]), float(points[at, 1])))


def side_of(way: Array | None, place: Array) -> str | None:
    """Return on which side of a way, "left" or "right", a place, (2,) [m], lies.

    None where the place is beyond the way's ends or not near it.
    """
    if way is None or length_of(way) < STEP:
        return None
    points = resampled(way)
    nearest = int(np.linalg.norm(points - place, axis=1).argmin())
    if nearest in (0, len(points) - 1) or np.linalg.norm(points[nearest] - place) > PASSED_WITHIN:
        return None
    return "left" if _beside(place, way) > 0.0 else "right"


def _beside(point: Array, way: Array) -> float:
    """Return the signed distance [m] of a point, (2,), from a polyline, (n, 2): left is positive."""
    shares, feet = feet_on(way, point)
    distances = np.hypot(*(point - feet).T)
    k = int(distances.argmin())
    (along_x, along_y), (x, y) = way[k + 1] - way[k], point - way[k]
    across = float(along_x * y - along_y * x) / max(math.hypot(along_x, along_y), 1e-12)
    beyond = (k == 0 and shares[k] == 0.0) or (k == len(shares) - 1 and shares[k] == 1.0)
    return across if beyond else float(np.copysign(distances[k], across))
