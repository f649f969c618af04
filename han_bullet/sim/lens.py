"""From pinhole cameras to the software renderer's matrices, and the part of an image that a body can touch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from han_bullet.geometry import Array, Intrinsics, project

NEAR, FAR = 0.1, 25.0  # [m]; the longest view down the worlds' corridors is 23 m; depth is then right to 0.1 mm at 10 m
# The renderer samples pixel (row v, column u) along the ray through (u + 0, v + 1) of the image's edge coordinates
# (measured), where a pixel's centre is (u + 0.5, v + 0.5): the principal point is moved by the difference.
SAMPLE_OFFSET = (-0.5, 0.5)  # [px]
CROP_MARGIN = 2  # [px]


@dataclass(frozen=True)
class Crop:
    """A part of an image: columns left <= u < right, rows top <= v < bottom [px]."""

    left: int
    top: int
    right: int
    bottom: int

    @property
    def width(self) -> int:
        """Return the number of columns [px]."""
        return self.right - self.left

    @property
    def height(self) -> int:
        """Return the number of rows [px]."""
        return self.bottom - self.top

    @property
    def window(self) -> tuple[slice, slice]:
        """Return the index that cuts this part out of an image."""
        return slice(self.top, self.bottom), slice(self.left, self.right)


def whole(intrinsics: Intrinsics) -> Crop:
    """Return the crop that is the whole image."""
    return Crop(0, 0, intrinsics.width, intrinsics.height)


def projection_matrix(intrinsics: Intrinsics, crop: Crop) -> list[float]:
    """Return the OpenGL projection of one part of an image, 16 numbers, column by column."""
    cx = intrinsics.cx + SAMPLE_OFFSET[0] - crop.left
    cy = intrinsics.cy + SAMPLE_OFFSET[1] - crop.top
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[0, 2] = 2.0 * intrinsics.fx / crop.width, 1.0 - 2.0 * cx / crop.width
    matrix[1, 1], matrix[1, 2] = 2.0 * intrinsics.fy / crop.height, 2.0 * cy / crop.height - 1.0
    matrix[2, 2], matrix[2, 3] = -(FAR + NEAR) / (FAR - NEAR), -2.0 * FAR * NEAR / (FAR - NEAR)
    matrix[3, 2] = -1.0
    return list(map(float, matrix.T.ravel()))


def view_matrix(camera_in_world: Array) -> list[float]:
    """Return the OpenGL view (x right, y up, z backward) of a camera's pose (4, 4), 16 numbers, column by column."""
    flipped = camera_in_world @ np.diag([1.0, -1.0, -1.0, 1.0])
    return list(map(float, np.linalg.inv(flipped).T.ravel()))


def depth_in_buffer(depth: float) -> float:
    """Return the depth buffer's value at a distance along the view [m]."""
    return (FAR - FAR * NEAR / depth) / (FAR - NEAR)


def visible_part(points_in_world: Array, intrinsics: Intrinsics, camera_in_world: Array) -> tuple[Crop, float] | None:
    """Find the part of an image that a body can touch.

    Args:
        points_in_world: Points whose hull holds the body, shape (n, 3) [m].
        intrinsics: Of the camera.
        camera_in_world: Its pose, shape (4, 4).

    Returns:
        The part and the nearest depth [m], or None where the body is out of view. A body that reaches behind the camera
        has no image outline: the part is then the whole image.
    """
    pixels, depths = project(points_in_world, intrinsics, camera_in_world)
    if depths.max() <= NEAR or depths.min() >= FAR:
        return None
    if depths.min() <= NEAR:
        return whole(intrinsics), NEAR
    limits = (intrinsics.width, intrinsics.height)
    left, top = np.clip(np.floor(pixels.min(axis=0)) - CROP_MARGIN, 0, limits).astype(int)
    right, bottom = np.clip(np.ceil(pixels.max(axis=0)) + CROP_MARGIN, 0, limits).astype(int)
    if left >= right or top >= bottom:
        return None
    return Crop(int(left), int(top), int(right), int(bottom)), float(depths.min())
