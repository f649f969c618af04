"""Which detections of an image are people: the rules by which the field counts them [Dollar2012]."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.overlap import intersection_over_first, intersection_over_union
from han_bullet.geometry import Array

ASPECT = 0.41  # width over height of every person's box
SMALLEST_MATCH = 0.5  # overlap of a hit


def fix_aspect(boxes: Array) -> Array:
    """Return boxes, (n, 4), of the same height and centre that are 0.41 times as wide as high."""
    width = ASPECT * boxes[:, 3]
    return np.column_stack([boxes[:, 0] + 0.5 * (boxes[:, 2] - width), boxes[:, 1], width, boxes[:, 3]])


def assign(boxes: Array, people: Array) -> NDArray[np.intp]:
    """Return whom each detection, sorted by falling score, hits: the free person it overlaps most, -1 for nobody.

    The overlap is intersection over union, at least one half. Each person is hit once.

    Args:
        boxes: Detections, shape (n, 4) [px].
        people: True boxes, shape (m, 4) [px].

    Returns:
        Rows of `people`, shape (n,).
    """
    overlaps = intersection_over_union(boxes, people)
    persons = np.full(len(boxes), -1)
    for number in range(len(boxes) if len(people) else 0):
        best = int(np.argmax(overlaps[number]))
        if overlaps[number, best] >= SMALLEST_MATCH:
            persons[number] = best
            overlaps[:, best] = -1.0  # this person is taken
    return persons


def match(boxes: Array, people: Array) -> NDArray[np.bool_]:
    """Tell which detections, sorted by falling score, hit a person; arguments as for `assign`."""
    return assign(boxes, people) >= 0


def in_ignored(boxes: Array, ignored: Array) -> NDArray[np.bool_]:
    """Tell which detections lie in one ignored region with at least half of their own area; any number may.

    Args:
        boxes: Detections, shape (n, 4) [px].
        ignored: Regions, shape (m, 4) [px].
    """
    inside: NDArray[np.bool_] = np.any(intersection_over_first(boxes, ignored) >= SMALLEST_MATCH, axis=1)
    return inside
