"""Quantisation and boosting of depth-2 trees."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.detection.training.boosting import (
    BINS,
    BoostingStep,
    QuantisedFeatures,
    Trees,
    _best_split,
    boost,
    quantise,
)


def nothing(step: BoostingStep) -> None:
    """Ignore progress."""


def decide(trees: Trees, samples: np.ndarray) -> np.ndarray:
    """Apply trees to samples, (n, features), in the plainest way."""
    sums = np.zeros(len(samples))
    for features, thresholds, leaves in zip(trees.features, trees.thresholds, trees.leaves, strict=True):
        side = (samples[:, features[0]] >= thresholds[0]).astype(int)
        child = 1 + side
        leaf = samples[np.arange(len(samples)), features[child]] >= thresholds[child]
        sums += leaves[2 * side + leaf]
    return sums


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 40), st.integers(1, 20))
def test_a_threshold_parts_values_as_their_bins_are_parted(seed: int, samples: int, features: int) -> None:
    values = np.random.default_rng(seed).normal(0, 1, (samples, features)).astype(np.float32)
    data = quantise(values)
    for feature in range(features):
        steps = (values[:, feature] - data.lowest[feature]) / data.step[feature]
        assert data.bins[feature] == pytest.approx(np.rint(steps))
        middle = int(np.median(data.bins[feature]))
        clear = np.abs(steps - np.floor(steps) - 0.5) > 1e-3  # not on the edge of two bins
        left = values[:, feature] < data.threshold(feature, middle)
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
    feature, bin_number = _best_split(bins, np.arange(4, dtype=np.int32), members, signed, background, weight)

    def error(feature: int, bin_number: int) -> float:
        wrong = np.abs(here[(bins[feature, members] <= bin_number) == (here > 0)]).sum()
        return min(wrong, weight - wrong)

    best = min(error(f, b) for f in range(4) for b in range(BINS - 1))
    assert error(feature, bin_number) == pytest.approx(best, abs=1e-9)


def test_trees_learn_that_two_features_must_both_be_large() -> None:
    rng = np.random.default_rng(1)
    samples = rng.uniform(-1, 1, (600, 32)).astype(np.float32)
    is_person = (samples[:, 3] > 0) & (samples[:, 17] > 0)
    trees = boost(quantise(samples), is_person, 150, rng, nothing)
    fresh = rng.uniform(-1, 1, (600, 32)).astype(np.float32)
    right = (decide(trees, fresh) > 0) == ((fresh[:, 3] > 0) & (fresh[:, 17] > 0))
    assert right.mean() > 0.93


def test_the_loss_falls_with_every_tree_by_the_factor_that_theory_gives() -> None:
    rng = np.random.default_rng(2)
    samples = rng.normal(0, 1, (400, 64)).astype(np.float32)
    is_person = samples[:, :8].sum(axis=1) + rng.normal(0, 1, 400) > 0.5
    steps: list[BoostingStep] = []
    boost(quantise(samples), is_person, 40, rng, steps.append)
    loss = 1.0
    for step in steps:
        # The loss shrinks by 2 sqrt(error (1 - error)) with each tree [Friedman2000].
        assert step.loss == pytest.approx(loss * 2 * math.sqrt(step.error * (1 - step.error)), rel=1e-9)
        assert step.alpha == pytest.approx(0.5 * math.log((1 - step.error) / step.error))
        loss = step.loss
    assert len(steps) == 40


def test_both_classes_weigh_the_same_whatever_their_numbers() -> None:
    samples = np.zeros((100, 16), np.float32)
    samples[:3] = 3.0
    trees = boost(quantise(samples), np.arange(100) < 3, 1, np.random.default_rng(0), nothing)
    sums = decide(trees, samples)
    assert np.all(sums[:3] > 4.9)  # alpha is limited to 5
    assert np.all(sums[3:] < -4.9)


def test_boosting_stops_when_features_tell_nothing() -> None:
    samples = np.full((20, 16), 0.5, np.float32)
    trees = boost(quantise(samples), np.arange(20) < 10, 5, np.random.default_rng(0), nothing)
    assert trees.features.shape == (0, 3)
    assert trees.leaves.shape == (0, 4)


def test_the_same_seed_gives_the_same_trees_bit_for_bit() -> None:
    samples = np.random.default_rng(3).normal(0, 1, (200, 64)).astype(np.float32)
    data: QuantisedFeatures = quantise(samples)
    first, second, other = (
        boost(data, samples[:, 5] > 0.2, 8, np.random.default_rng(seed), nothing) for seed in (9, 9, 10)
    )
    assert np.array_equal(first.features, second.features)
    assert np.array_equal(first.leaves, second.leaves)
    assert not np.array_equal(first.features, other.features)
