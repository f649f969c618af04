"""What seeds that two variants share tell of their difference: paired means with bootstrap intervals; shares.

A seed decides starts, speeds, delays and light alike in both variants, so differences are taken seed by seed: what a
hard seed does to both cancels.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.stats import binomtest, bootstrap

from han_bullet.geometry import Array

CONFIDENCE = 0.95
RESAMPLES = 10_000
FEWEST_PAIRS = 6  # with five, chance alone leaves zero out in one interval of six
SEED = 2019  # of the resampling; any number, always the same


@dataclass(frozen=True)
class Interval:
    """A 95 % confidence interval.

    Attributes:
        low: Its lower end.
        high: Its upper end.
    """

    low: float
    high: float

    def holds(self, value: float) -> bool:
        """Tell whether a value lies within, ends included."""
        return self.low <= value <= self.high


@dataclass(frozen=True)
class Comparison:
    """A variant against a baseline over common seeds.

    Attributes:
        pairs: How many seeds both have.
        mean: Of the variant over these.
        baseline_mean: Of the baseline over these.
        difference: Mean of variant less baseline.
        interval: Of the difference; None with fewer than `FEWEST_PAIRS` pairs.
        ratio: `mean` over `baseline_mean`; None where that is not positive.
        ratio_interval: Of the ratio; None where it has none.
        equal: Whether variant and baseline are the same in every pair.
    """

    pairs: int
    mean: float
    baseline_mean: float
    difference: float
    interval: Interval | None
    ratio: float | None
    ratio_interval: Interval | None
    equal: bool

    @property
    def is_clear(self) -> bool:
        """Tell whether the interval of the difference leaves zero out."""
        return self.interval is not None and not self.interval.holds(0.0)


def share_interval(count: int, total: int) -> Interval:
    """Return Wilson's score interval of a share [Wilson1927].

    Args:
        count: How many of them, 0 to `total`.
        total: At least 1.
    """
    found = binomtest(count, total).proportion_ci(CONFIDENCE, method="wilson")
    return Interval(float(found.low), float(found.high))


def compare(values: Mapping[int, float], baseline: Mapping[int, float]) -> Comparison | None:
    """Compare a figure over the seeds that two variants share.

    The intervals are bias-corrected and accelerated bootstrap intervals [Efron1987] over pairs.

    Args:
        values: Of the variant, by seed.
        baseline: Of the baseline, by seed.

    Returns:
        The comparison, or None where no seed is common.
    """
    seeds = sorted(values.keys() & baseline.keys())
    if not seeds:
        return None
    ours = np.array([values[seed] for seed in seeds], float)
    theirs = np.array([baseline[seed] for seed in seeds], float)
    mean, baseline_mean = float(ours.mean()), float(theirs.mean())
    enough = len(seeds) >= FEWEST_PAIRS
    has_ratio = baseline_mean > 0.0 and (ours >= 0.0).all() and (theirs >= 0.0).all()
    # Where few seeds give anything but zero, resamples divide by zero: the ratio then goes without an interval.
    steady = has_ratio and (theirs > 0.0).all()
    return Comparison(
        len(seeds),
        mean,
        baseline_mean,
        float((ours - theirs).mean()),
        _interval(_mean_difference, ours, theirs) if enough else None,
        mean / baseline_mean if has_ratio else None,
        _interval(_ratio, ours, theirs) if enough and steady else None,
        bool((ours == theirs).all()),
    )


def _mean_difference(ours: Array, theirs: Array, axis: int = -1) -> Array:
    difference: Array = np.mean(ours - theirs, axis=axis)
    return difference


def _ratio(ours: Array, theirs: Array, axis: int = -1) -> Array:
    ratio: Array = np.mean(ours, axis=axis) / np.mean(theirs, axis=axis)
    return ratio


def _interval(statistic: Callable[..., Array], ours: Array, theirs: Array) -> Interval:
    """Return the bootstrap interval of a paired statistic; a point where leaving out any pair leaves it as it is."""
    pairs = np.arange(len(ours))
    jackknife = np.array([statistic(*(np.delete(side, pair) for side in (ours, theirs))) for pair in pairs])
    if np.ptp(jackknife) <= 1e-12 * (1.0 + np.abs(jackknife).max()):
        return Interval(float(statistic(ours, theirs)), float(statistic(ours, theirs)))
    found = bootstrap(
        (ours, theirs),
        statistic,
        paired=True,
        vectorized=True,
        n_resamples=RESAMPLES,
        confidence_level=CONFIDENCE,
        method="BCa",
        random_state=np.random.default_rng(SEED),
    ).confidence_interval
    return Interval(float(found.low), float(found.high))
