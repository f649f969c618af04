import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.mirroring import mirrored
from han_bullet.variation import vary
from han_bullet.world_file import load_world, world_names
from han_bullet.world_schema import CeilingCamera, GoToTask, Walk, World

seeds = st.integers(0, 2**32 - 1)
names = st.sampled_from(world_names())


@given(names, seeds)
def test_mirroring_twice_is_the_identity(name: str, seed: int) -> None:
    world = vary(load_world(name), seed)
    assert mirrored(mirrored(world)) == world


@given(names, seeds)
def test_the_image_of_a_world_is_a_world_and_has_no_minus_zero(name: str, seed: int) -> None:
    image = mirrored(vary(load_world(name), seed))
    assert World.model_validate(image.model_dump()) == image
    assert not re.search(r"-0\.0[^0-9]", image.model_dump_json())


@given(names, seeds)
def test_every_body_stands_at_its_mirror_image(name: str, seed: int) -> None:
    world = vary(load_world(name), seed)
    image = mirrored(world)
    points = np.random.default_rng(seed).uniform([-1.0, -4.0], [24.0, 4.0], (500, 2))
    for box, other in zip(world.solid_boxes(), image.solid_boxes(), strict=True):
        assert (box.name, box.kind) == (other.name, other.kind)
        inside = [box.contains(point, margin=0.2) for point in points]
        assert inside == [other.contains(point, margin=0.2) for point in points * [1.0, -1.0]]
    for place, other_place in zip(_places(world), _places(image), strict=True):
        assert other_place == (place[0], -place[1])
    for yaw, other_yaw in zip(_yaws(world), _yaws(image), strict=True):
        assert math.sin(other_yaw) == -math.sin(yaw) and math.cos(other_yaw) == math.cos(yaw)


def _places(world: World) -> list[tuple[float, float]]:
    places = [*(person.start[:2] for person in world.people), world.robot.start[:2]]
    places += [point for p in world.people if isinstance(p.behaviour, Walk) for point in p.behaviour.waypoints]
    places += [area.seat for area in world.sitting_areas] + [device.position for device in world.devices]
    places.append(world.task.pose[:2] if isinstance(world.task, GoToTask) else world.task.place)
    for camera in world.cameras:
        if isinstance(camera, CeilingCamera):
            places += [camera.position[:2], camera.look_at[:2]]
    return [*places, world.light.direction[:2]]


def _yaws(world: World) -> list[float]:
    yaws = [*(person.start[2] for person in world.people), world.robot.start[2]]
    yaws += [piece.yaw for piece in world.furniture] + [device.facing for device in world.devices]
    return yaws + [area.facing for area in world.sitting_areas]


@pytest.mark.parametrize("name", world_names())
def test_the_floor_of_the_image_is_the_image_of_the_floor(name: str) -> None:
    world = load_world(name)
    for area, other in zip(world.floor, mirrored(world).floor, strict=True):
        assert (other.x, other.y) == (area.x, (-area.y[1], -area.y[0]))


def test_expectations_of_a_side_ask_for_the_other_one_and_no_others_change() -> None:
    world = load_world("real2")
    sides = {e.metric: e.equals for e in mirrored(world).expectations}
    assert sides["overtaking_side.walker"] == "right"
    assert sides["outcome"] == "arrived"
    bounds = [(e.metric, e.at_least, e.at_most) for e in world.expectations]
    assert [(e.metric, e.at_least, e.at_most) for e in mirrored(world).expectations] == bounds


def test_a_camera_sees_the_mirror_image_of_what_it_saw() -> None:
    world = load_world("sim2")
    camera, other = world.camera("camera4"), mirrored(world).camera("camera4")
    assert isinstance(camera, CeilingCamera) and isinstance(other, CeilingCamera)
    point = np.array([20.4, 1.1, 0.7, 1.0])
    in_camera = np.linalg.inv(camera.camera_in_world) @ point
    in_other = np.linalg.inv(other.camera_in_world) @ (point * [1.0, -1.0, 1.0, 1.0])
    assert in_other == pytest.approx(in_camera * [-1.0, 1.0, 1.0, 1.0])
    assert abs(in_camera[0]) > 0.1


def test_its_description_tells_the_other_side() -> None:
    assert "overtaken on the left (paper" in load_world("real2").description
    assert "overtaken on the right (paper" in mirrored(load_world("real2")).description
