"""Where a jointed body is in space, part by part, so that only its own part of an image need be drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pybullet

from han_bullet.errors import HanError
from han_bullet.geometry import Array

_CORNERS = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])


class BodyOutline:
    """A box around each visible mesh of a body, carried along with its link."""

    def __init__(self, client: int, body: int) -> None:
        """Read the meshes' extents from their files.

        Args:
            client: PyBullet client.
            body: Its id there; URDF with OBJ meshes that sit in their links without a turn, base without an offset.

        Raises:
            HanError: Some visible part is not such a mesh.
        """
        self._client = client
        self._body = body
        shapes = pybullet.getVisualShapeData(body, physicsClientId=client)
        seen = [shape for shape in shapes if shape[7][3] > 0.0]  # parts with alpha 0 are never drawn
        self._links = sorted({shape[1] for shape in seen})
        rows = [self._links.index(shape[1]) for shape in seen]
        self._rows = np.repeat(rows, len(_CORNERS))
        self._corners_in_link = np.concatenate([_mesh_corners(shape) for shape in seen])

    def corners_in_world(self) -> Array:
        """Return points whose hull holds the whole body as it is posed now, shape (n, 3) [m]."""
        frames = [self._link_frame(link) for link in self._links]
        turns = np.array([turn for _, turn in frames])
        origins = np.array([origin for origin, _ in frames])
        turned = np.einsum("nij,nj->ni", turns[self._rows], self._corners_in_link)
        corners: Array = turned + origins[self._rows]
        return corners

    def _link_frame(self, link: int) -> tuple[tuple[float, ...], Array]:
        """Return origin and rotation matrix of a link in the world."""
        if link == -1:
            origin, quaternion = pybullet.getBasePositionAndOrientation(self._body, physicsClientId=self._client)
        else:
            state = pybullet.getLinkState(self._body, link, computeForwardKinematics=True, physicsClientId=self._client)
            origin, quaternion = state[4:6]
        return origin, np.array(pybullet.getMatrixFromQuaternion(quaternion)).reshape(3, 3)


def _mesh_corners(shape: tuple[Any, ...]) -> Array:
    """Return the corners, (8, 3) [m], of the box around the mesh of one entry of getVisualShapeData."""
    kind, scale, file, position, quaternion = shape[2:7]
    path = Path(file.decode())
    if kind != pybullet.GEOM_MESH or path.suffix != ".obj" or any(position) or any(quaternion[:3]):
        raise HanError(
            f"a visible part of link {shape[1]} is not an OBJ mesh in its link's own frame (it is {shape[2:7]})"
        )
    with path.open(encoding="utf-8") as lines:
        vertices = np.array([line.split()[1:4] for line in lines if line.startswith("v ")], float) * scale
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    corners: Array = low + _CORNERS * (high - low)
    return corners
