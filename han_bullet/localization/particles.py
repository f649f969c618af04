"""Weighted samples of a pose: drawn anew where the weight is, as many as their spread asks for."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array

BIN = np.array([0.25, 0.25, math.radians(15.0)])  # [m], [m], [rad]
ERROR, QUANTILE = 0.05, 2.33  # KLD sampling: the samples' distribution is this near with a probability of 99 %


def effective_count(weights: Array) -> float:
    """Return how many samples of equal weight would be worth as much, from weights, (n,), that sum to 1."""
    return 1.0 / float(weights @ weights)


def tempered(weights: Array, logs: Array, power: float, least: float) -> Array:
    """Return weights times likelihood^power, (n,), summing to 1; with less power where few samples would have it all.

    A sample that happens to be near one of several places that are equally likely would else outdo the others.

    Args:
        weights: Before, shape (n,).
        logs: Log-likelihoods, shape (n,).
        power: At most.
        least: How many samples the weights are to be worth, if they were so before.
    """
    low, high = 0.0, power
    found = _normalized(weights * np.exp(power * (logs - logs.max())))
    for _ in range(12):
        if low == 0.0 and high == power and effective_count(found) >= least:
            return found
        middle = 0.5 * (low + high)
        found = _normalized(weights * np.exp(middle * (logs - logs.max())))
        low, high = (middle, high) if effective_count(found) >= least else (low, middle)
    return _normalized(weights * np.exp(low * (logs - logs.max())))


def _normalized(weights: Array) -> Array:
    normalized: Array = weights / weights.sum()
    return normalized


def sufficient_count(poses: Array, least: int, most: int) -> int:
    """Return how many samples represent a distribution that fills as many bins as these poses, (n, 3), do.

    With k bins, chi-square quantiles in the Wilson-Hilferty approximation [Fox2003]:
    n = (k - 1) / (2 error) (1 - a + sqrt(a) quantile)^3, a = 2 / (9 (k - 1)).
    """
    bins = len(np.unique(np.floor(poses / BIN).astype(np.int64), axis=0))
    if bins < 2:
        return least
    a = 2.0 / (9.0 * (bins - 1))
    count = (bins - 1) / (2.0 * ERROR) * (1.0 - a + math.sqrt(a) * QUANTILE) ** 3
    return min(max(math.ceil(count), least), most)


def drawn(weights: Array, count: int, generator: np.random.Generator) -> NDArray[np.int64]:
    """Return the indices of samples drawn by their weights, (n,), with low variance: one random number for all."""
    at = (np.arange(count) + generator.random()) / count
    return _places(np.cumsum(weights), at)


@numba.njit(cache=True)
def _places(cumulated: Array, at: Array) -> NDArray[np.int64]:
    found, i = np.empty(len(at), np.int64), 0
    for k in range(len(at)):
        while i < len(cumulated) - 1 and cumulated[i] < at[k]:
            i += 1
        found[k] = i
    return found
