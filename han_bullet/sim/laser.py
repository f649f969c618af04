"""A planar laser scanner on the robot."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from han_bullet.geometry import Array, Pose2D
from han_bullet.messages import LaserScan
from han_bullet.sim.gait import BodyPose
from han_bullet.sim.ray_scene import RayScene
from han_bullet.world_schema import Laser, World

RANGE_MIN = 0.05  # [m]


class LaserScanner:
    """Measure ranges in a plane: exact up to Gaussian noise, all rays at once.

    The robot does not tilt, so the plane is level; the robot's own shell is taken to have a slit there.
    """

    def __init__(self, world: World, settings: Laser, rng: np.random.Generator) -> None:
        """Load what rays can meet.

        Args:
            world: Building and people.
            settings: Mount, rays and noise.
            rng: For the noise.
        """
        self._settings = settings
        self._rng = rng
        self._scene = RayScene(world, settings.height)
        self._increment = math.radians(settings.resolution)
        self._angle_min = -0.5 * math.radians(settings.field_of_view)
        self._angles: Array = self._angle_min + self._increment * np.arange(settings.ray_count, dtype=float)
        self._scanner_in_body = Pose2D(settings.forward, 0.0, 0.0)

    def take_away(self, name: str) -> None:
        """Let beams pass where a piece of furniture was."""
        self._scene.take_away(name)

    def scan(self, time: float, pose_robot_in_world: Pose2D, people: Sequence[BodyPose]) -> LaserScan:
        """Sweep once.

        Args:
            time: [s].
            pose_robot_in_world: Where the robot truly is.
            people: Everybody as they stand, walk or sit, in the order of the world.
        """
        settings = self._settings
        origin = pose_robot_in_world.to_world(self._scanner_in_body.position)
        ranges = self._scene.distances(origin, self._angles + pose_robot_in_world.yaw, people)
        ranges = np.maximum(ranges + self._rng.normal(0.0, settings.noise, len(ranges)), RANGE_MIN)
        ranges[ranges > settings.range_max] = np.inf
        return LaserScan(
            time,
            ranges,
            self._angle_min,
            self._increment,
            RANGE_MIN,
            settings.range_max,
            self._scanner_in_body,
        )
