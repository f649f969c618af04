"""Smooth shapes on pictures: OpenCV's anti-aliased drawing at fractions of a pixel, so that moving bodies do not jump.

Places are columns and rows [px], shape (..., 2); pictures are RGB, shape (height, width, 3), uint8, and are changed.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array
from han_bullet.lettering import Colour, Picture

SHIFT = 4  # fractional bits of OpenCV's coordinates
FILLED = -1  # OpenCV's thickness for it
RIM = 1.25  # [px] to either side of a disc's border
TIP = 0.3  # of an arrow's length

Place = Sequence[float] | Array


def disc(picture: Picture, centre: Place, radius: float, colour: Colour, rim: Colour | None = None) -> None:
    """Fill a disc; with a rim where one is given."""
    # Two filled discs: OpenCV's thick circles are polygons with visible corners.
    if rim is not None:
        cv2.circle(picture, _point(centre), round((radius + RIM) * 2**SHIFT), rim, FILLED, cv2.LINE_AA, SHIFT)
        radius -= RIM
    cv2.circle(picture, _point(centre), round(radius * 2**SHIFT), colour, FILLED, cv2.LINE_AA, SHIFT)


def line(picture: Picture, places: Array, colour: Colour, thickness: int, closed: bool = False) -> None:
    """Draw a line through places, shape (n, 2), n >= 1."""
    cv2.polylines(picture, [_fixed(places)], closed, colour, thickness, cv2.LINE_AA, SHIFT)


def polygon(picture: Picture, corners: Array, colour: Colour, rim: Colour | None = None) -> None:
    """Fill a polygon with corners of shape (n, 2); with a rim where one is given."""
    cv2.fillPoly(picture, [_fixed(corners)], colour, cv2.LINE_AA, SHIFT)
    if rim is not None:
        line(picture, corners, rim, 1, closed=True)


def arrow(picture: Picture, start: Place, end: Place, colour: Colour, thickness: int) -> None:
    """Draw an arrow."""
    cv2.arrowedLine(picture, _point(start), _point(end), colour, thickness, cv2.LINE_AA, SHIFT, TIP)


def _fixed(places: Place) -> NDArray[np.int32]:
    """Return places as OpenCV's fixed-point numbers; its pixel centres are whole numbers, ours are halves."""
    fixed: NDArray[np.int32] = np.rint((np.asarray(places, float) - 0.5) * 2**SHIFT).astype(np.int32)
    return fixed


def _point(place: Place) -> tuple[int, int]:
    column, row = _fixed(place).tolist()
    return column, row
