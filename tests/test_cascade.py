"""The soft cascade over windows."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.detection.cascade import feature_offsets, feature_rows, scan
from han_bullet.detection.channels import CHANNELS

ROWS, COLUMNS = 4, 3  # a small window [cells]


def all_windows(rows: int, columns: int) -> np.ndarray:
    """All windows of a level of so many rows and columns, by where they start."""
    return np.ones((max(rows - ROWS + 1, 0), max(columns - COLUMNS + 1, 0)), np.bool_)


def random_trees(rng: np.random.Generator, trees: int, depth: int = 2) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    nodes = 2**depth - 1
    features = rng.integers(0, ROWS * COLUMNS * CHANNELS, (trees, nodes)).astype(np.int32)
    leaves = rng.normal(0, 0.5, (trees, nodes + 1)).astype(np.float32)
    return features, rng.random((trees, nodes), np.float32), leaves


def plain_score(window: np.ndarray, features: np.ndarray, thresholds: np.ndarray, leaves: np.ndarray, give_up: float):
    values, score = window.reshape(-1), np.float32(0)
    nodes = features.shape[1]
    for tree in range(len(features)):
        node = 0
        while node < nodes:
            goes_left = values[features[tree, node]] < thresholds[tree, node]
            node = 2 * node + 1 if goes_left else 2 * node + 2
        score += leaves[tree, node - nodes]
        if score <= np.float32(give_up):
            return None, tree + 1
    return score, len(features)


def offsets_in(features: np.ndarray, level_columns: int) -> np.ndarray:
    return feature_offsets(features, feature_rows(features, COLUMNS), COLUMNS, level_columns)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 9), st.integers(1, 9), st.floats(-2, 1), st.integers(1, 5))
def test_the_scan_equals_the_trees_applied_to_each_window(
    seed: int, rows: int, columns: int, give_up: float, depth: int
) -> None:
    rng = np.random.default_rng(seed)
    level = rng.random((rows, columns, CHANNELS), np.float32)
    features, thresholds, leaves = random_trees(rng, 12, depth)
    offsets = offsets_in(features, columns)
    *found, trees = scan(level, all_windows(rows, columns), offsets, thresholds, leaves, give_up)
    expected, expected_trees = [], 0
    for row in range(rows - ROWS + 1):
        for column in range(columns - COLUMNS + 1):
            window = level[row : row + ROWS, column : column + COLUMNS]
            score, used = plain_score(window, features, thresholds, leaves, give_up)
            expected_trees += used
            if score is not None:
                expected.append((row, column, score))
    assert list(zip(*(part.tolist() for part in found), strict=True)) == expected
    assert trees == expected_trees


def test_trees_of_depth_two_score_alike_in_a_deeper_frame() -> None:
    rng = np.random.default_rng(11)
    level = rng.random((30, 30, CHANNELS), np.float32)
    features, thresholds, leaves = random_trees(rng, 20)
    deeper = np.concatenate([features, np.zeros((20, 4), np.int32)], axis=1)
    deeper_thresholds = np.concatenate([thresholds, rng.random((20, 4), np.float32)], axis=1)
    shallow = scan(level, all_windows(30, 30), offsets_in(features, 30), thresholds, leaves, -1.0)
    deep = scan(
        level,
        all_windows(30, 30),
        offsets_in(deeper, 30),
        deeper_thresholds,
        np.repeat(leaves, 2, axis=1),
        -1.0,
    )
    assert 10 < shallow[0].size < 27 * 28
    assert all(np.array_equal(one, other) for one, other in zip(shallow, deep, strict=True))


def test_windows_left_out_are_not_looked_at() -> None:
    rng = np.random.default_rng(7)
    level = rng.random((30, 20, CHANNELS), np.float32)
    features, thresholds, leaves = random_trees(rng, 30)
    offsets = offsets_in(features, 20)
    everything = scan(level, all_windows(30, 20), offsets, thresholds, leaves, -0.5)
    chosen = rng.random(all_windows(30, 20).shape) < 0.3
    some = scan(level, chosen, offsets, thresholds, leaves, -0.5)
    in_chosen = chosen[everything[0], everything[1]]
    assert 0 < in_chosen.sum() < in_chosen.size
    assert all(np.array_equal(part, whole[in_chosen]) for part, whole in zip(some[:3], everything[:3], strict=True))
    assert some[3] < everything[3]


def test_a_lower_limit_never_loses_a_window() -> None:
    rng = np.random.default_rng(5)
    level = rng.random((20, 20, CHANNELS), np.float32)
    features, thresholds, leaves = random_trees(rng, 30)
    offsets = offsets_in(features, 20)
    strict = scan(level, all_windows(20, 20), offsets, thresholds, leaves, -0.5)
    loose = scan(level, all_windows(20, 20), offsets, thresholds, leaves, -5.0)
    places = [set(zip(found[0].tolist(), found[1].tolist(), strict=True)) for found in (strict, loose)]
    assert 0 < len(places[0]) < len(places[1])
    assert places[0] <= places[1]
