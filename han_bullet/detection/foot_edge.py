"""Where people's feet end in the image of a fixed camera, to the pixel: where the changes against its empty scene do.

A detector's boxes come in steps of 9 % of their height, so a lower edge may be off by 9 px of 200: 0.2 m on the floor,
and always the same for somebody who stands still. What has changed against the empty scene ends at the soles.
"""

from __future__ import annotations

import cv2
import numpy as np

from han_bullet.detection.pictures import Image
from han_bullet.geometry import Array

# Where the soles are looked for, from a box's lower edge, in box heights: boxes end 1.4 % below the feet, and half a
# step of the scales and half a cell of the window make 8 % to either side. With 5 % twice as many boxes are not told.
ABOVE, BELOW = 0.095, 0.065
# A box may hold but the upper part of somebody, whose legs then go on below it, this far at most, in box heights; what
# is wider than legs there, in box widths, is the robot or somebody else.
FURTHER, WIDEST = 0.6, 0.75
# Pixels are compared as means over BLUR x BLUR, on which a noise of 6 grey levels leaves 2.8 in the difference of two.
BLUR = 3  # [px]
# A pixel has changed when one of its colours differs by more: 5 standard deviations of that difference.
CHANGED_LEVEL = 14  # [grey levels]
# A row shows feet when so many of its pixels have changed, per box height: half a shoe's width.
LEAST_WIDTH, LEAST_PIXELS = 0.02, 2.0


def foot_rows(image: Image, empty: Image, boxes: Array) -> Array:
    """Return the rows [px] where the feet in some boxes end; NaN where nobody can tell, shape (n,).

    Nobody can where nothing has changed at the feet, where the changes go on further down (the robot or somebody else
    before the feet, a shadow, other light), or where the image ends.

    Args:
        image: RGB, shape (height, width, 3).
        empty: The same view without people and robot.
        boxes: Of people, shape (n, 4): x, y, width, height [px].
    """
    return np.array([_foot_row(image, empty, box) for box in np.asarray(boxes, float).reshape(-1, 4)], float)


def _foot_row(image: Image, empty: Image, box: Array) -> float:
    x, y, width, height = box
    top, bottom, end = (round(y + share * height) for share in (1.0 - ABOVE, 1.0 + BELOW, 1.0 + FURTHER))
    left, right = max(round(x), 0), min(round(x + width), image.shape[1])
    if top < 0 or bottom > image.shape[0] or top >= bottom or left >= right:
        return float("nan")
    strip = slice(top, end), slice(left, right)
    difference = cv2.absdiff(cv2.blur(image[strip], (BLUR, BLUR)), cv2.blur(empty[strip], (BLUR, BLUR)))
    changed = np.count_nonzero(difference.max(axis=2) > CHANGED_LEVEL, axis=1)
    shows = changed >= max(LEAST_WIDTH * height, LEAST_PIXELS)
    if not shows[0] or shows.all():
        return float("nan")
    rows = int(np.argmin(shows))
    if rows >= bottom - top and changed[:rows].max() > WIDEST * width:
        return float("nan")
    return float(top + rows - BLUR // 2)  # a mean still shows what ended so many rows above
