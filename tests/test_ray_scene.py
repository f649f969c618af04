"""Rays against the scene: the same distances as the physics engine's own rays find among the same bodies."""

import math
from collections.abc import Iterator, Sequence

import numpy as np
import pybullet
import pytest

from han_bullet.geometry import Array, Pose2D
from han_bullet.messages import Posture
from han_bullet.sim.gait import BodyPose, Gait
from han_bullet.sim.legs import leg_bones
from han_bullet.sim.ray_scene import RayScene
from han_bullet.sim.room import CollisionRoom
from han_bullet.sim.skeleton import skeleton_of
from han_bullet.wall_faces import with_doors
from han_bullet.world_file import load_world
from han_bullet.world_schema import World

REACH = 30.0  # [m]
ALL_ROUND = np.linspace(-math.pi, math.pi, 720, endpoint=False)


@pytest.fixture
def client() -> Iterator[int]:
    number = pybullet.connect(pybullet.DIRECT)
    yield number
    pybullet.disconnect(physicsClientId=number)


def walkers(world: World, seed: int) -> list[BodyPose]:
    """Everybody somewhere in the living room, in the middle of a stride."""
    rng = np.random.default_rng(seed)
    bodies = []
    for person in world.people:
        x, y, yaw = rng.uniform((17.0, -3.0, -3.0), (22.5, 3.0, 3.0))
        gait = Gait(person.build)
        for step in range(10 + int(rng.integers(20))):
            pose = Pose2D(x + 0.05 * step * math.cos(yaw), y + 0.05 * step * math.sin(yaw), yaw)
            body = gait.advance(pose, 1.0, 0.05, Posture.WALKING)
        bodies.append(body)
    return bodies


def engine_distances(
    client: int, world: World, origin: Array, angles: Array, height: float, people: Sequence[BodyPose]
) -> Array:
    """Distances by PyBullet's rayTestBatch, among its own boxes and capsules, shape (n,) [m]."""
    CollisionRoom(client, with_doors(world.all_boxes(), world.floor))
    for person, body_pose in zip(world.people, people, strict=True):
        for bone in leg_bones(skeleton_of(person.build), body_pose):
            along = bone.upper - bone.lower
            length = float(np.linalg.norm(along))
            shape = pybullet.createCollisionShape(
                pybullet.GEOM_CAPSULE, radius=bone.radius, height=length, physicsClientId=client
            )
            axis = np.cross([0.0, 0.0, 1.0], along / length)
            angle = math.acos(along[2] / length)
            turn = pybullet.getQuaternionFromAxisAngle(axis.tolist(), angle)
            middle = (0.5 * (bone.upper + bone.lower)).tolist()
            pybullet.createMultiBody(0.0, shape, -1, middle, turn, physicsClientId=client)
    start = [*origin, height]
    ends = np.array(start) + REACH * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))])
    hits = pybullet.rayTestBatch([start] * len(ends), ends.tolist(), numThreads=1, physicsClientId=client)
    return np.array([REACH * hit[2] if hit[0] >= 0 else math.inf for hit in hits])


@pytest.mark.parametrize("height", [0.12, 0.25, 0.5])
@pytest.mark.parametrize("seed", range(4))
def test_rays_end_where_the_engines_own_do(client: int, seed: int, height: float) -> None:
    world = load_world("sim2")
    people = walkers(world, seed)
    origin = np.array([16.5, 2.0]) + np.random.default_rng(seed).uniform(-0.4, 0.4, 2)
    found = RayScene(world, height).distances(origin, ALL_ROUND, people)
    expected = engine_distances(client, world, origin, ALL_ROUND, height, people)
    assert np.array_equal(np.isfinite(found), np.isfinite(expected))
    apart = np.abs(found - expected)[np.isfinite(found)]
    assert np.quantile(apart, 0.9) < 1e-5
    # The engine nears a round body in steps and ends early where a ray but brushes it: as if it went a little aside.
    aside = [RayScene(world, height).distances(origin, ALL_ROUND + turn, people) for turn in (-2e-3, 0.0, 2e-3)]
    assert (expected >= np.min(aside, axis=0) - 2e-3).all()
    assert (expected <= np.max(aside, axis=0) + 2e-3).all()
    empty = RayScene(world.model_copy(update={"people": ()}), height).distances(origin, ALL_ROUND, [])
    assert np.count_nonzero(found < empty - 1e-6) >= 5, "hardly a ray meets a leg"


def test_a_ray_that_begins_inside_something_has_no_length() -> None:
    world = load_world("sim2").model_copy(update={"people": ()})
    on_couch, behind_it = np.array([19.5, -0.4]), np.array([19.5, 0.6])
    assert RayScene(world, 0.25).distances(on_couch, ALL_ROUND, []).max() == 0.0
    assert RayScene(world, 0.25).distances(behind_it, ALL_ROUND, []).min() > 0.1


def test_a_ray_along_a_wall_meets_what_is_at_its_end() -> None:
    world = load_world("real1").model_copy(update={"people": ()})
    scene = RayScene(world, 0.25)
    assert scene.distances(np.array([8.0, 1.4999]), np.array([math.pi]), [])[0] == pytest.approx(8.0)


def test_a_wall_stays_when_furniture_of_its_name_is_taken_away() -> None:
    world = load_world("box")
    crate = world.furniture[1].model_copy(update={"name": "wall0"})
    world = world.model_copy(update={"furniture": (*world.furniture[:1], crate, *world.furniture[2:])})
    scene, origin = RayScene(world, 0.25), np.array([3.0, 0.0])
    before = scene.distances(origin, np.array([0.0, -0.5 * math.pi]), [])
    scene.take_away("wall0")
    ahead, right = scene.distances(origin, np.array([0.0, -0.5 * math.pi]), [])
    assert right == before[1] and ahead > before[0] + 1.0
