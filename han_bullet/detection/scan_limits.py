"""Where people of which height may stand in an image, so that a detector looks for no others.

A calibrated camera over a flat floor knows how many pixels high a person is whose feet are in a given row of its image.
Windows of other heights hold nobody, and most levels of the pyramid need not be made.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from han_bullet.detection.search_area import SearchArea, Windows
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Intrinsics, floor_homography, project

SHORTEST, TALLEST = 1.4, 2.1  # [m] of people with their shoes and hats
SHORTEST_SEATED = 1.2  # [m] from the floor to the crown: 0.4 of a low seat and 0.8 of a short adult
BOX_TOLERANCE = 0.15  # share of its height by which a good box may be off: half a scale, and where its lower edge lies
BELOW_IMAGE = 0.25  # share of the image's height below it where feet may still be: boxes reach beyond the border
COLUMNS_TRIED = 9  # across the image: under a tilted camera, heights also vary along a row


@dataclass(frozen=True)
class ScanLimits(SearchArea):
    """How high a person may be in an image, by the row where the feet are.

    Attributes:
        least, greatest: Heights [px] of people whose feet are in row 0, 1, .. of the image, shape (rows,). Where nobody
            can stand the least is above the greatest. Feet above the first or below the last row count as in these.
    """

    least: Array
    greatest: Array

    def __post_init__(self) -> None:
        """Check shapes and values."""
        if self.least.ndim != 1 or self.least.shape != self.greatest.shape or not self.least.size:
            raise BadInputError(
                f"scan limits of shapes {self.least.shape} and {self.greatest.shape}; twice the same (rows,) is right"
            )
        if np.isnan(self.least).any() or np.isnan(self.greatest).any():
            raise BadInputError("scan limits hold values that are no numbers; heights [px] would be right")

    def windows(self, x: Array, y: Array, width: float, height: float) -> Windows:
        """Tell which boxes of one size may hold a person; see `SearchArea`."""
        allowed: Windows = _allowed_windows(self.least, self.greatest, x.size, y, height)
        return allowed


@numba.njit(cache=True)
def _allowed_windows(least: Array, greatest: Array, columns: int, y: Array, height: float) -> Windows:
    """Do for a grid of boxes, by their upper edges and one height [px], what `ScanLimits` says."""
    allowed = np.empty((y.size, columns), np.bool_)
    for row in range(y.size):
        feet = int(min(max(y[row] + height, 0.0), least.size - 1))
        allowed[row] = least[feet] <= height <= greatest[feet]
    return allowed


def limits_on_floor(
    intrinsics: Intrinsics, camera_in_world: Array, shortest: float = SHORTEST, tallest: float = TALLEST
) -> ScanLimits:
    """Return the limits for people who stand, walk or sit, their feet on the floor, z = 0, under a camera.

    Args:
        intrinsics: The camera.
        camera_in_world: Its pose, shape (4, 4).
        shortest: Height of the shortest person to be found [m]; SHORTEST_SEATED where people may sit.
        tallest: Height of the tallest [m].

    Raises:
        BadInputError: The heights are not positive and in this order.
    """
    if not 0.0 < shortest <= tallest < np.inf:
        raise BadInputError(f"people of {shortest} to {tallest} m; two positive heights, the shorter first, are right")
    rows = np.arange(round((1.0 + BELOW_IMAGE) * intrinsics.height)) + 0.5
    columns = np.linspace(0.0, intrinsics.width, COLUMNS_TRIED)
    u, v = np.meshgrid(columns, rows)
    floor = np.stack([u, v, np.ones_like(u)], axis=-1) @ floor_homography(intrinsics, camera_in_world).T
    stands = floor[..., 2] > 0.0  # below the horizon
    feet = floor[..., :2] / np.where(stands, floor[..., 2], 1.0)[..., np.newaxis]
    heights = [_height_in_image(feet, v, size, intrinsics, camera_in_world) for size in (shortest, tallest)]
    least = np.where(stands, heights[0], np.inf).min(axis=1)
    greatest = np.where(stands, heights[1], -np.inf).max(axis=1)
    return ScanLimits((1.0 - BOX_TOLERANCE) * least, (1.0 + BOX_TOLERANCE) * greatest)


def _height_in_image(feet: Array, rows: Array, size: float, intrinsics: Intrinsics, camera_in_world: Array) -> Array:
    """Return how far above their feet people of a size [m] reach [px]; inf where their heads are not in front."""
    heads = np.concatenate([feet, np.full((*feet.shape[:2], 1), size)], axis=-1)
    pixels, depths = project(heads, intrinsics, camera_in_world)
    return np.where(depths > 0.0, rows - pixels[..., 1], np.inf)
