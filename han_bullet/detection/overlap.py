"""How much boxes overlap."""

from __future__ import annotations

import numpy as np

from han_bullet.geometry import Array


def intersection_over_union(first: Array, second: Array) -> Array:
    """Return the overlap of each box of (n, 4) with each of (m, 4), x, y, width, height; shape (n, m), in [0, 1]."""
    a, b = np.asarray(first, float).reshape(-1, 1, 4), np.asarray(second, float).reshape(1, -1, 4)
    sides = np.minimum(a[..., :2] + a[..., 2:], b[..., :2] + b[..., 2:]) - np.maximum(a[..., :2], b[..., :2])
    shared = np.prod(np.maximum(sides, 0.0), axis=-1)
    union = np.prod(a[..., 2:], axis=-1) + np.prod(b[..., 2:], axis=-1) - shared
    overlap: Array = shared / np.maximum(union, np.finfo(float).tiny)
    return overlap
