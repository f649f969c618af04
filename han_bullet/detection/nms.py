"""Greedy non-maximum suppression by the overlap with the smaller box [Dollar2014]."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array

LARGEST_OVERLAP = 0.65  # intersection over the smaller area that two people may share


def suppress(boxes: Array, scores: Array) -> NDArray[np.int64]:
    """Return the indices of the boxes to keep, by falling score.

    A box goes when a kept box of higher score shares more than LARGEST_OVERLAP of the smaller area with it;
    a suppressed box suppresses nothing. Of equal scores the first in the list counts as the higher.

    Args:
        boxes: x, y, width, height, shape (n, 4) [px].
        scores: Shape (n,).
    """
    order = np.argsort(-np.asarray(scores, float), kind="stable")
    kept: NDArray[np.int64] = order[_greedy(np.asarray(boxes, float)[order], LARGEST_OVERLAP)]
    return kept


@numba.njit(cache=True)
def _greedy(boxes: Array, largest_overlap: float) -> NDArray[np.bool_]:
    """Tell which boxes, (n, 4), already sorted, stay."""
    kept = np.ones(boxes.shape[0], np.bool_)
    for first in range(boxes.shape[0]):
        if not kept[first]:
            continue
        x, y, width, height = boxes[first]
        for second in range(first + 1, boxes.shape[0]):
            if kept[second]:
                across = min(x + width, boxes[second, 0] + boxes[second, 2]) - max(x, boxes[second, 0])
                down = min(y + height, boxes[second, 1] + boxes[second, 3]) - max(y, boxes[second, 1])
                smaller = min(width * height, boxes[second, 2] * boxes[second, 3])
                if across > 0.0 and down > 0.0 and across * down > largest_overlap * smaller:
                    kept[second] = False
    return kept
