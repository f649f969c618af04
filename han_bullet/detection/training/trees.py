"""Decision trees on quantised features, fitted to weighted samples: what boosting adds up [Dollar2014]."""

from __future__ import annotations

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

    def thresholds(self, features: Ints, bin_numbers: Ints) -> Floats:
        """Return the values half-way between bins and the next ones, one per feature."""
        return self.lowest[features] + self.step[features] * (bin_numbers + np.float32(0.5))


def quantise(samples: Floats) -> QuantisedFeatures:
    """Return the bin numbers of samples, shape (n, features)."""
    lowest = samples.min(axis=0) - np.float32(QUANTISATION_MARGIN)
    step = (samples.max(axis=0) + np.float32(QUANTISATION_MARGIN) - lowest) / np.float32(BINS - 1)
    bins = np.empty(samples.shape[::-1], np.uint8)
    for start in range(0, samples.shape[0], 512):  # in blocks: a second float copy of all samples would be large
        block = samples[start : start + 512]
        bins[:, start : start + 512] = np.rint((block - lowest) / step).T
    return QuantisedFeatures(bins, lowest, step)


@dataclass(frozen=True)
class FittedTree:
    """A complete tree: the children of node k are 2k + 1 (left) and 2k + 2 (right).

    Attributes:
        features: Of the nodes, shape (2^depth - 1,).
        bin_numbers: Of the nodes: a value in this bin or below goes left, shape (2^depth - 1,).
        leaf_of_sample: Number of the leaf, from left to right, that each sample ends in, shape (samples,).
    """

    features: Ints
    bin_numbers: Ints
    leaf_of_sample: NDArray[np.int64]


def fit_tree(bins: Bins, signed: Array, depth: int, rng: np.random.Generator) -> FittedTree:
    """Fit a tree that parts people from background, node by node, each over freshly drawn features.

    Args:
        bins: Of all samples, shape (features, samples).
        signed: Weight of each sample, people's positive and background's negative, shape (samples,).
        depth: How many comparisons lead to a leaf.
        rng: Draws the features.
    """
    nodes = 2**depth - 1
    features, bin_numbers = np.zeros(nodes, np.int32), np.zeros(nodes, np.int32)
    total = float(np.abs(signed).sum())
    members = {0: np.arange(signed.size, dtype=np.int32)}
    for node in range(nodes):
        here = members.pop(node)
        features[node], bin_numbers[node] = _split_node(bins, here, signed, total, rng)
        right = bins[features[node], here] > bin_numbers[node]
        members[2 * node + 1], members[2 * node + 2] = here[~right], here[right]
    leaf_of_sample = np.empty(signed.size, np.int64)
    for node, here in members.items():
        leaf_of_sample[here] = node - nodes
    return FittedTree(features, bin_numbers, leaf_of_sample)


def _split_node(bins: Bins, members: Ints, signed: Array, total: float, rng: np.random.Generator) -> tuple[int, int]:
    """Return feature and bin of the best split of some samples, or of one that sends all of them left."""
    drawn = rng.choice(bins.shape[0], max(int(bins.shape[0] * FEATURE_SHARE), 1), replace=False, shuffle=False)
    here = signed[members]
    weight = float(np.abs(here).sum())
    people = float(here[here > 0.0].sum())
    if weight < SMALLEST_WEIGHT * total or min(people, weight - people) < PUREST_NODE * weight:
        return int(drawn[0]), BINS - 1
    feature, bin_number = best_split(bins, drawn.astype(np.int32), members, signed, weight - people, weight)
    return int(feature), int(bin_number)


@numba.njit(cache=True)
def best_split(
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
