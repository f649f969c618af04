"""How far a picture of a still scene has moved: a camera that hangs otherwise than it did shows its scene elsewhere.

People cover and uncover parts of a scene, a television goes on; neither moves the rest. Phase correlation
[Kuglin1975] finds a shift of the whole, and the picture moved back by it must then fit better.
"""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array

Means = NDArray[np.uint8]
"""Mean colours of the cells of an image, shape (rows, columns, 3)."""

LEAST_SHIFT = 0.75  # [cells]: three pixels, or a third of a degree
# Of the mean difference, what may be left after moving the picture back: turning also distorts, and people are left.
LEFT_OVER = 0.8


def scene_shift(scene: Means, image: Means) -> tuple[float, float]:
    """Return how far a scene has moved in an image, right and down [cells]; (0, 0) where a shift explains nothing."""
    one, other = (_grey(means) for means in (scene, image))
    window = _window(*one.shape)  # not handed over to phaseCorrelate, which would fade out the images themselves
    (right, down), _ = cv2.phaseCorrelate(window * one, window * other)
    if not np.hypot(right, down) >= LEAST_SHIFT:  # also where there is nothing to be seen: NaN
        return 0.0, 0.0
    back = np.array([[1.0, 0.0, -right], [0.0, 1.0, -down]])
    moved = cv2.warpAffine(other, back, other.shape[::-1], borderMode=cv2.BORDER_REPLICATE)
    before, after = (float(cv2.absdiff(one, grey).mean()) for grey in (other, moved))
    return (float(right), float(down)) if after <= LEFT_OVER * before else (0.0, 0.0)


def _grey(means: Means) -> Array:
    return np.asarray(cv2.cvtColor(means, cv2.COLOR_RGB2GRAY), float)


@cache
def _window(rows: int, columns: int) -> Array:
    """Return what fades out an image's borders, which a shift moves in and out."""
    return np.asarray(cv2.createHanningWindow((columns, rows), cv2.CV_64F))
