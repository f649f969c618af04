"""Doors: the leaves stand back behind the faces that rooms show, and nowhere else."""

import numpy as np
import pytest

from han_bullet.geometry import SolidBox
from han_bullet.wall_faces import DOOR_WIDTH, SET_BACK, with_doors
from han_bullet.world_file import find_world, load_world
from han_bullet.world_schema import World


def real2() -> World:
    return load_world(find_world("real2"))


def is_solid(boxes: tuple[SolidBox, ...], x: float, y: float) -> bool:
    return any(bool(box.contains(np.array([x, y]))) for box in boxes)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_doors_of_the_corridor_stand_back_where_they_are_drawn(side: float) -> None:
    centres = (3.0, 8.0, 13.0)
    boxes = with_doors(real2().solid_boxes(), real2().floor)
    for x in map(float, np.arange(0.525, 15.8, 0.05)):
        in_door = any(abs(x - centre) < 0.5 * DOOR_WIDTH for centre in centres)
        assert is_solid(boxes, x, side * (1.5 + 0.5 * SET_BACK)) != in_door, x


def test_a_leaf_closes_its_opening_and_nothing_else_changes() -> None:
    world = real2()
    boxes = with_doors(world.solid_boxes(), world.floor)
    for x in np.arange(0.025, 15.9, 0.05):
        assert is_solid(boxes, float(x), 1.5 + SET_BACK + 0.01)
        assert is_solid(boxes, float(x), -1.5 - SET_BACK - 0.01)
    others = world.solid_boxes()[len(world.walls) :]
    assert [box.name for box in boxes[len(boxes) - len(others) :]] == [box.name for box in others]
    assert sum(box.size[0] for box in boxes if box.name == "wall0") == pytest.approx(world.solid_boxes()[0].size[0])
