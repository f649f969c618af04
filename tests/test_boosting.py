"""Boosting of trees: the classical kind and the gentle one."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.detection.training.boosting import (
    Boosting,
    BoostingStep,
    DiscreteAdaBoost,
    GentleBoost,
    Trees,
    boost,
)
from han_bullet.detection.training.trees import QuantisedFeatures, quantise
from han_bullet.errors import BadInputError

BOTH = pytest.mark.parametrize("boosting", [DiscreteAdaBoost(), GentleBoost()], ids=["discrete", "gentle"])


def nothing(step: BoostingStep) -> None:
    """Ignore progress."""


def decide(trees: Trees, samples: np.ndarray) -> np.ndarray:
    """Apply trees to samples, (n, features), in the plainest way."""
    sums = np.zeros(len(samples))
    for features, thresholds, leaves in zip(trees.features, trees.thresholds, trees.leaves, strict=True):
        node = np.zeros(len(samples), int)
        while node[0] < features.size:
            right = samples[np.arange(len(samples)), features[node]] >= thresholds[node]
            node = 2 * node + 1 + right
        sums += leaves[node - features.size]
    return sums


@BOTH
@pytest.mark.parametrize("depth", [2, 3])
def test_trees_learn_that_two_features_must_both_be_large(boosting: Boosting, depth: int) -> None:
    rng = np.random.default_rng(1)
    samples = rng.uniform(-1, 1, (600, 32)).astype(np.float32)
    is_person = (samples[:, 3] > 0) & (samples[:, 17] > 0)
    trees = boost(quantise(samples), is_person, 150, depth, boosting, rng, nothing)
    fresh = rng.uniform(-1, 1, (600, 32)).astype(np.float32)
    right = (decide(trees, fresh) > 0) == ((fresh[:, 3] > 0) & (fresh[:, 17] > 0))
    assert right.mean() > 0.93


def test_the_exponential_loss_falls_with_every_tree_by_the_factor_that_theory_gives() -> None:
    rng = np.random.default_rng(2)
    samples = rng.normal(0, 1, (400, 64)).astype(np.float32)
    is_person = samples[:, :8].sum(axis=1) + rng.normal(0, 1, 400) > 0.5
    steps: list[BoostingStep] = []
    boost(quantise(samples), is_person, 40, 2, DiscreteAdaBoost(), rng, steps.append)
    loss = 1.0
    for step in steps:
        # The loss shrinks by 2 sqrt(error (1 - error)) with each tree [Friedman2000].
        assert step.loss == pytest.approx(loss * 2 * math.sqrt(step.error * (1 - step.error)), rel=1e-9)
        assert step.vote == pytest.approx(0.5 * math.log((1 - step.error) / step.error))
        loss = step.loss
    assert len(steps) == 40


def test_both_classes_weigh_the_same_whatever_their_numbers() -> None:
    samples = np.zeros((100, 16), np.float32)
    samples[:3] = 3.0
    trees = boost(quantise(samples), np.arange(100) < 3, 1, 2, DiscreteAdaBoost(), np.random.default_rng(0), nothing)
    sums = decide(trees, samples)
    assert np.all(sums[:3] > 4.9)  # alpha is limited to 5
    assert np.all(sums[3:] < -4.9)


@BOTH
def test_boosting_stops_when_features_tell_nothing(boosting: Boosting) -> None:
    samples = np.full((20, 16), 0.5, np.float32)
    trees = boost(quantise(samples), np.arange(20) < 10, 5, 2, boosting, np.random.default_rng(0), nothing)
    assert trees.features.shape == (0, 3)
    assert trees.leaves.shape == (0, 4)


def test_the_same_seed_gives_the_same_trees_bit_for_bit() -> None:
    samples = np.random.default_rng(3).normal(0, 1, (200, 64)).astype(np.float32)
    data: QuantisedFeatures = quantise(samples)
    first, second, other = (
        boost(data, samples[:, 5] > 0.2, 8, 2, GentleBoost(), np.random.default_rng(seed), nothing)
        for seed in (9, 9, 10)
    )
    assert np.array_equal(first.features, second.features)
    assert np.array_equal(first.leaves, second.leaves)
    assert not np.array_equal(first.features, other.features)


def test_gentle_leaves_vote_in_steps_by_their_purity() -> None:
    votes = GentleBoost(step=0.2).votes(np.array([1.0, 0.0, 0.3, 0.0]), np.array([0.0, 2.0, 0.1, 0.0]))
    assert votes == pytest.approx([0.2, -0.2, 0.1, 0.0])


@BOTH
@given(st.floats(-30, 30))
def test_a_weight_is_how_fast_the_loss_falls_with_the_margin(boosting: Boosting, margin: float) -> None:
    around = boosting.losses(np.array([margin - 1e-4, margin + 1e-4]))
    zero = boosting.losses(np.array([-1e-4, 1e-4]))
    slope, slope_at_zero = np.diff(around)[0], np.diff(zero)[0]
    weights = boosting.weights(np.array([margin, 0.0]))
    assert slope / slope_at_zero == pytest.approx(weights[0] / weights[1], rel=1e-3, abs=1e-9)


def test_one_mislabelled_sample_takes_over_discrete_boosting_but_not_the_gentle_one() -> None:
    margins = np.array([-6.0, *[2.0] * 999])  # one sample far on the wrong side
    shares = [b.weights(margins)[0] / b.weights(margins).sum() for b in (DiscreteAdaBoost(), GentleBoost())]
    assert shares[0] > 0.7
    assert shares[1] < 0.06


@pytest.mark.parametrize("step", [0.0, -0.1, 1.5, float("nan")])
def test_a_step_outside_zero_to_one_is_bad_input(step: float) -> None:
    with pytest.raises(BadInputError, match="step"):
        GentleBoost(step)
