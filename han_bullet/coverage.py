"""Where on the floor each camera of a world has a whole standing person in view."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from han_bullet.assembly import field_of_view
from han_bullet.costmap.grid import INSCRIBED
from han_bullet.geometry import Array, Pose2D
from han_bullet.messages import CameraImage, Frame
from han_bullet.static_map import static_costmap
from han_bullet.world_schema import Camera, World

COVERAGE_RESOLUTION = 0.25  # [m]


@dataclass(frozen=True)
class Coverage:
    """Where one camera has a whole standing person in view.

    Attributes:
        camera: Name.
        area: Of the floor where it has [m^2].
        share: Of the whole free floor, in [0, 1].
        x, y: Extent of that area in the world [m]; None where there is none.
    """

    camera: str
    area: float
    share: float
    x: tuple[float, float] | None
    y: tuple[float, float] | None


def coverages(world: World) -> list[Coverage]:
    """Return the coverage of every camera; of the onboard camera as seen from the robot's start."""
    costmap = static_costmap(world)
    points = _floor_points(world)
    free = points[costmap.cost_at(points) < INSCRIBED]
    view = field_of_view(world)
    start = world.robot.start_pose_in_world
    return [_coverage(camera.name, free, view.sees(empty_frame(camera, start), free)) for camera in world.cameras]


def _coverage(name: str, points: Array, seen: NDArray[np.bool_]) -> Coverage:
    area = float(seen.sum()) * COVERAGE_RESOLUTION**2
    if not seen.any():
        return Coverage(name, 0.0, 0.0, None, None)
    (x0, y0), (x1, y1) = points[seen].min(axis=0), points[seen].max(axis=0)
    return Coverage(name, area, float(seen.mean()), (float(x0), float(x1)), (float(y0), float(y1)))


def _floor_points(world: World) -> Array:
    """Return a regular grid of points over all floor areas, shape (n, 2) [m]."""
    pieces = []
    for area in world.floor:
        x = np.arange(area.x[0] + 0.5 * COVERAGE_RESOLUTION, area.x[1], COVERAGE_RESOLUTION)
        y = np.arange(area.y[0] + 0.5 * COVERAGE_RESOLUTION, area.y[1], COVERAGE_RESOLUTION)
        pieces.append(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2))
    return np.concatenate(pieces)


def empty_frame(camera: Camera, pose_robot_in_world: Pose2D, time: float = 0.0) -> Frame:
    """Return a frame without pixels, for what its camera can see from some pose of the robot."""
    return empty_image(camera, time).placed(pose_robot_in_world)


def empty_image(camera: Camera, time: float = 0.0) -> CameraImage:
    """Return an image without pixels."""
    pixels = np.zeros((0, 0, 3), np.uint8)
    return CameraImage(camera.name, time, pixels, camera.intrinsics, camera.mount, camera.fixed)
