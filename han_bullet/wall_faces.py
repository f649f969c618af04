"""The faces of walls that a room shows, and the doors in them.

Every long face has doors. Their leaves stand back a little behind the face: for people, robot and pictures that is
nothing, but to a laser it tells where along a corridor it is, which bare walls do not.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from han_bullet.geometry import Array, SolidBox, rotation
from han_bullet.world_schema import FloorArea

IN_FRONT = 0.06  # [m] before a wall face: where floor must lie for the face to be seen
DOOR_SPACING = 5.0  # [m] along a wall; what one meets in an office corridor
DOOR_WIDTH, DOOR_HEIGHT, DOOR_FRAME = 0.9, 2.05, 0.06  # [m]
SET_BACK = (
    0.05  # [m] of a door's leaf behind the face; at most half of a wall, a third where there is one on either side
)

Stretch = tuple[float, float]


@dataclass(frozen=True)
class WallFace:
    """An upright wall face: its lower corner (2,), its direction (2,) with the room on the right, its size [m]."""

    corner: Array
    along: Array
    length: float
    height: float

    def visible_stretches(self, floor: Sequence[FloorArea]) -> list[Stretch]:
        """Return from, to [m] of the stretches, in steps of about a metre, with floor before them."""
        edges = np.linspace(0.0, self.length, max(1, math.ceil(self.length - 1e-6)) + 1)
        normal = rotation(-0.5 * math.pi) @ self.along
        stretches: list[Stretch] = []
        for s, s_end in itertools.pairwise(edges.tolist()):
            samples = np.linspace(s + 0.02, s_end - 0.02, 5)
            before = self.corner + samples[:, None] * self.along + IN_FRONT * normal
            if not any(area.contains(before).any() for area in floor):
                continue
            if stretches and stretches[-1][1] == s:
                s = stretches.pop()[0]
            stretches.append((s, s_end))
        return stretches

    def doors_in(self, stretch: Stretch) -> list[Stretch]:
        """Return from, to [m] of the doors in a visible stretch, in its middle, so that a mirror image has its own."""
        length = stretch[1] - stretch[0]
        count = math.ceil((length - DOOR_WIDTH - 0.5 * DOOR_SPACING) / DOOR_SPACING)
        if count < 1 or self.height <= DOOR_HEIGHT + DOOR_FRAME:
            return []
        first = stretch[0] + 0.5 * (length - (count - 1) * DOOR_SPACING - DOOR_WIDTH)
        return [(first + k * DOOR_SPACING, first + k * DOOR_SPACING + DOOR_WIDTH) for k in range(count)]


def upright_faces(box: SolidBox) -> Iterator[WallFace]:
    """Yield the four upright faces of a wall: its two long ones, then its ends."""
    length, thickness, height = box.size
    for turn, width, depth in ((0.0, length, thickness), (0.5, thickness, length)):
        for side in (0.0, 1.0):
            along = rotation(box.yaw + (turn + side) * math.pi)[:, 0]
            outward = rotation(-0.5 * math.pi) @ along
            yield WallFace(box.centre_in_world[:2] - 0.5 * width * along + 0.5 * depth * outward, along, width, height)


def with_doors(boxes: Sequence[SolidBox], floor: Sequence[FloorArea]) -> tuple[SolidBox, ...]:
    """Return boxes of a building with the leaves of its walls' doors set back, as a level laser beam meets them."""
    return tuple(piece for box in boxes for piece in (_pieces(box, floor) if box.kind == "wall" else (box,)))


def _pieces(wall: SolidBox, floor: Sequence[FloorArea]) -> Iterator[SolidBox]:
    """Cut a wall along its length at its doors; between the jambs it is thinner on the door's side."""
    length, thickness, _ = wall.size
    right, left, *_ = upright_faces(wall)  # the left one runs against the wall's own x axis
    doors_right = _doors(right, floor)
    doors_left = [(length - end, length - start) for start, end in _doors(left, floor)]
    cuts = sorted({0.0, float(length), *(end for door in doors_right + doors_left for end in door)})
    for start, end in itertools.pairwise(cuts):
        middle = 0.5 * (start + end)
        in_right, in_left = _within(middle, doors_right), _within(middle, doors_left)
        set_back = min(SET_BACK, thickness / (1 + in_right + in_left))
        right_back, left_back = set_back * in_right, set_back * in_left
        offset = rotation(wall.yaw) @ np.array([middle - 0.5 * length, 0.5 * (right_back - left_back)])
        centre = wall.centre_in_world + np.array([*offset, 0.0])
        size = np.array([end - start, thickness - right_back - left_back, wall.size[2]])
        yield replace(wall, centre_in_world=centre, size=size)


def _doors(face: WallFace, floor: Sequence[FloorArea]) -> list[Stretch]:
    return [door for stretch in face.visible_stretches(floor) for door in face.doors_in(stretch)]


def _within(place: float, doors: Sequence[Stretch]) -> bool:
    return any(start < place < end for start, end in doors)
