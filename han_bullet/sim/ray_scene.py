"""What a level laser beam meets: the building's boxes and people's legs, cut exactly, ray by ray."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numba
import numpy as np

from han_bullet.geometry import Array, SolidBox
from han_bullet.sim.gait import BodyPose
from han_bullet.sim.legs import leg_bones
from han_bullet.sim.skeleton import skeleton_of
from han_bullet.wall_faces import with_doors
from han_bullet.world_schema import World


class RayScene:
    """The scene at one height.

    What the robot bumps into is a cylinder as wide as a person's shoulders and no pair of legs, so rays are not cast in
    the physics; these are exact and cost a tenth of the engine's, too. The robot is not in here: no beam meets it.
    """

    def __init__(self, world: World, height: float) -> None:
        """Keep what is at a height [m] above the floor."""
        self._height = height
        self._boxes = [box for box in with_doors(world.all_boxes(), world.floor) if _is_at(box, height)]
        self._rectangles = np.array([_rectangle(box) for box in self._boxes]).reshape(-1, 6)
        self._skeletons = [skeleton_of(person.build) for person in world.people]

    def take_away(self, name: str) -> None:
        """Let rays pass where a piece of furniture was."""
        self._boxes = [box for box in self._boxes if box.kind == "wall" or box.name != name]
        self._rectangles = np.array([_rectangle(box) for box in self._boxes]).reshape(-1, 6)

    def distances(self, origin: Array, angles: Array, people: Sequence[BodyPose]) -> Array:
        """Return how far the first surface is along each ray.

        Args:
            origin: Of all rays in the world, shape (2,) [m].
            angles: Their directions in the world, shape (n,) [rad].
            people: Everybody as they stand, walk or sit, in the order of the world.

        Returns:
            Shape (n,) [m]; inf where a ray meets nothing, 0 where it begins inside something.
        """
        bars = [
            (*bone.upper, *bone.lower, bone.radius)
            for skeleton, body_pose in zip(self._skeletons, people, strict=True)
            for bone in leg_bones(skeleton, body_pose)
            if min(bone.upper[2], bone.lower[2]) - bone.radius < self._height
            and self._height < max(bone.upper[2], bone.lower[2]) + bone.radius
        ]
        at = np.array([*origin, self._height])
        found: Array = _cast(at, angles, self._rectangles, np.array(bars).reshape(-1, 7))
        return found


def _is_at(box: SolidBox, height: float) -> bool:
    middle, half = float(box.centre_in_world[2]), 0.5 * float(box.size[2])
    return middle - half <= height <= middle + half


def _rectangle(box: SolidBox) -> tuple[float, ...]:
    """Return centre x and y, half length and half width [m], cosine and sine of the yaw."""
    return (*box.centre_in_world[:2], *(0.5 * box.size[:2]), math.cos(box.yaw), math.sin(box.yaw))


@numba.njit(cache=True)
def _cast(origin: Array, angles: Array, rectangles: Array, bars: Array) -> Array:
    """Return the distance to the first surface along level rays, shape (n,) [m].

    Args:
        origin: Shape (3,) [m].
        angles: Shape (n,) [rad].
        rectangles: As `_rectangle` has them, shape (m, 6).
        bars: Both ends and the radius of bars with round ends, shape (k, 7) [m].
    """
    nearest = np.full(len(angles), np.inf)
    for ray in range(len(angles)):
        along_x, along_y = math.cos(angles[ray]), math.sin(angles[ray])
        for row in range(len(rectangles)):
            nearest[ray] = min(nearest[ray], _to_rectangle(origin, along_x, along_y, rectangles[row]))
        for row in range(len(bars)):
            nearest[ray] = min(nearest[ray], _to_bar(origin, along_x, along_y, bars[row]))
    return nearest


@numba.njit(cache=True)
def _to_rectangle(origin: Array, along_x: float, along_y: float, rectangle: Array) -> float:
    """Return the distance to a rectangle: where the ray has entered both its strips (slab test)."""
    x, y, half_length, half_width, cos, sin = rectangle
    from_x, from_y = origin[0] - x, origin[1] - y
    enter, leave = 0.0, np.inf
    for start, step, half in (
        (cos * from_x + sin * from_y, cos * along_x + sin * along_y, half_length),
        (cos * from_y - sin * from_x, cos * along_y - sin * along_x, half_width),
    ):
        if abs(step) < 1e-12:
            if abs(start) > half:
                return np.inf
        else:
            enter = max(enter, (-math.copysign(half, step) - start) / step)
            leave = min(leave, (math.copysign(half, step) - start) / step)
    return enter if enter <= leave else np.inf


@numba.njit(cache=True)
def _to_bar(origin: Array, along_x: float, along_y: float, bar: Array) -> float:
    """Return the distance to a bar with round ends: the least of those to its side and to a ball at either end."""
    radius = bar[6]
    nearest = np.inf
    for end in range(2):
        x, y, z = origin[0] - bar[3 * end], origin[1] - bar[3 * end + 1], origin[2] - bar[3 * end + 2]
        near, far = _roots(1.0, along_x * x + along_y * y, x * x + y * y + z * z - radius * radius)
        if far >= 0.0:
            nearest = min(nearest, max(near, 0.0))
    # The side: points whose distance from the axis is the radius, between the ends.
    axis_x, axis_y, axis_z = bar[3] - bar[0], bar[4] - bar[1], bar[5] - bar[2]
    x, y, z = origin[0] - bar[0], origin[1] - bar[1], origin[2] - bar[2]
    length = axis_x * axis_x + axis_y * axis_y + axis_z * axis_z
    turn, start = axis_x * along_x + axis_y * along_y, axis_x * x + axis_y * y + axis_z * z
    near, far = _roots(
        length - turn * turn,
        length * (along_x * x + along_y * y) - start * turn,
        length * (x * x + y * y + z * z - radius * radius) - start * start,
    )
    near = max(near, 0.0)
    if far >= near and 0.0 <= start + near * turn <= length:
        nearest = min(nearest, near)
    return nearest


@numba.njit(cache=True)
def _roots(a: float, b: float, c: float) -> tuple[float, float]:
    """Return the roots of a t^2 + 2 b t + c, the smaller first; (inf, -inf) where there are none."""
    discriminant = b * b - a * c
    if discriminant < 0.0 or a < 1e-12:
        return np.inf, -np.inf
    root = math.sqrt(discriminant)
    return (-b - root) / a, (-b + root) / a
