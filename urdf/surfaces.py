"""Surfaces as triangles: from signed distance fields, by turning a profile, as rounded boxes; and OBJ files of them.

Normals point outward and faces are wound counter-clockwise seen from outside, as renderers that cull back faces need.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from skimage.measure import marching_cubes

Array = NDArray[np.float64]
Faces = NDArray[np.int64]
Field = Callable[[Array], Array]  # points (n, 3) [m] -> signed distances (n,) [m], negative inside


def ellipsoid(centre: tuple[float, float, float], radii: tuple[float, float, float]) -> Field:
    """Return the field of an ellipsoid (first-order distance, exact on the surface)."""

    def field(points: Array) -> Array:
        scaled = (points - centre) / radii
        length = np.linalg.norm(scaled, axis=1)
        return length * (length - 1.0) / np.maximum(np.linalg.norm(scaled / radii, axis=1), 1e-9)

    return field


def capsule(a: tuple[float, float, float], b: tuple[float, float, float], radius_a: float, radius_b: float) -> Field:
    """Return the field of a capsule whose radius changes linearly from end a to end b."""
    start, along = np.array(a), np.array(b) - np.array(a)

    def field(points: Array) -> Array:
        share = np.clip((points - start) @ along / (along @ along), 0.0, 1.0)
        distance = np.linalg.norm(points - start - share[:, None] * along, axis=1)
        return distance - (radius_a + share * (radius_b - radius_a))

    return field


def union(*fields: Field, blend: float = 0.02) -> Field:
    """Return the smooth union: within the blend [m] the parts flow into each other."""

    def field(points: Array) -> Array:
        total = fields[0](points)
        for other in fields[1:]:
            values = other(points)
            mix = np.maximum(blend - np.abs(total - values), 0.0) / blend
            total = np.minimum(total, values) - 0.25 * blend * mix**2
        return total

    return field


def cut(field: Field, keep: Field) -> Field:
    """Return the part of a body where another field is negative."""
    return lambda points: np.maximum(field(points), keep(points))


@dataclass(frozen=True)
class Part:
    """A mesh to be: a field, the box to look in and the spacing of the grid [m]."""

    field: Field
    lower: tuple[float, float, float]
    upper: tuple[float, float, float]
    spacing: tuple[float, float, float]


@dataclass(frozen=True)
class Mesh:
    """Triangles.

    Attributes:
        vertices: Shape (n, 3) [m].
        normals: Outward unit vectors, shape (n, 3).
        faces: Vertex indices, shape (m, 3).
        texture: Texture coordinates, shape (n, 2), or None.
    """

    vertices: Array
    normals: Array
    faces: Faces
    texture: Array | None = None

    def moved(self, by: tuple[float, float, float], turn: Array | None = None) -> Mesh:
        """Return the mesh turned by a rotation matrix (3, 3), then moved [m]."""
        rotation = np.eye(3) if turn is None else turn
        return Mesh(self.vertices @ rotation.T + by, self.normals @ rotation.T, self.faces, self.texture)


def joined(*meshes: Mesh) -> Mesh:
    """Return several meshes as one."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    textures = [mesh.texture for mesh in meshes if mesh.texture is not None]
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate(faces),
        np.concatenate(textures) if len(textures) == len(meshes) else None,
    )


def mesh_of(part: Part) -> Mesh:
    """Return the surface of a part: marching cubes on its grid, then every vertex moved onto the exact surface."""
    axes = [
        low + step * np.arange(int(np.ceil((high - low) / step)) + 1)
        for low, high, step in zip(part.lower, part.upper, part.spacing, strict=True)
    ]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    volume = part.field(grid.reshape(-1, 3)).reshape(grid.shape[:3])
    vertices, faces, _, _ = marching_cubes(volume, 0.0, spacing=part.spacing, gradient_direction="ascent")
    vertices = vertices.astype(float) + part.lower
    for _ in range(4):
        step = np.clip(part.field(vertices), -0.01, 0.01)
        vertices -= step[:, None] * gradient(part.field, vertices)
    vertices, faces = weld(vertices, faces.astype(np.int64), 0.3 * np.array(part.spacing))
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    volume_times_six = np.einsum("ij,ij->", a, np.cross(b, c))
    return Mesh(vertices, gradient(part.field, vertices), faces if volume_times_six > 0.0 else faces[:, ::-1])


def weld(vertices: Array, faces: Faces, cell: Array) -> tuple[Array, Faces]:
    """Join the vertices that share a cell [m] and drop the slivers that vanish by it."""
    _, first, inverse = np.unique(
        np.round(vertices / cell).astype(np.int64), axis=0, return_index=True, return_inverse=True
    )
    faces = inverse.reshape(-1)[faces]
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return vertices[first], faces[whole]


def wound_outward(vertices: Array, normals: Array, faces: Faces) -> Faces:
    """Return the faces, those that look inward turned over."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), normals[faces].sum(axis=1)) < 0.0
    turned = faces.copy()
    turned[inward] = faces[inward][:, ::-1]
    return turned


def gradient(field: Field, points: Array, step: float = 1e-3) -> Array:
    """Return the unit gradients of a field at points, (n, 3); they point outward."""
    slopes = np.stack([field(points + step * axis) - field(points - step * axis) for axis in np.eye(3)], axis=1)
    unit: Array = slopes / np.maximum(np.linalg.norm(slopes, axis=1, keepdims=True), 1e-12)
    return unit


def lathe(profile: list[tuple[float, float]], sides: int) -> Mesh:
    """Return the body that a profile of (radius, height) [m], from bottom to top, sweeps about z.

    Edges of the profile are sharp: each segment has its own normals.
    """
    angles = 2.0 * np.pi * np.arange(sides + 1) / sides
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
    bands = []
    for (r0, z0), (r1, z1) in itertools.pairwise(profile):
        vertices = np.concatenate([ring * r0 + (0.0, 0.0, z0), ring * r1 + (0.0, 0.0, z1)])
        normal = ring * (z1 - z0) + (0.0, 0.0, r0 - r1)
        normals = np.tile(normal / np.linalg.norm(normal, axis=1, keepdims=True), (2, 1))
        i = np.arange(sides)
        up, down = np.stack([i, i + 1, i + sides + 2], 1), np.stack([i, i + sides + 2, i + sides + 1], 1)
        faces = [part for part, radius in ((down, r1), (up, r0)) if radius > 0.0]
        bands.append(Mesh(vertices, normals, wound_outward(vertices, normals, np.concatenate(faces))))
    return joined(*bands)


def rounded_box(size: tuple[float, float, float], radius: float, cuts: int = 2) -> Mesh:
    """Return a box of a size with rounded edges [m] about the origin; texture coordinates are metres on each side."""
    half = np.array(size) / 2.0
    sides = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            stops_u, stops_v = _stops(half[u], radius, cuts), _stops(half[v], radius, cuts)
            grid = np.zeros((len(stops_u), len(stops_v), 3))
            grid[..., axis], grid[..., u], grid[..., v] = sign * half[axis], stops_u[:, None], stops_v[None, :]
            flat = grid.reshape(-1, 3)
            core = np.clip(flat, radius - half, half - radius)
            normals = (flat - core) / np.linalg.norm(flat - core, axis=1, keepdims=True)
            faces = _grid_faces(len(stops_u), len(stops_v))
            vertices = core + radius * normals
            sides.append(Mesh(vertices, normals, wound_outward(vertices, normals, faces), flat[:, [u, v]]))
    return joined(*sides)


def _stops(half: float, radius: float, cuts: int) -> Array:
    """Return where a side is divided so that the rounded edge gets equal angles [m]."""
    edge = radius * np.tan(np.linspace(0.0, np.pi / 4.0, cuts + 1))
    return np.concatenate([-(half - radius) - edge[::-1], half - radius + edge])


def _grid_faces(rows: int, columns: int) -> Faces:
    i = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)[None, :]).reshape(-1)
    return np.concatenate([np.stack([i, i + 1, i + columns], 1), np.stack([i + 1, i + columns + 1, i + columns], 1)])


def write_obj(path: Path, mesh: Mesh, picture: str | None = None) -> int:
    """Write a mesh, with a picture on it if one is named; return its number of triangles."""
    lines = [] if picture is None else [f"mtllib {path.stem}.mtl", "usemtl cloth"]
    lines += [f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in mesh.vertices]
    if mesh.texture is not None:
        lines += [f"vt {u:.3f} {v:.3f}" for u, v in mesh.texture]
    lines += [f"vn {x:.3f} {y:.3f} {z:.3f}" for x, y, z in mesh.normals]
    between = "//" if mesh.texture is None else "/{0}/"
    lines += ["f " + " ".join(f"{i}{between.format(i)}{i}" for i in face) for face in mesh.faces + 1]
    path.write_text("\n".join(lines) + "\n")
    if picture is not None:
        path.with_suffix(".mtl").write_text(f"newmtl cloth\nKd 1 1 1\nmap_Kd {picture}\n")
    return len(mesh.faces)
