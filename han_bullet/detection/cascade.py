"""The soft cascade: boosted depth-2 trees summed over every window until the sum falls too low [Dollar2014]."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.channels import CHANNELS, Floats

Ints = NDArray[np.int32]


def feature_offsets(features: Ints, window_columns: int, level_columns: int) -> Ints:
    """Return where features lie relative to a window's first value in a flattened level.

    Args:
        features: Indices into a window laid out (row, column, channel).
        window_columns: Width of a window [cells].
        level_columns: Width of the padded level [cells].
    """
    row, rest = np.divmod(features, window_columns * CHANNELS)
    return np.ascontiguousarray(row * level_columns * CHANNELS + rest, dtype=np.int32)


@numba.njit(cache=True)
def scan(
    level: Floats,
    window_rows: int,
    window_columns: int,
    offsets: Ints,
    thresholds: Floats,
    leaves: Floats,
    give_up: float,
) -> tuple[Ints, Ints, Floats]:
    """Return row, column [cells] and score of every window whose running sum stays above a limit.

    Args:
        level: Channels, shape (rows, columns, 10).
        window_rows: Height of a window [cells].
        window_columns: Width of a window [cells].
        offsets: Of the root's and the two children's features, shape (trees, 3).
        thresholds: A value below its threshold goes left, shape (trees, 3).
        leaves: From left to right, shape (trees, 4).
        give_up: A window is dropped as soon as its sum is not above this.
    """
    rows = max(level.shape[0] - window_rows + 1, 0)
    columns = max(level.shape[1] - window_columns + 1, 0)
    values = level.reshape(-1)
    found_rows, found_columns = np.empty(rows * columns, np.int32), np.empty(rows * columns, np.int32)
    scores = np.empty(rows * columns, np.float32)
    count = 0
    limit = np.float32(give_up)
    for row in range(rows):
        for column in range(columns):
            start = (row * level.shape[1] + column) * CHANNELS
            score = np.float32(0.0)
            alive = True
            for tree in range(offsets.shape[0]):
                side = 0 if values[start + offsets[tree, 0]] < thresholds[tree, 0] else 1
                leaf = 0 if values[start + offsets[tree, 1 + side]] < thresholds[tree, 1 + side] else 1
                score += leaves[tree, 2 * side + leaf]
                if score <= limit:
                    alive = False
                    break
            if alive:
                found_rows[count], found_columns[count], scores[count] = row, column, score
                count += 1
    return found_rows[:count], found_columns[:count], scores[:count]
