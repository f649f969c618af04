"""What the building of a world looks like: floors, walls with skirting boards and doors, plain furniture, devices.

Only what someone inside can see is made: a wall's outer side costs time in every frame and shows in none.
"""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from han_bullet.geometry import Array, SolidBox, rotation
from han_bullet.sim.surfaces import Surface, box_sides, joined, rectangle, stretched, turned
from han_bullet.world_schema import TV, FloorArea, Furniture, Wall, World

OVERLAP = 0.02  # [m] that walls reach below the floor, so that no gap shows where they meet
IN_FRONT = 0.06  # [m] before a wall face: where floor must lie for the face to be seen
SKIRTING_HEIGHT = 0.1  # [m]
DOOR_SPACING = 5.0  # [m] along a wall; what one meets in an office corridor
DOOR_WIDTH, DOOR_HEIGHT, DOOR_FRAME = 0.9, 2.05, 0.06  # [m]


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


@dataclass(frozen=True)
class _Face:
    """An upright wall face: its lower corner (2,), its direction (2,) with the room on the right, its size [m]."""

    corner: Array
    along: Array
    length: float
    height: float

    def part(self, s: float, s_end: float, bottom: float, top: float) -> Surface:
        start = np.array([*(self.corner + s * self.along), bottom])
        edge = np.array([*((s_end - s) * self.along), 0.0])
        return rectangle(start, edge, np.array([0.0, 0.0, top - bottom]), (s, max(bottom, 0.0)))

    def visible_stretches(self, floor: Sequence[FloorArea]) -> list[tuple[float, float]]:
        """Return from, to [m] of the stretches, in steps of about a metre, with floor before them."""
        edges = np.linspace(0.0, self.length, max(1, math.ceil(self.length - 1e-6)) + 1)
        normal = rotation(-0.5 * math.pi) @ self.along
        stretches: list[tuple[float, float]] = []
        for s, s_end in itertools.pairwise(edges.tolist()):
            samples = np.linspace(s + 0.02, s_end - 0.02, 5)
            before = self.corner + samples[:, None] * self.along + IN_FRONT * normal
            if not any(_on_floor(point, floor) for point in before):
                continue
            if stretches and stretches[-1][1] == s:
                s = stretches.pop()[0]
            stretches.append((s, s_end))
        return stretches


def _on_floor(point: Array, floor: Sequence[FloorArea]) -> bool:
    return any(area.x[0] <= point[0] <= area.x[1] and area.y[0] <= point[1] <= area.y[1] for area in floor)


def _wall(box: SolidBox, wall: Wall, floor: Sequence[FloorArea]) -> Iterator[tuple[Material, Surface]]:
    for face in _upright_faces(box):
        for s, s_end in face.visible_stretches(floor):
            yield from _panelled(face, s, s_end, Material(wall.texture))


def _upright_faces(box: SolidBox) -> Iterator[_Face]:
    length, thickness, height = box.size
    for turn, width, depth in ((0.0, length, thickness), (0.5, thickness, length)):
        for side in (0.0, 1.0):
            along = rotation(box.yaw + (turn + side) * math.pi)[:, 0]
            outward = rotation(-0.5 * math.pi) @ along
            yield _Face(box.centre_in_world[:2] - 0.5 * width * along + 0.5 * depth * outward, along, width, height)


def _panelled(face: _Face, s: float, s_end: float, plaster: Material) -> Iterator[tuple[Material, Surface]]:
    """Cover a stretch of wall with plaster above a skirting board, with doors where it is long enough for them."""
    top = face.height
    for centre in _door_centres(s, s_end) if face.height > DOOR_HEIGHT + DOOR_FRAME else []:
        left, right = centre - 0.5 * DOOR_WIDTH, centre + 0.5 * DOOR_WIDTH
        lintel = DOOR_HEIGHT + DOOR_FRAME
        yield from _bare(face, s, left - DOOR_FRAME, plaster)
        yield DOOR_FRAMES, face.part(left - DOOR_FRAME, left, -OVERLAP, lintel)
        yield DOORS, turned(face.part(left, right, -OVERLAP, DOOR_HEIGHT))
        yield DOOR_FRAMES, face.part(left, right, DOOR_HEIGHT, lintel)
        yield DOOR_FRAMES, face.part(right, right + DOOR_FRAME, -OVERLAP, lintel)
        yield plaster, face.part(left - DOOR_FRAME, right + DOOR_FRAME, lintel, top)
        s = right + DOOR_FRAME
    yield from _bare(face, s, s_end, plaster)


def _bare(face: _Face, s: float, s_end: float, plaster: Material) -> Iterator[tuple[Material, Surface]]:
    skirting = min(SKIRTING_HEIGHT, face.height)
    yield SKIRTING, face.part(s, s_end, -OVERLAP, skirting)
    yield plaster, face.part(s, s_end, skirting, face.height)


def _door_centres(s: float, s_end: float) -> list[float]:
    return list(np.arange(s + 0.5 * DOOR_SPACING, s_end - DOOR_WIDTH, DOOR_SPACING))
