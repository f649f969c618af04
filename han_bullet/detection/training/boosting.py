"""Boosting: sums of trees whose sign tells people from background [Friedman2000]."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.cascade import Ints
from han_bullet.detection.channels import Floats
from han_bullet.detection.training.trees import FittedTree, QuantisedFeatures, fit_tree
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array

LARGEST_ALPHA = 5.0
SMALLEST_VOTE = 1e-9  # a tree whose largest vote is smaller is no better than chance: the rest is rounding
SMALLEST_LOSS = 1e-40


class Boosting(ABC):
    """How samples are weighed, and what a tree's leaves then vote.

    Attributes:
        calibration: What the finished detector adds to each leaf, so that its cascade gives up fewer people.
        cascade_threshold: A window is given up as soon as its sum is not above this; it goes with the size of votes.
    """

    calibration: float
    cascade_threshold: float

    @abstractmethod
    def losses(self, margins: Array) -> Array:
        """Return the loss of samples by their margin, the sum of votes times the true sign (1 or -1), shape (n,)."""

    @abstractmethod
    def weights(self, margins: Array) -> Array:
        """Return how much samples with these margins matter to the next tree, shape (n,)."""

    @abstractmethod
    def votes(self, people: Array, background: Array) -> Array:
        """Return what each leaf adds to the sum, by the weight of people and of background in it, shape (leaves,)."""


class DiscreteAdaBoost(Boosting):
    """Every tree votes alpha or -alpha; a sample weighs exp(-margin): the original's choice [Dollar2014]."""

    calibration = 0.01  # as the original's INRIA demo
    cascade_threshold = -1.0

    def losses(self, margins: Array) -> Array:
        """Return exp(-margin)."""
        losses: Array = np.exp(-margins)
        return losses

    def weights(self, margins: Array) -> Array:
        """Return exp(-margin)."""
        return self.losses(margins)

    def votes(self, people: Array, background: Array) -> Array:
        """Return alpha = ln((1 - error) / error) / 2, within +-5, with the sign of each leaf's majority."""
        error = float(np.minimum(people, background).sum() / (people + background).sum())
        alpha = LARGEST_ALPHA if error <= 0.0 else min(0.5 * math.log((1.0 - error) / error), LARGEST_ALPHA)
        return np.where(people > background, alpha, -alpha)


class GentleBoost(Boosting):
    """Leaves vote by how pure they are, in small steps; a sample weighs 1 / (1 + exp(2 margin)), never more than 1.

    The votes are those of gentle AdaBoost, the weights those of LogitBoost, both of [Friedman2000].

    With exp(-margin), the few photographs whose background looks most like a person come to outweigh all the others.

    Args:
        step: What a pure leaf adds, in (0, 1].
    """

    calibration = 0.0
    # Early votes are half as large as discrete AdaBoost's: at -1 a window takes twice the trees for the same miss rate.
    cascade_threshold = -0.5

    def __init__(self, step: float = 0.2) -> None:
        if not 0.0 < step <= 1.0:
            raise BadInputError(f"step of boosting is {step}; above 0 and at most 1 would be right")
        self.step = step

    def losses(self, margins: Array) -> Array:
        """Return ln(1 + exp(-2 margin)) / ln 2, which is 1 where the sum says nothing."""
        losses: Array = np.logaddexp(0.0, -2.0 * margins) / math.log(2.0)
        return losses

    def weights(self, margins: Array) -> Array:
        """Return 1 / (1 + exp(2 margin))."""
        weights: Array = np.exp(-np.logaddexp(0.0, 2.0 * margins))
        return weights

    def votes(self, people: Array, background: Array) -> Array:
        """Return step * (people - background) / (people + background)."""
        votes: Array = self.step * (people - background) / np.maximum(people + background, np.finfo(float).tiny)
        return votes


@dataclass(frozen=True)
class Trees:
    """A boosted sum of trees, laid out as in AcfModel.

    Attributes:
        features, thresholds: Of the nodes, the children of node k at 2k + 1 and 2k + 2, shape (trees, 2^depth - 1).
        leaves: From left to right, shape (trees, 2^depth).
    """

    features: Ints
    thresholds: Floats
    leaves: Floats


@dataclass(frozen=True)
class BoostingStep:
    """What the log tells after a tree.

    Attributes:
        tree: Counted from 1.
        error: Weighted training error of this tree.
        vote: Its largest vote; of discrete AdaBoost, alpha.
        loss: Mean loss of the whole sum, both classes weighing the same.
    """

    tree: int
    error: float
    vote: float
    loss: float


def boost(
    data: QuantisedFeatures,
    is_person: NDArray[np.bool_],
    trees: int,
    depth: int,
    boosting: Boosting,
    rng: np.random.Generator,
    report: Callable[[BoostingStep], None],
) -> Trees:
    """Train a sum of trees whose sign tells people from background.

    Both classes have the same total weight at first. It ends early when a tree is no better than chance or nothing is
    left to learn.

    Args:
        data: All samples.
        is_person: Shape (samples,).
        trees: How many at most.
        depth: Of each tree.
        boosting: How samples are weighed and leaves vote.
        rng: Draws the features at each node.
        report: Called after each tree.
    """
    sign = np.where(is_person, 1.0, -1.0)
    share = np.where(is_person, 0.5 / np.count_nonzero(is_person), 0.5 / np.count_nonzero(~is_person))
    total = np.zeros(sign.size)
    features, bin_numbers, leaves = [], [], []
    for number in range(1, trees + 1):
        weights = share * boosting.weights(sign * total)
        weights /= weights.sum()
        tree = fit_tree(data.bins, sign * weights, depth, rng)
        people, background = (_weight_of_leaves(tree, weights * (sign == side)) for side in (1.0, -1.0))
        votes = boosting.votes(people, background)
        if np.abs(votes).max() < SMALLEST_VOTE:
            break
        total += votes[tree.leaf_of_sample]
        features.append(tree.features)
        bin_numbers.append(tree.bin_numbers)
        leaves.append(votes)
        loss = float((share * boosting.losses(sign * total)).sum())
        error = float(np.minimum(people, background).sum())
        report(BoostingStep(number, error, float(np.abs(votes).max()), loss))
        if loss < SMALLEST_LOSS:
            break
    chosen = np.array(features, np.int32).reshape(-1, 2**depth - 1)
    bins = np.array(bin_numbers, np.int32).reshape(chosen.shape)
    return Trees(chosen, data.thresholds(chosen, bins), np.array(leaves, np.float32).reshape(-1, 2**depth))


def _weight_of_leaves(tree: FittedTree, weights: Array) -> Array:
    """Return the sum of the samples' weights in each leaf."""
    sums: Array = np.bincount(tree.leaf_of_sample, weights, len(tree.features) + 1).astype(np.float64)
    return sums
