"""The soft cascade: boosted trees summed over every window until the sum falls too low [Dollar2014]."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.channels import CHANNELS, Float, Floats

Ints = NDArray[np.int32]
Offsets = NDArray[np.uint32]
"""Without sign, as are node numbers: the compiled code need not ask at each index whether it counts from the end."""

_TWO = np.uint32(2)


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
    windows: NDArray[np.bool_],
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
        windows: Which to look at, by their first row and column [cells]; every window must lie in the level.
        offsets: Of the nodes' features, shape (trees, 2^depth - 1).
        thresholds: A value below its threshold goes left, shape (trees, 2^depth - 1).
        leaves: From left to right, shape (trees, 2^depth).
        give_up: A window is dropped as soon as its sum is not above this.

    Returns:
        Rows, columns, scores, and how many trees were evaluated.
    """
    values = level.reshape(-1)
    most = windows.sum()
    found_rows, found_columns = np.empty(most, np.int32), np.empty(most, np.int32)
    scores = np.empty(most, np.float32)
    limit = np.float32(give_up)
    count, trees = 0, 0
    for row in range(windows.shape[0]):
        line = values[row * level.shape[1] * level.shape[2] :]
        places, sums = found_columns[count:], scores[count:]
        found, used = _scan_row(line, windows[row], level.shape[2], offsets, thresholds, leaves, limit, places, sums)
        found_rows[count : count + found] = row
        count += found
        trees += used
    return found_rows[:count], found_columns[:count], scores[:count], trees


@numba.njit(cache=True)
def _scan_row(
    line: Floats,
    windows: NDArray[np.bool_],
    channels: int,
    offsets: Offsets,
    thresholds: Floats,
    leaves: Floats,
    limit: Float,
    places: Ints,
    sums: Floats,
) -> tuple[int, int]:
    """Write columns and scores of the windows of a row that pass; return how many, and how many trees that took."""
    count, trees = 0, 0
    for column in range(windows.size):
        if not windows[column]:
            continue
        start = np.uint32(column * channels)
        score = np.float32(0.0)
        alive = True
        for tree in range(offsets.shape[0]):
            score += leaves[tree, _leaf(line, start, offsets[tree], thresholds[tree])]
            if score <= limit:
                trees += tree + 1
                alive = False
                break
        if alive:
            trees += offsets.shape[0]
            places[count], sums[count] = column, score
            count += 1
    return count, trees


@numba.njit(cache=True, inline="always")
def _leaf(line: Floats, start: np.uint32, offsets: Offsets, thresholds: Floats) -> np.uint32:
    """Return the leaf of one tree that a window reaches.

    Without branches, since no processor can guess which way a window goes. The usual depths, 2 and 3, are written out.
    """
    root = np.uint32(line[start + offsets[0]] < thresholds[0])  # 1 goes left
    if offsets.size == 7:  # both children are compared while the root's value is still on its way from memory
        left = np.uint32(line[start + offsets[1]] < thresholds[1])
        right = np.uint32(line[start + offsets[2]] < thresholds[2])
        node = np.uint32(6) - _TWO * root - (right ^ ((left ^ right) & root))
        node = _TWO * node + _TWO - np.uint32(line[start + offsets[node]] < thresholds[node])
    else:
        node = _TWO - root
        if offsets.size == 3:
            node = _TWO * node + _TWO - np.uint32(line[start + offsets[node]] < thresholds[node])
        while node < offsets.size:
            node = _TWO * node + _TWO - np.uint32(line[start + offsets[node]] < thresholds[node])
    return node - np.uint32(offsets.size)
