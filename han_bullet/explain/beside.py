"""One way beside another: how far to its left or right it lies, and on which side it has people."""

from __future__ import annotations

import numpy as np

from han_bullet.explain.explanation import Shift
from han_bullet.geometry import Array

# Between the points at which ways are compared [m].
STEP = 0.05
# Whoever is farther from a way is not passed [m].
PASSED_WITHIN = 3.0


def length_of(way: Array | None) -> float:
    """Return the length of a polyline, shape (n, 2) [m]; 0 where there is none."""
    return 0.0 if way is None else float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())


def resampled(way: Array) -> Array:
    """Return points every `STEP` or closer along a polyline, shape (n, 2) [m], its two ends included."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))])
    stations = np.linspace(0.0, along[-1], 2 + int(along[-1] / STEP))
    return np.column_stack([np.interp(stations, along, way[:, axis]) for axis in (0, 1)])


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
    starts, steps = way[:-1], np.diff(way, axis=0)
    lengths = np.maximum(np.linalg.norm(steps, axis=1), 1e-12)
    share = np.clip(((point - starts) * steps).sum(axis=1) / lengths**2, 0.0, 1.0)
    gaps = point - (starts + share[:, None] * steps)
    distances = np.linalg.norm(gaps, axis=1)
    k = int(distances.argmin())
    across = float(steps[k, 0] * (point - starts[k])[1] - steps[k, 1] * (point - starts[k])[0]) / float(lengths[k])
    beyond = (k == 0 and share[k] == 0.0) or (k == len(steps) - 1 and share[k] == 1.0)
    return across if beyond else float(np.copysign(distances[k], across))
