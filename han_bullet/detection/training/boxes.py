"""Boxes near a person's: as good proposals place them, and as bad ones do."""

from __future__ import annotations

import math

import numpy as np

from han_bullet.detection.overlap import intersection_over_union
from han_bullet.geometry import Array

LARGEST_DEFORMATION = 5.0  # of place and of size [px], as the paper has it
MISPLACED_OVERLAP = (0.1, 0.45)  # intersection over union of a misplaced box with the person
MOST_TRIALS = 50  # draws of a misplaced box until its overlap is right


def deformed(box: Array, generator: np.random.Generator) -> Array:
    """Return a box, (x, y, width, height) [px], moved and scaled by 0 to 5 px at random."""
    across, down, growth = generator.uniform(-LARGEST_DEFORMATION, LARGEST_DEFORMATION, 3) / box[3]
    return placed(box, across, down, 1.0 + growth)


def misplaced(box: Array, kind: int, generator: np.random.Generator) -> Array:
    """Return a box that a first stage might give around a person, and that is wrong.

    Args:
        box: The person's: x, y, width, height [px].
        kind: Modulo 4: beside the person; too large; too small, a part of the body; too high or too low.
        generator: Draws the rest.
    """
    moved = box
    for _ in range(MOST_TRIALS):
        side = generator.choice([-1.0, 1.0])
        across, down, scale = (
            (side * generator.uniform(0.12, 0.3), generator.normal(0.0, 0.04), math.exp(generator.normal(0.0, 0.1))),
            (generator.normal(0.0, 0.1), generator.uniform(-0.3, 0.3), generator.uniform(1.3, 1.8)),
            (generator.normal(0.0, 0.06), generator.uniform(-0.3, 0.3), generator.uniform(0.4, 0.75)),
            (generator.normal(0.0, 0.06), side * generator.uniform(0.25, 0.5), math.exp(generator.normal(0.0, 0.15))),
        )[kind % 4]
        moved = placed(box, across, down, scale)
        if MISPLACED_OVERLAP[0] < intersection_over_union(moved, box)[0, 0] < MISPLACED_OVERLAP[1]:
            break
    return moved


def placed(box: Array, across: float, down: float, scale: float) -> Array:
    """Return a box whose centre is moved by parts of its height and whose size is multiplied."""
    x, y, width, height = box
    centre_x, centre_y = x + 0.5 * width + across * height, y + 0.5 * height + down * height
    return np.array([centre_x - 0.5 * scale * width, centre_y - 0.5 * scale * height, scale * width, scale * height])
