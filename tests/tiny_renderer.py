"""Pictures by PyBullet's own software renderer, to compare ours with."""

import numpy as np
import pybullet

from han_bullet.geometry import Array, Intrinsics
from han_bullet.sim.raster import Raster, View
from han_bullet.sim.rasterizer import NEAR
from han_bullet.world_schema import Light

FAR = 25.0  # [m]; the longest view down the worlds' corridors is 23 m
EMPTY = 1.0 - 2.0**-23  # depth of a pixel in which nothing was drawn: the renderer gives a last bit less than 1
# It samples pixel (row v, column u) along the ray through (u + 0, v + 1) of the image's edge coordinates (measured),
# where a pixel's centre is (u + 0.5, v + 0.5): the principal point is moved by the difference.
SAMPLE_OFFSET = (-0.5, 0.5)  # [px]


def tiny_picture(client: int, view: View, light: Light) -> Raster:
    """Draw what a client holds. The software renderer drops a polygon that is much larger than its distance."""
    _, _, rgba, depth, _ = pybullet.getCameraImage(
        view.intrinsics.width,
        view.intrinsics.height,
        _view_matrix(view.camera_in_world),
        _projection_matrix(view.intrinsics),
        lightDirection=light.direction,
        lightColor=light.colour,
        lightAmbientCoeff=light.ambient,
        lightDiffuseCoeff=light.diffuse,
        lightSpecularCoeff=0.0,
        shadow=0,
        flags=pybullet.ER_NO_SEGMENTATION_MASK,
        renderer=pybullet.ER_TINY_RENDERER,
        physicsClientId=client,
    )
    inverse = np.where(depth < EMPTY, (FAR - (FAR - NEAR) * depth.astype(float)) / (FAR * NEAR), 0.0)
    return Raster(np.ascontiguousarray(rgba[..., :3]), inverse.astype(np.float32))


def _projection_matrix(intrinsics: Intrinsics) -> list[float]:
    """Return the OpenGL projection, 16 numbers, column by column."""
    width, height = intrinsics.width, intrinsics.height
    cx, cy = intrinsics.cx + SAMPLE_OFFSET[0], intrinsics.cy + SAMPLE_OFFSET[1]
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[0, 2] = 2.0 * intrinsics.fx / width, 1.0 - 2.0 * cx / width
    matrix[1, 1], matrix[1, 2] = 2.0 * intrinsics.fy / height, 2.0 * cy / height - 1.0
    matrix[2, 2], matrix[2, 3] = -(FAR + NEAR) / (FAR - NEAR), -2.0 * FAR * NEAR / (FAR - NEAR)
    matrix[3, 2] = -1.0
    return list(map(float, matrix.T.ravel()))


def _view_matrix(camera_in_world: Array) -> list[float]:
    """Return the OpenGL view (x right, y up, z backward), 16 numbers, column by column."""
    flipped = camera_in_world @ np.diag([1.0, -1.0, -1.0, 1.0])
    return list(map(float, np.linalg.inv(flipped).T.ravel()))
