"""The scales at which people are searched: eight to the octave, each fitted to whole cells [Dollar2014]."""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass

import numpy as np

from han_bullet.detection.channels import CELL
from han_bullet.geometry import Array

SCALES_PER_OCTAVE = 8
SCALE_TRIALS = 100  # candidates near each scale, of which the one that fits both sides best is taken


@dataclass(frozen=True)
class LevelSize:
    """How large a level of a pyramid is.

    Attributes:
        scale: Size relative to the image.
        rows, columns: Size without padding [cells].
        scale_x, scale_y: Size relative to the image along each side, whose lengths are rounded to whole cells.
    """

    scale: float
    rows: int
    columns: int
    scale_x: float
    scale_y: float


def pyramid_scales(height: int, width: int, smallest_height: int, smallest_width: int, cell: int = CELL) -> list[float]:
    """Return the falling scales at which an image [px] is at least as large as the smallest object [px].

    Near each power 2^(-i/8) the scale is taken whose rounding to whole cells distorts the two sides least.
    """
    room = min(height / smallest_height, width / smallest_width)
    if room < 1.0:
        return []
    count = math.floor(SCALES_PER_OCTAVE * math.log2(room) + 1)
    shorter, longer = min(height, width), max(height, width)
    scales: list[float] = []
    for number in range(count):
        length = round_to_cells(shorter * 2.0 ** (-number / SCALES_PER_OCTAVE), cell) * cell
        low, high = (length - cell / 4) / shorter, (length + cell / 4) / shorter
        trials = low + np.arange(SCALE_TRIALS) / SCALE_TRIALS * (high - low)
        errors = np.maximum(_distance_to_cells(shorter * trials, cell), _distance_to_cells(longer * trials, cell))
        scale = float(trials[np.argmin(errors)])
        if not scales or scale != scales[-1]:
            scales.append(scale)
    return scales


@functools.lru_cache(maxsize=64)  # a camera's images all have one size, and finding the scales takes as long as a level
def level_sizes(height: int, width: int, smallest: tuple[int, int], cell: int = CELL) -> tuple[LevelSize, ...]:
    """Return the levels of an image of this size [px], from fine to coarse.

    Args:
        height: Of the image [px].
        width: Of the image [px].
        smallest: Height and width of the smallest object [px]; coarser levels are left out.
        cell: Side of a cell [px].
    """
    sizes = []
    for scale in pyramid_scales(height, width, *smallest, cell):
        rows, columns = round_to_cells(height * scale, cell), round_to_cells(width * scale, cell)
        sizes.append(LevelSize(scale, rows, columns, columns * cell / width, rows * cell / height))
    return tuple(sizes)


def round_to_cells(length: float, cell: int = CELL) -> int:
    """Return a length [px] in whole cells, halves upward."""
    return math.floor(length / cell + 0.5)


def _distance_to_cells(lengths: Array, cell: int) -> Array:
    """Return how far lengths [px] are from a whole number of cells [px]."""
    distances: Array = np.abs(lengths - np.floor(lengths / cell + 0.5) * cell)
    return distances


def octaves(count: int) -> list[tuple[int, range]]:
    """Return each real scale's number with the numbers of the scales nearest to it."""
    reals = list(range(0, count, SCALES_PER_OCTAVE))
    # Counted from one, as the original does, the scales are parted at the floor of the midpoint between two real ones.
    ends = [(a + b + 2) // 2 for a, b in itertools.pairwise(reals)] + [count]
    return [(real, range(start, end)) for real, start, end in zip(reals, [0, *ends], ends, strict=False)]
