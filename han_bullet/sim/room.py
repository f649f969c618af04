"""The building of a world in a PyBullet client: a room to look at, or a room to bump into."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pybullet

from han_bullet import assets
from han_bullet.errors import BadInputError
from han_bullet.geometry import SolidBox
from han_bullet.sim.room_surfaces import Material, device_boxes, furniture_boxes, room_surfaces
from han_bullet.sim.surfaces import Surface, box_sides, joined, rectangle, stretched
from han_bullet.world_schema import TV, World

CASING = Material(None, (0.07, 0.07, 0.08))
SCREEN_TEXTURE = "screen_on"
SCREEN_BORDER = 0.03  # [m]
SCREEN_AHEAD = 0.004  # [m] before the casing, well above the renderer's depth resolution at 10 m
SCREEN_DARK = (0.05, 0.05, 0.06, 1.0)  # tints the picture almost to black
SCREEN_LIT = (1.0, 1.0, 1.0, 1.0)


class VisualRoom:
    """Floors, walls, furniture and devices as they look; nothing in here collides."""

    def __init__(self, client: int, world: World) -> None:
        self._client = client
        self._textures: dict[str, int] = {}
        for material, surface in room_surfaces(world).items():
            self._add(material, surface)
        for box, piece in zip(furniture_boxes(world), world.furniture, strict=True):
            if piece.urdf is not None:
                self._load_furniture(piece.urdf, box)
        pairs = zip(world.devices, device_boxes(world), strict=True)
        self._screens = {tv.name: self._add_tv(tv, box) for tv, box in pairs}

    def show_devices(self, devices_on: Iterable[tuple[str, bool]]) -> None:
        """Light or darken the screens."""
        for device, on in devices_on:
            colour = SCREEN_LIT if on else SCREEN_DARK
            pybullet.changeVisualShape(self._screens[device], -1, rgbaColor=colour, physicsClientId=self._client)

    def _add_tv(self, tv: TV, box: SolidBox) -> int:
        self._add(CASING, joined(box_sides(box, with_bottom=True)))
        return self._add(Material(SCREEN_TEXTURE, SCREEN_DARK[:3]), _screen(tv, box))

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

    def _load_furniture(self, urdf: str, box: SolidBox) -> None:
        bottom = box.centre_in_world[2] - 0.5 * box.size[2]
        pybullet.loadURDF(
            str(urdf_path(urdf)),
            [*box.centre_in_world[:2], bottom],
            yaw_quaternion(box.yaw),
            useFixedBase=True,
            physicsClientId=self._client,
        )


class CollisionRoom:
    """A ground plane and a box for each wall, piece of furniture and device.

    Attributes:
        bodies: Body id -> the box that it stands for.
    """

    def __init__(self, client: int, world: World) -> None:
        ground = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
        pybullet.createMultiBody(0.0, ground, physicsClientId=client)
        self.bodies = {_collision_box(client, box): box for box in world.solid_boxes()}


def _collision_box(client: int, box: SolidBox) -> int:
    half = (0.5 * box.size).tolist()
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client)
    body: int = pybullet.createMultiBody(
        0.0, shape, -1, box.centre_in_world.tolist(), yaw_quaternion(box.yaw), physicsClientId=client
    )
    return body


def _screen(tv: TV, box: SolidBox) -> Surface:
    width, depth, height = tv.size
    facing = np.array([math.cos(tv.facing), math.sin(tv.facing), 0.0])
    along = np.cross([0.0, 0.0, 1.0], facing) * (width - 2.0 * SCREEN_BORDER)
    up = np.array([0.0, 0.0, height - 2.0 * SCREEN_BORDER])
    centre = box.centre_in_world + (0.5 * depth + SCREEN_AHEAD) * facing
    return stretched(rectangle(centre - 0.5 * (along + up), along, up))


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
