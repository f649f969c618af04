"""Points of the floor as a known camera shows them, for tests of its calibration."""

import math

import numpy as np

from han_bullet.calibration.points import MarkedPoints
from han_bullet.geometry import Array, Intrinsics, floor_homography, look_at
from han_bullet.world_file import load_world
from han_bullet.world_schema import CeilingCamera

CAMERAS = [camera for camera in load_world("real2").cameras if isinstance(camera, CeilingCamera)]
FARTHEST = 12.0  # [m] from below the camera


def floor_points(
    intrinsics: Intrinsics, camera_in_world: Array, count: int, rng: np.random.Generator, noise: float = 0.0
) -> MarkedPoints:
    """Points of random pixels on the floor, marked with an error of a deviation [px] per coordinate."""
    homography = floor_homography(intrinsics, camera_in_world)
    rows: list[list[float]] = []
    while len(rows) < count:
        pixel = rng.uniform((0.0, 0.0), (intrinsics.width, intrinsics.height))
        x, y, scale = homography @ [*pixel, 1.0]
        marked = pixel + noise * rng.normal(size=2)
        inside = np.all((marked >= 0.0) & (marked <= (intrinsics.width, intrinsics.height)))
        if scale > 0.0 and inside:
            x, y = x / scale, y / scale
            if math.hypot(x - camera_in_world[0, 3], y - camera_in_world[1, 3]) < FARTHEST:
                rows.append([*marked, x, y, 0.0])
    return MarkedPoints.of_rows(rows)


def tilted_camera(height: float, down: float, roll: float = 0.0) -> Array:
    """The pose of a camera over the origin that looks along x, by an angle down and turned clockwise [rad]."""
    pose = look_at(np.array([0.0, 0.0, height]), np.array([1.0, 0.0, height - math.tan(down)]))
    turn = np.eye(4)
    turn[:2, :2] = [[math.cos(roll), -math.sin(roll)], [math.sin(roll), math.cos(roll)]]
    return pose @ turn
