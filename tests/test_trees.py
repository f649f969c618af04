"""Quantised features, and trees fitted to them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.detection.training.trees import BINS, best_split, fit_tree, quantise


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 40), st.integers(1, 20))
def test_a_threshold_parts_values_as_their_bins_are_parted(seed: int, samples: int, features: int) -> None:
    values = np.random.default_rng(seed).normal(0, 1, (samples, features)).astype(np.float32)
    data = quantise(values)
    for feature in range(features):
        threshold = data.thresholds(np.array([feature]), np.array([int(np.median(data.bins[feature]))]))[0]
        steps = (values[:, feature] - data.lowest[feature]) / data.step[feature]
        assert data.bins[feature] == pytest.approx(np.rint(steps))
        middle = int(np.median(data.bins[feature]))
        clear = np.abs(steps - np.floor(steps) - 0.5) > 1e-3  # not on the edge of two bins
        left = values[:, feature] < threshold
        assert np.array_equal(left[clear], (data.bins[feature] <= middle)[clear])


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_best_split_is_the_best_of_all(seed: int) -> None:
    rng = np.random.default_rng(seed)
    bins = rng.integers(0, BINS, (4, 30), dtype=np.uint8)
    signed = rng.normal(0, 1, 30)
    members = np.arange(0, 30, 2, dtype=np.int32)
    here = signed[members]
    background, weight = -here[here < 0].sum(), np.abs(here).sum()
    feature, bin_number = best_split(bins, np.arange(4, dtype=np.int32), members, signed, background, weight)

    def error(feature: int, bin_number: int) -> float:
        wrong = np.abs(here[(bins[feature, members] <= bin_number) == (here > 0)]).sum()
        return min(wrong, weight - wrong)

    best = min(error(f, b) for f in range(4) for b in range(BINS - 1))
    assert error(feature, bin_number) == pytest.approx(best, abs=1e-9)


@pytest.mark.parametrize("depth", [1, 2, 4])
def test_a_sample_ends_in_the_leaf_that_the_nodes_lead_it_to(depth: int) -> None:
    rng = np.random.default_rng(depth)
    bins = rng.integers(0, BINS, (64, 500), dtype=np.uint8)
    signed = np.where(bins[7] > 100, 1.0, -1.0) * rng.uniform(0.1, 1.0, 500)
    tree = fit_tree(bins, signed, depth, rng)
    assert tree.features.shape == tree.bin_numbers.shape == (2**depth - 1,)
    for sample in range(500):
        node = 0
        while node < 2**depth - 1:
            node = 2 * node + (2 if bins[tree.features[node], sample] > tree.bin_numbers[node] else 1)
        assert tree.leaf_of_sample[sample] == node - (2**depth - 1)


def test_a_pure_node_is_not_split() -> None:
    rng = np.random.default_rng(0)
    bins = rng.integers(0, BINS, (32, 50), dtype=np.uint8)
    tree = fit_tree(bins, np.ones(50), 2, rng)
    assert np.all(tree.bin_numbers == BINS - 1)
    assert np.all(tree.leaf_of_sample == 0)
