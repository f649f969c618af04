"""What a laser beam meets: the building's boxes and people's legs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pybullet

from han_bullet.geometry import Array
from han_bullet.sim.gait import BodyPose
from han_bullet.sim.legs import LegBone, leg_bones
from han_bullet.sim.room import CollisionRoom
from han_bullet.sim.skeleton import skeleton_of
from han_bullet.world_schema import World

RAYS_PER_CALL = pybullet.MAX_RAY_INTERSECTION_BATCH_SIZE - 1  # PyBullet refuses more at once


class RayScene:
    """The scene for rays, in a physics client of its own that is never stepped.

    What the robot bumps into is a cylinder as wide as a person's shoulders, no pair of legs, and stays so: neither
    client knows of the other. The robot is not in here, so no beam meets it.
    """

    def __init__(self, world: World) -> None:
        """Load the building, and legs for everybody, at places that `place_legs` gives."""
        self._client: int = pybullet.connect(pybullet.DIRECT)
        CollisionRoom(self._client, world)
        self._skeletons = [skeleton_of(person.build) for person in world.people]
        self._bars: list[int] | None = None

    def place_legs(self, people: Sequence[BodyPose]) -> None:
        """Put everybody's legs where they are now; people in the order of the world."""
        pairs = zip(self._skeletons, people, strict=True)
        bones = [bone for skeleton, body_pose in pairs for bone in leg_bones(skeleton, body_pose)]
        if self._bars is None:
            self._bars = [self._add_bar(bone) for bone in bones]
        for bar, bone in zip(self._bars, bones, strict=True):
            middle = 0.5 * (bone.upper + bone.lower)
            pybullet.resetBasePositionAndOrientation(
                bar, middle.tolist(), _upright_to(bone.upper - bone.lower), physicsClientId=self._client
            )

    def distances(self, origin: Array, ends: Array) -> Array:
        """Return how far along each ray the first surface is.

        Args:
            origin: Of all rays, shape (3,) [m].
            ends: Of each, shape (n, 3) [m].

        Returns:
            Shape (n,) [m]; inf where a ray meets nothing before its end.
        """
        fractions: list[float] = []
        for first in range(0, len(ends), RAYS_PER_CALL):
            some = ends[first : first + RAYS_PER_CALL]
            starts = [origin.tolist()] * len(some)
            hits = pybullet.rayTestBatch(starts, some.tolist(), numThreads=1, physicsClientId=self._client)
            fractions += [hit[2] if hit[0] >= 0 else math.inf for hit in hits]
        reach: Array = np.linalg.norm(ends - origin, axis=1)
        return np.array(fractions) * reach

    def close(self) -> None:
        """Close the client."""
        pybullet.disconnect(physicsClientId=self._client)

    def _add_bar(self, bone: LegBone) -> int:
        length = float(np.linalg.norm(bone.upper - bone.lower))
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_CAPSULE, radius=bone.radius, height=length, physicsClientId=self._client
        )
        body: int = pybullet.createMultiBody(0.0, shape, physicsClientId=self._client)
        return body


def _upright_to(direction: Array) -> list[float]:
    """Return the quaternion (x, y, z, w) of the shortest turn from the vertical to a direction, shape (3,)."""
    x, y, z = direction / np.linalg.norm(direction)
    if z < -1.0 + 1e-9:
        return [1.0, 0.0, 0.0, 0.0]
    w = math.sqrt(0.5 * (1.0 + z))
    return [-0.5 * y / w, 0.5 * x / w, 0.0, w]
