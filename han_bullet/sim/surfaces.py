"""Triangle meshes of flat rectangles in tiles of at most a metre: pure numpy.

PyBullet's software renderer, with which a test compares ours, drops a polygon that is much larger than its distance to
the camera, so nothing is drawn as one big face. All faces are one-sided: seen from the right-hand side of (along x up)
only.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array, SolidBox, rotation

LARGEST_TILE = 1.0  # [m]; 13 m floors vanish from some views, tiles of 1 m from none that we tried


@dataclass(frozen=True)
class Surface:
    """A textured triangle mesh.

    Attributes:
        vertices: Shape (n, 3) [m].
        normals: Shape (n, 3), towards the side from which the surface is seen.
        uvs: Texture coordinates, shape (n, 2); the picture repeats at whole numbers.
        triangles: Rows of vertices, counter-clockwise from the visible side, shape (m, 3).
    """

    vertices: Array
    normals: Array
    uvs: Array
    triangles: NDArray[np.int64]


def rectangle(corner: Array, along: Array, up: Array, uv_at_corner: tuple[float, float] = (0.0, 0.0)) -> Surface:
    """Tile a rectangle; its texture has real size, one picture per metre.

    Args:
        corner: Shape (3,) [m].
        along: Edge from that corner, shape (3,) [m].
        up: The other edge; the visible side is that of along x up.
        uv_at_corner: Texture coordinates of the corner [m].
    """
    length, height = float(np.linalg.norm(along)), float(np.linalg.norm(up))
    s = np.linspace(0.0, 1.0, _tiles(length) + 1)
    t = np.linspace(0.0, 1.0, _tiles(height) + 1)
    s_grid, t_grid = (grid.ravel() for grid in np.meshgrid(s, t))
    vertices = corner + s_grid[:, None] * along + t_grid[:, None] * up
    uvs = np.column_stack([s_grid * length, t_grid * height]) + np.asarray(uv_at_corner)
    normal = np.cross(along, up) / (length * height)
    return Surface(vertices, np.tile(normal, (len(vertices), 1)), uvs, grid_triangles(len(s), len(t)))


def stretched(surface: Surface) -> Surface:
    """Return the surface with one picture over all of it."""
    return Surface(surface.vertices, surface.normals, surface.uvs / surface.uvs.max(axis=0), surface.triangles)


def turned(surface: Surface) -> Surface:
    """Return the surface with its texture turned by a right angle."""
    return Surface(surface.vertices, surface.normals, surface.uvs[:, ::-1], surface.triangles)


def box_sides(box: SolidBox, *, with_bottom: bool = False) -> list[Surface]:
    """Tile the outer sides of a box: front (+y), back, right (+x), left, top and perhaps the bottom."""
    turn = np.eye(3)
    turn[:2, :2] = rotation(box.yaw)
    x, y, z = (turn * box.size).T
    centre = box.centre_in_world
    sides = [
        rectangle(centre + 0.5 * (x + y - z), -x, z),
        rectangle(centre - 0.5 * (x + y + z), x, z),
        rectangle(centre + 0.5 * (x - y - z), y, z),
        rectangle(centre - 0.5 * (x - y + z), -y, z),
        rectangle(centre - 0.5 * (x + y - z), x, y),
    ]
    if with_bottom:
        sides.append(rectangle(centre - 0.5 * (x - y + z), x, -y))
    return sides


def joined(surfaces: Sequence[Surface]) -> Surface:
    """Return several surfaces as one mesh."""
    offsets = np.cumsum([0, *(len(surface.vertices) for surface in surfaces[:-1])])
    return Surface(
        np.concatenate([surface.vertices for surface in surfaces]),
        np.concatenate([surface.normals for surface in surfaces]),
        np.concatenate([surface.uvs for surface in surfaces]),
        np.concatenate([surface.triangles + offset for surface, offset in zip(surfaces, offsets, strict=True)]),
    )


def _tiles(length: float) -> int:
    return max(1, math.ceil(length / LARGEST_TILE - 1e-6))


def grid_triangles(columns: int, rows: int) -> NDArray[np.int64]:
    """Return two triangles for each cell of a grid of vertices, row after row, shape (m, 3)."""
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    lower = np.column_stack([first, first + 1, first + columns + 1])
    upper = np.column_stack([first, first + columns + 1, first + columns])
    triangles: NDArray[np.int64] = np.concatenate([lower, upper]).astype(np.int64)
    return triangles
