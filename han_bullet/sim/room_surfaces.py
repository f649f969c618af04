"""What the building of a world looks like: floors, walls with skirting boards and doors, plain furniture, devices.

Only what someone inside can see is made: a wall's outer side costs time in every frame and shows in none.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from han_bullet.geometry import SolidBox
from han_bullet.sim.surfaces import Surface, box_sides, joined, rectangle, stretched, turned
from han_bullet.wall_faces import DOOR_FRAME, DOOR_HEIGHT, WallFace, upright_faces
from han_bullet.world_schema import TV, FloorArea, Furniture, Wall, World

OVERLAP = 0.02  # [m] that walls reach below the floor, so that no gap shows where they meet
SKIRTING_HEIGHT = 0.1  # [m]


@dataclass(frozen=True)
class Material:
    """How a surface looks.

    Attributes:
        texture: Name of a picture in urdf/textures; None is plain.
        colour: RGB in [0, 1]; multiplies the picture.
    """

    texture: str | None
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)


SKIRTING = Material(None, (0.55, 0.53, 0.5))
DOOR_FRAMES = Material(None, (0.8, 0.79, 0.76))
DOORS = Material("wood", (0.95, 0.95, 0.95))
CASING = Material(None, (0.07, 0.07, 0.08))
SCREEN_TEXTURE = "screen_on"
SCREEN_BORDER = 0.03  # [m]
SCREEN_AHEAD = 0.004  # [m] before the casing
SCREEN_DARK = (0.05, 0.05, 0.06)  # tints the picture almost to black
SCREEN_LIT = (1.0, 1.0, 1.0)


def room_surfaces(world: World) -> dict[Material, Surface]:
    """Return one mesh per material with all that never changes, but for furniture with a URDF or an end."""
    parts: dict[Material, list[Surface]] = defaultdict(list)
    for box, wall in zip(wall_boxes(world), world.walls, strict=True):
        for material, surface in _wall(box, wall, world.floor):
            parts[material].append(surface)
    for box, piece in zip(furniture_boxes(world), world.furniture, strict=True):
        if piece.urdf is None and piece.until is None:
            material, surface = plain_furniture(box, piece)
            parts[material].append(surface)
    for box in device_boxes(world):
        parts[CASING].extend(box_sides(box, with_bottom=True))
    for area in world.floor:
        parts[Material(area.texture)].append(_floor(area))
    return {material: joined(surfaces) for material, surfaces in parts.items()}


def wall_boxes(world: World) -> tuple[SolidBox, ...]:
    """Return the walls as boxes, in their order."""
    return world.all_boxes()[: len(world.walls)]


def furniture_boxes(world: World) -> tuple[SolidBox, ...]:
    """Return the furniture as boxes, in its order."""
    return world.all_boxes()[len(world.walls) :][: len(world.furniture)]


def device_boxes(world: World) -> tuple[SolidBox, ...]:
    """Return the devices as boxes, in their order."""
    return world.all_boxes()[len(world.walls) + len(world.furniture) :]


def screen(tv: TV, box: SolidBox) -> Surface:
    """Return the screen of a television that fills a box, with one picture over all of it."""
    width, depth, height = tv.size
    facing = np.array([math.cos(tv.facing), math.sin(tv.facing), 0.0])
    along = np.cross([0.0, 0.0, 1.0], facing) * (width - 2.0 * SCREEN_BORDER)
    up = np.array([0.0, 0.0, height - 2.0 * SCREEN_BORDER])
    centre = box.centre_in_world + (0.5 * depth + SCREEN_AHEAD) * facing
    return stretched(rectangle(centre - 0.5 * (along + up), along, up))


def plain_furniture(box: SolidBox, piece: Furniture) -> tuple[Material, Surface]:
    """Return how a piece of furniture without a URDF looks."""
    return Material(piece.texture), joined(box_sides(box, with_bottom=piece.bottom > 0.0))


def _floor(area: FloorArea) -> Surface:
    (x, x_end), (y, y_end) = area.x, area.y
    return rectangle(np.array([x, y, 0.0]), np.array([x_end - x, 0.0, 0.0]), np.array([0.0, y_end - y, 0.0]))


def _part(face: WallFace, s: float, s_end: float, bottom: float, top: float) -> Surface:
    start = np.array([*(face.corner + s * face.along), bottom])
    edge = np.array([*((s_end - s) * face.along), 0.0])
    return rectangle(start, edge, np.array([0.0, 0.0, top - bottom]), (s, max(bottom, 0.0)))


def _wall(box: SolidBox, wall: Wall, floor: Sequence[FloorArea]) -> Iterator[tuple[Material, Surface]]:
    for face in upright_faces(box):
        for s, s_end in face.visible_stretches(floor):
            yield from _panelled(face, s, s_end, Material(wall.texture))


def _panelled(face: WallFace, s: float, s_end: float, plaster: Material) -> Iterator[tuple[Material, Surface]]:
    """Cover a stretch of wall with plaster above a skirting board, with doors where it is long enough for them."""
    top = face.height
    for left, right in face.doors_in((s, s_end)):
        lintel = DOOR_HEIGHT + DOOR_FRAME
        yield from _bare(face, s, left - DOOR_FRAME, plaster)
        yield DOOR_FRAMES, _part(face, left - DOOR_FRAME, left, -OVERLAP, lintel)
        yield DOORS, turned(_part(face, left, right, -OVERLAP, DOOR_HEIGHT))
        yield DOOR_FRAMES, _part(face, left, right, DOOR_HEIGHT, lintel)
        yield DOOR_FRAMES, _part(face, right, right + DOOR_FRAME, -OVERLAP, lintel)
        yield plaster, _part(face, left - DOOR_FRAME, right + DOOR_FRAME, lintel, top)
        s = right + DOOR_FRAME
    yield from _bare(face, s, s_end, plaster)


def _bare(face: WallFace, s: float, s_end: float, plaster: Material) -> Iterator[tuple[Material, Surface]]:
    skirting = min(SKIRTING_HEIGHT, face.height)
    yield SKIRTING, _part(face, s, s_end, -OVERLAP, skirting)
    yield plaster, _part(face, s, s_end, skirting, face.height)
