"""The visible meshes of a URDF body, carried along with its links."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pybullet
from numpy.typing import NDArray

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array
from han_bullet.sim.mesh import Mesh, painted
from han_bullet.sim.obj_file import read_obj
from han_bullet.sim.raster import Image
from han_bullet.sim.solids import box, cylinder, sphere
from han_bullet.sim.surfaces import Surface, joined

BASE = -1  # PyBullet's number of the base as a link


class JointedBody:
    """A body as it looks, wherever its joints are."""

    def __init__(self, client: int, body: int) -> None:
        """Read its meshes; their colours must have been set.

        Args:
            client: PyBullet client.
            body: Its id there; of OBJ meshes, boxes, cylinders and spheres.

        Raises:
            BadInputError: Some visible part is none of these, or its file cannot be read.
        """
        self._client = client
        self._body = body
        shapes = pybullet.getVisualShapeData(body, physicsClientId=client)
        parts = [_part(shape) for shape in shapes if shape[7][3] > 0.0]  # parts with alpha 0 are never drawn
        self._links = sorted({part.link for part in parts})
        self._groups = [_joined(group, self._links) for group in _by_texture(parts)]
        *_, offset, turn = pybullet.getDynamicsInfo(body, BASE, physicsClientId=client)[:5]
        self._base_in_inertial = np.linalg.inv(_pose(offset, turn))

    def meshes_in_world(self) -> list[Mesh]:
        """Return the meshes where they are now, in the world's frame [m]."""
        poses = self._link_poses()
        return [group.posed(poses) for group in self._groups]

    def _link_poses(self) -> Array:
        """Return the poses in the world of the links that have something to show, shape (n, 4, 4)."""
        jointed = [link for link in self._links if link != BASE]
        states = pybullet.getLinkStates(
            self._body, jointed, computeForwardKinematics=True, physicsClientId=self._client
        )
        poses = dict(zip(jointed, (_pose(state[4], state[5]) for state in states), strict=True))
        if BASE in self._links:
            inertial = pybullet.getBasePositionAndOrientation(self._body, physicsClientId=self._client)
            poses[BASE] = _pose(*inertial) @ self._base_in_inertial
        return np.array([poses[link] for link in self._links])


@dataclass(frozen=True)
class _Part:
    """One visible shape: its surface in the frame of its link, and its look."""

    link: int
    surface: Surface
    texture: Path | None
    colour: tuple[float, float, float]


@dataclass(frozen=True)
class _Group:
    """Parts that share a picture: their mesh in the frames of their links, and each vertex's row among the poses."""

    mesh: Mesh
    rows: NDArray[np.int64]

    def posed(self, link_poses: Array) -> Mesh:
        surface, poses = self.mesh.surface, link_poses[self.rows]
        vertices = np.einsum("nij,nj->ni", poses[:, :3, :3], surface.vertices) + poses[:, :3, 3]
        normals = np.einsum("nij,nj->ni", poses[:, :3, :3], surface.normals)
        return Mesh(replace(surface, vertices=vertices, normals=normals), self.mesh.picture)


def _part(shape: tuple[Any, ...]) -> _Part:
    """Return what one entry of getVisualShapeData shows."""
    link, kind, size, file, position, turn, rgba = shape[1:8]
    texture: Path | None = None
    if kind == pybullet.GEOM_MESH and Path(file.decode()).suffix.lower() == ".obj":
        surface, texture = read_obj(Path(file.decode()))
        surface = replace(surface, vertices=surface.vertices * size)
    elif kind == pybullet.GEOM_BOX:
        surface = box(size)
    elif kind == pybullet.GEOM_CYLINDER:
        surface = cylinder(length=size[0], radius=size[1])
    elif kind == pybullet.GEOM_SPHERE:
        surface = sphere(radius=size[0])
    else:
        what = f"the mesh {file.decode()}" if kind == pybullet.GEOM_MESH else f"a shape of PyBullet's kind {kind}"
        raise BadInputError(
            f"a visible part of link {link} is {what}; OBJ meshes, boxes, cylinders, spheres can be drawn"
        )
    pose = _pose(position, turn)
    vertices = surface.vertices @ pose[:3, :3].T + pose[:3, 3]
    surface = replace(surface, vertices=vertices, normals=surface.normals @ pose[:3, :3].T)
    return _Part(link, surface, texture, rgba[:3])


def _by_texture(parts: Sequence[_Part]) -> list[list[_Part]]:
    """Put the plain parts together; each textured one stays alone."""
    groups: dict[object, list[_Part]] = defaultdict(list)
    for number, part in enumerate(parts):
        groups[None if part.texture is None else number].append(part)
    return list(groups.values())


def _joined(parts: Sequence[_Part], links: Sequence[int]) -> _Group:
    rows = np.repeat([links.index(part.link) for part in parts], [len(part.surface.vertices) for part in parts])
    if parts[0].texture is not None:
        return _Group(painted(parts[0].surface, parts[0].texture, parts[0].colour), rows)
    # One pixel of the picture for each plain part.
    looks = [painted(part.surface, None, part.colour) for part in parts]
    palette: Image = np.concatenate([look.picture for look in looks], axis=1)
    surfaces = [
        replace(part.surface, uvs=np.tile([(number + 0.5) / len(parts), 0.5], (len(part.surface.vertices), 1)))
        for number, part in enumerate(parts)
    ]
    return _Group(Mesh(joined(surfaces), palette), rows)


def _pose(position: Sequence[float], quaternion: Sequence[float]) -> Array:
    pose = np.eye(4)
    pose[:3, :3] = np.array(pybullet.getMatrixFromQuaternion(quaternion)).reshape(3, 3)
    pose[:3, 3] = position
    return pose
