"""Triangle meshes of the solids that URDF files name: pure numpy."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from han_bullet.geometry import Array, SolidBox
from han_bullet.sim.surfaces import Surface, box_sides, grid_triangles, joined

SEGMENTS = 32  # around a cylinder or a sphere


def box(size: Sequence[float]) -> Surface:
    """Return a box about the origin; its size along x, y, z [m]."""
    return joined(box_sides(SolidBox("", "object", np.zeros(3), np.asarray(size, float), 0.0), with_bottom=True))


def cylinder(length: float, radius: float) -> Surface:
    """Return a cylinder about the origin along z [m]."""
    half = 0.5 * length
    side = _turned(np.array([[radius, -half], [radius, half]]), np.array([[1.0, 0.0], [1.0, 0.0]]))
    top = _turned(np.array([[radius, half], [0.0, half]]), np.array([[0.0, 1.0], [0.0, 1.0]]))
    bottom = _turned(np.array([[0.0, -half], [radius, -half]]), np.array([[0.0, -1.0], [0.0, -1.0]]))
    return joined([side, top, bottom])


def sphere(radius: float) -> Surface:
    """Return a sphere about the origin [m]."""
    angles = np.linspace(-0.5 * math.pi, 0.5 * math.pi, SEGMENTS // 2 + 1)
    outward = np.column_stack([np.cos(angles), np.sin(angles)])
    return _turned(radius * outward, outward)


def _turned(profile: Array, normals: Array) -> Surface:
    """Turn a profile about z; rows are (distance from the axis, height), outside on the right-hand side going up."""
    angles = np.linspace(0.0, 2.0 * math.pi, SEGMENTS + 1)
    around = np.column_stack([np.cos(angles), np.sin(angles)])
    vertices, directions = (
        np.concatenate([np.column_stack([r * around, np.full(len(around), z)]) for r, z in rows])
        for rows in (profile, normals)
    )
    return Surface(vertices, directions, np.zeros((len(vertices), 2)), grid_triangles(len(around), len(profile)))
