"""Discrete AdaBoost of depth-2 trees on quantised features [Dollar2014], [Friedman2000]."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.cascade import Ints
from han_bullet.detection.channels import Floats
from han_bullet.geometry import Array

BINS = 256
QUANTISATION_MARGIN = 0.01  # below the smallest and above the largest value of a feature
FEATURE_SHARE = 1 / 16  # of the features drawn anew at every node
SMALLEST_WEIGHT = 0.01  # share of all weight below which a node is not split
PUREST_NODE = 1e-3  # share of the rarer class below which a node is not split
LARGEST_ALPHA = 5.0
SMALLEST_ALPHA = 1e-9  # a smaller vote is rounding: the tree is no better than chance
SMALLEST_LOSS = 1e-40

Bins = NDArray[np.uint8]


@dataclass(frozen=True)
class QuantisedFeatures:
    """Features of all samples as bin numbers.

    Attributes:
        bins: Shape (features, samples).
        lowest, step: Value at bin 0 and width of a bin, shape (features,).
    """

    bins: Bins
    lowest: Floats
    step: Floats

    def threshold(self, feature: int, bin_number: int) -> float:
        """Return the value half-way between a bin and the next."""
        return float(self.lowest[feature] + self.step[feature] * (bin_number + 0.5))


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
        alpha: Its vote.
        loss: Exponential loss of the whole sum.
    """

    tree: int
    error: float
    alpha: float
    loss: float


@dataclass(frozen=True)
class _Split:
    """One node: value bin <= bin_number goes left; without a feature everything goes left."""

    feature: int
    bin_number: int


def quantise(samples: Floats) -> QuantisedFeatures:
    """Return the bin numbers of samples, shape (n, features)."""
    lowest = samples.min(axis=0) - np.float32(QUANTISATION_MARGIN)
    step = (samples.max(axis=0) + np.float32(QUANTISATION_MARGIN) - lowest) / np.float32(BINS - 1)
    bins = np.empty(samples.shape[::-1], np.uint8)
    for start in range(0, samples.shape[0], 512):  # in blocks: a second float copy of all samples would be large
        block = samples[start : start + 512]
        bins[:, start : start + 512] = np.rint((block - lowest) / step).T
    return QuantisedFeatures(bins, lowest, step)


def boost(
    data: QuantisedFeatures,
    is_person: NDArray[np.bool_],
    trees: int,
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
        rng: Draws the features at each node.
        report: Called after each tree.
    """
    sign = np.where(is_person, 1.0, -1.0)
    share = np.where(is_person, 0.5 / np.count_nonzero(is_person), 0.5 / np.count_nonzero(~is_person))
    total = np.zeros(sign.size)
    features, thresholds, leaves = [], [], []
    for number in range(1, trees + 1):
        weights = share * np.exp(-sign * total)
        weights /= weights.sum()
        splits, votes, leaf_of_sample = _fit_tree(data.bins, sign, weights, rng)
        answer = votes[leaf_of_sample]
        error = float(weights[answer != sign].sum())
        alpha = _vote(error)
        if alpha < SMALLEST_ALPHA:
            break
        total += alpha * answer
        features.append([split.feature for split in splits])
        thresholds.append([data.threshold(split.feature, split.bin_number) for split in splits])
        leaves.append(alpha * votes)
        loss = float((share * np.exp(-sign * total)).sum())
        report(BoostingStep(number, error, alpha, loss))
        if loss < SMALLEST_LOSS:
            break
    shape = (-1, 3)
    return Trees(
        np.array(features, np.int32).reshape(shape),
        np.array(thresholds, np.float32).reshape(shape),
        np.array(leaves, np.float32).reshape(-1, 4),
    )


def _vote(error: float) -> float:
    """Return alpha = ln((1 - error) / error) / 2, within +-5."""
    if error <= 0.0:
        return LARGEST_ALPHA
    return min(max(0.5 * math.log((1.0 - error) / error), -LARGEST_ALPHA), LARGEST_ALPHA)


def _fit_tree(
    bins: Bins, sign: Array, weights: Array, rng: np.random.Generator
) -> tuple[list[_Split], Array, NDArray[np.int64]]:
    """Return the three nodes, the four leaves' signs and each sample's leaf."""
    signed = sign * weights
    everyone = np.arange(sign.size, dtype=np.int32)
    root = _split_node(bins, everyone, signed, rng)
    goes_right = bins[root.feature] > root.bin_number
    leaf_of_sample = np.where(goes_right, 2, 0)
    splits = [root]
    for side in (False, True):
        members = everyone[goes_right == side]
        child = _split_node(bins, members, signed, rng)
        splits.append(child)
        leaf_of_sample[members] += bins[child.feature, members] > child.bin_number
    balance = np.bincount(leaf_of_sample, weights=signed, minlength=4)
    votes = np.where(balance > 0.0, 1.0, -1.0)
    return splits, votes, leaf_of_sample


def _split_node(bins: Bins, members: Ints, signed: Array, rng: np.random.Generator) -> _Split:
    """Return the best split of some samples over freshly drawn features, or one that sends all of them left."""
    drawn = rng.choice(bins.shape[0], max(int(bins.shape[0] * FEATURE_SHARE), 1), replace=False, shuffle=False)
    here = signed[members]
    weight = float(np.abs(here).sum())
    people = float(here[here > 0.0].sum())
    if weight < SMALLEST_WEIGHT or min(people, weight - people) < PUREST_NODE * weight:
        return _Split(int(drawn[0]), BINS - 1)
    feature, bin_number = _best_split(bins, drawn.astype(np.int32), members, signed, weight - people, weight)
    return _Split(int(feature), int(bin_number))


@numba.njit(cache=True)
def _best_split(
    bins: Bins, drawn: Ints, members: Ints, signed: Array, background: float, weight: float
) -> tuple[int, int]:
    """Return the feature and the bin with the smallest weighted error, either side being the people's."""
    best_error, best_feature, best_bin = np.inf, 0, BINS - 1
    histogram = np.empty(BINS, np.float64)
    values = signed[members]
    for feature in drawn:
        row = bins[feature]
        histogram[:] = 0.0
        for place in range(members.size):
            histogram[row[members[place]]] += values[place]
        # Calling the left side background is wrong for the people on it and for the background on the other.
        error = background
        for bin_number in range(BINS - 1):
            error += histogram[bin_number]
            smaller = min(error, weight - error)
            if smaller < best_error:
                best_error, best_feature, best_bin = smaller, feature, bin_number
    return best_feature, best_bin
