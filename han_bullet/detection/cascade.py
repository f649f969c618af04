"""The soft cascade: boosted trees summed over every window until the sum falls too low [Dollar2014]."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.channels import CHANNELS, Float, Floats

Ints = NDArray[np.int32]
Offsets = NDArray[np.uint32]
"""Without sign, as are node numbers: the compiled code need not ask at each index whether it counts from the end."""

_ONE, _TWO = np.uint32(1), np.uint32(2)


def feature_rows(features: Ints, window_columns: int, channels: int = CHANNELS) -> Ints:
    """Return the rows [cells] of features, indices into a window laid out (row, column, channel)."""
    return np.asarray(features // (window_columns * channels), np.int32)


def feature_offsets(
    features: Ints, rows: Ints, window_columns: int, level_columns: int, channels: int = CHANNELS
) -> Offsets:
    """Return where features lie relative to a window's first value in a flattened level.

    Args:
        features: Indices into a window laid out (row, column, channel).
        rows: Of the features, as `feature_rows` gives them: the same for every level, so divided out only once.
        window_columns: Width of a window [cells].
        level_columns: Width of the padded level [cells].
        channels: How many there are.
    """
    return (features + rows * np.int32((level_columns - window_columns) * channels)).astype(np.uint32)


@numba.njit(cache=True)
def scan(
    level: Floats,
    window_rows: Ints,
    window_columns: int,
    offsets: Offsets,
    thresholds: Floats,
    leaves: Floats,
    give_up: float,
) -> tuple[Ints, Ints, Floats, int]:
    """Return row, column [cells] and score of every window whose running sum stays above a limit.

    A tree is complete: the children of node k are 2k + 1 (left) and 2k + 2 (right). Every window goes through its trees
    in one pass: most are given up after a few, and to take the first 32 trees over all windows first, then the rest
    over the survivors, took 1.5 to 2.3 times as long.

    Args:
        level: Channels, shape (rows, columns, channels).
        window_rows: First rows of the windows to look at [cells].
        window_columns: Width of a window [cells].
        offsets: Of the nodes' features, shape (trees, 2^depth - 1); all must lie in the level from each of the rows.
        thresholds: A value below its threshold goes left, shape (trees, 2^depth - 1).
        leaves: From left to right, shape (trees, 2^depth).
        give_up: A window is dropped as soon as its sum is not above this.

    Returns:
        Rows, columns, scores, and how many trees were evaluated.
    """
    columns = max(level.shape[1] - window_columns + 1, 0)
    values = level.reshape(-1)
    most = window_rows.size * columns
    found_rows, found_columns = np.empty(most, np.int32), np.empty(most, np.int32)
    scores = np.empty(most, np.float32)
    limit = np.float32(give_up)
    count, trees = 0, 0
    for row in window_rows:
        line = values[row * level.shape[1] * level.shape[2] :]
        places, sums = found_columns[count:], scores[count:]
        if offsets.shape[1] == 3:
            found, used = _scan_row_by_pairs(
                line, columns, level.shape[2], offsets, thresholds, leaves, limit, places, sums
            )
        else:
            found, used = _scan_row(line, columns, level.shape[2], offsets, thresholds, leaves, limit, places, sums)
        found_rows[count : count + found] = row
        count += found
        trees += used
    return found_rows[:count], found_columns[:count], scores[:count], trees


@numba.njit(cache=True)
def _scan_row(
    line: Floats,
    columns: int,
    channels: int,
    offsets: Offsets,
    thresholds: Floats,
    leaves: Floats,
    limit: Float,
    places: Ints,
    sums: Floats,
) -> tuple[int, int]:
    """Write columns and scores of the windows of a row that pass; return how many, and how many trees that took."""
    count, trees, nodes = 0, 0, np.uint32(offsets.shape[1])
    for column in range(columns):
        start = np.uint32(column * channels)
        score = np.float32(0.0)
        alive = True
        for tree in range(offsets.shape[0]):
            node = np.uint32(0)
            while node < nodes:
                goes_left = line[start + offsets[tree, node]] < thresholds[tree, node]
                node = _TWO * node + (_ONE if goes_left else _TWO)
            score += leaves[tree, node - nodes]
            if score <= limit:
                trees += tree + 1
                alive = False
                break
        if alive:
            trees += offsets.shape[0]
            places[count], sums[count] = column, score
            count += 1
    return count, trees


@numba.njit(cache=True)
def _scan_row_by_pairs(
    line: Floats,
    columns: int,
    channels: int,
    offsets: Offsets,
    thresholds: Floats,
    leaves: Floats,
    limit: Float,
    places: Ints,
    sums: Floats,
) -> tuple[int, int]:
    """Do as `_scan_row` does for trees of depth 2, two comparisons each: twice as fast."""
    count, trees = 0, 0
    for column in range(columns):
        start = np.uint32(column * channels)
        score = np.float32(0.0)
        alive = True
        for tree in range(offsets.shape[0]):
            side = 0 if line[start + offsets[tree, 0]] < thresholds[tree, 0] else 1
            leaf = 0 if line[start + offsets[tree, 1 + side]] < thresholds[tree, 1 + side] else 1
            score += leaves[tree, 2 * side + leaf]
            if score <= limit:
                trees += tree + 1
                alive = False
                break
        if alive:
            trees += offsets.shape[0]
            places[count], sums[count] = column, score
            count += 1
    return count, trees
