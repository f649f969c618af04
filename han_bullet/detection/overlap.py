"""How much boxes overlap."""

from __future__ import annotations

import numpy as np

from han_bullet.geometry import Array


def intersection_over_union(first: Array, second: Array) -> Array:
    """Return the overlap of each box of (n, 4) with each of (m, 4), x, y, width, height; shape (n, m), in [0, 1]."""
    shared, first_area, second_area = _areas(first, second)
    overlap: Array = shared / np.maximum(first_area + second_area - shared, np.finfo(float).tiny)
    return overlap


def intersection_over_first(first: Array, second: Array) -> Array:
    """Return the share of each box of (n, 4) that lies in each of (m, 4); shape (n, m), in [0, 1]."""
    shared, first_area, _ = _areas(first, second)
    share: Array = shared / np.maximum(first_area, np.finfo(float).tiny)
    return share


def _areas(first: Array, second: Array) -> tuple[Array, Array, Array]:
    """Return the shared areas, (n, m), and the boxes' own, (n, 1) and (1, m)."""
    a, b = np.asarray(first, float).reshape(-1, 1, 4), np.asarray(second, float).reshape(1, -1, 4)
    sides = np.minimum(a[..., :2] + a[..., 2:], b[..., :2] + b[..., 2:]) - np.maximum(a[..., :2], b[..., :2])
    return np.prod(np.maximum(sides, 0.0), axis=-1), np.prod(a[..., 2:], axis=-1), np.prod(b[..., 2:], axis=-1)
