"""The building of a world in a PyBullet client: a room to look at, or a room to bump into."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path

import pybullet

from han_bullet import assets
from han_bullet.errors import BadInputError
from han_bullet.geometry import SolidBox
from han_bullet.sim.room_surfaces import (
    SCREEN_DARK,
    SCREEN_LIT,
    SCREEN_TEXTURE,
    Material,
    device_boxes,
    furniture_boxes,
    plain_furniture,
    room_surfaces,
    screen,
)
from han_bullet.sim.surfaces import Surface
from han_bullet.world_schema import TV, World

AWAY = [0.0, 0.0, -100.0]  # [m]


class VisualRoom:
    """Floors, walls, furniture and devices as they look; nothing in here collides."""

    def __init__(self, client: int, world: World) -> None:
        self._client = client
        self._textures: dict[str, int] = {}
        for material, surface in room_surfaces(world).items():
            self._add(material, surface)
        self._fleeting: dict[str, int] = {}
        for box, piece in zip(furniture_boxes(world), world.furniture, strict=True):
            if piece.urdf is not None:
                body = load_furniture(client, piece.urdf, box)
            elif piece.until is not None:
                body = self._add(*plain_furniture(box, piece))
            if piece.until is not None:
                self._fleeting[piece.name] = body
        pairs = zip(world.devices, device_boxes(world), strict=True)
        self._screens = {tv.name: self._add_tv(tv, box) for tv, box in pairs}

    def show_devices(self, devices_on: Iterable[tuple[str, bool]]) -> None:
        """Light or darken the screens."""
        for device, on in devices_on:
            colour = (*(SCREEN_LIT if on else SCREEN_DARK), 1.0)
            pybullet.changeVisualShape(self._screens[device], -1, rgbaColor=colour, physicsClientId=self._client)

    def take_away(self, names: Iterable[str]) -> None:
        """Let pieces of furniture vanish."""
        for name in names:
            body = self._fleeting[name]
            pybullet.resetBasePositionAndOrientation(body, AWAY, [0.0, 0.0, 0.0, 1.0], physicsClientId=self._client)

    def _add_tv(self, tv: TV, box: SolidBox) -> int:
        return self._add(Material(SCREEN_TEXTURE, SCREEN_DARK), screen(tv, box))

    def _add(self, material: Material, surface: Surface) -> int:
        shape = pybullet.createVisualShape(
            pybullet.GEOM_MESH,
            vertices=surface.vertices.tolist(),
            normals=surface.normals.tolist(),
            uvs=surface.uvs.tolist(),
            indices=surface.triangles.ravel().tolist(),
            rgbaColor=[*material.colour, 1.0],
            physicsClientId=self._client,
        )
        body: int = pybullet.createMultiBody(0.0, -1, shape, physicsClientId=self._client)
        if material.texture is not None:
            texture = self._texture(material.texture)
            pybullet.changeVisualShape(body, -1, textureUniqueId=texture, physicsClientId=self._client)
        return body

    def _texture(self, name: str) -> int:
        if name not in self._textures:
            path = texture_path(name)
            self._textures[name] = pybullet.loadTexture(str(path), physicsClientId=self._client)
        return self._textures[name]


def load_furniture(client: int, urdf: str, box: SolidBox) -> int:
    """Put a piece of furniture where its box stands; return its body id."""
    bottom = box.centre_in_world[2] - 0.5 * box.size[2]
    body: int = pybullet.loadURDF(
        str(urdf_path(urdf)),
        [*box.centre_in_world[:2], bottom],
        yaw_quaternion(box.yaw),
        useFixedBase=True,
        physicsClientId=client,
    )
    return body


class CollisionRoom:
    """A ground plane and boxes for walls, furniture and devices.

    Args:
        client: PyBullet client.
        boxes: What is solid.

    Attributes:
        bodies: Body id -> the box that it stands for.
    """

    def __init__(self, client: int, boxes: Sequence[SolidBox]) -> None:
        ground = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
        pybullet.createMultiBody(0.0, ground, physicsClientId=client)
        self._client = client
        self.bodies = {_collision_box(client, box): box for box in boxes}

    def take_away(self, name: str) -> None:
        """Put a piece of furniture out of everybody's way; its body stays, for ids must not change."""
        (body,) = (body for body, box in self.bodies.items() if box.kind == "object" and box.name == name)
        pybullet.resetBasePositionAndOrientation(body, AWAY, [0.0, 0.0, 0.0, 1.0], physicsClientId=self._client)


def _collision_box(client: int, box: SolidBox) -> int:
    half = (0.5 * box.size).tolist()
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client)
    body: int = pybullet.createMultiBody(
        0.0, shape, -1, box.centre_in_world.tolist(), yaw_quaternion(box.yaw), physicsClientId=client
    )
    return body


def yaw_quaternion(yaw: float) -> list[float]:
    """Return the quaternion (x, y, z, w) of a turn about the vertical [rad]."""
    return [0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw)]


def texture_path(name: str) -> Path:
    """Return the picture of a texture.

    Raises:
        BadInputError: No texture has that name.
    """
    folder = assets.urdf_folder() / "textures"
    path = folder / f"{name}.png"
    if not path.is_file():
        known = sorted(picture.stem for picture in folder.glob("*.png"))
        raise BadInputError(f"texture {name!r} is not in {folder}; there are {', '.join(known)}")
    return path


def urdf_path(name: str) -> Path:
    """Return a file of the URDF folder.

    Raises:
        BadInputError: There is no such file.
    """
    path = assets.urdf_folder() / name
    if not path.is_file():
        known = sorted(file.name for file in assets.urdf_folder().glob("*.urdf"))
        raise BadInputError(f"URDF {name!r} is not in {assets.urdf_folder()}; there are {', '.join(known)}")
    return path
