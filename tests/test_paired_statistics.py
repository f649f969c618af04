"""Paired comparisons: hand-made numbers, known coverage, agreement with textbook intervals."""

import numpy as np
import pytest
from scipy.stats import t

from han_bullet import paired_statistics
from han_bullet.paired_statistics import FEWEST_PAIRS, Interval, compare, share_interval


def by_seed(values: object) -> dict[int, float]:
    return {seed: float(value) for seed, value in enumerate(np.asarray(values))}


def test_means_are_taken_over_the_common_seeds_alone() -> None:
    found = compare({0: 1.0, 1: 3.0, 7: 100.0}, {0: 2.0, 1: 2.0, 5: -40.0})
    assert found is not None
    assert (found.pairs, found.mean, found.baseline_mean, found.difference, found.ratio) == (2, 2.0, 2.0, 0.0, 1.0)


def test_without_a_common_seed_there_is_no_comparison() -> None:
    assert compare({0: 1.0}, {1: 1.0}) is None


def test_too_few_pairs_give_no_interval() -> None:
    values = np.arange(1.0, 1.0 + FEWEST_PAIRS)
    few, enough = compare(by_seed(values[:-1]), by_seed(values[:-1] ** 2)), compare(by_seed(values), by_seed(values**2))
    assert few is not None and few.interval is None and few.ratio_interval is None and not few.is_clear
    assert enough is not None and enough.interval is not None and enough.ratio_interval is not None


def test_what_a_hard_seed_does_to_both_variants_cancels() -> None:
    rng = np.random.default_rng(3)
    hardness = 100.0 * rng.uniform(size=12)
    found = compare(by_seed(hardness + 1.0 + 0.1 * rng.normal(size=12)), by_seed(hardness))
    assert found is not None and found.interval is not None and found.is_clear
    assert 0.9 < found.interval.low < 1.0 < found.interval.high < 1.1


def test_equal_differences_give_a_point_and_equal_pairs_say_so() -> None:
    shifted, same = (
        compare(by_seed([1, 2, 4, 5, 9, 7]), by_seed([0, 1, 3, 4, 8, 6])),
        compare(by_seed([1] * 6), by_seed([1] * 6)),
    )
    assert shifted is not None and shifted.interval == Interval(1.0, 1.0) and shifted.is_clear and not shifted.equal
    assert same is not None and same.interval == Interval(0.0, 0.0) and same.equal and not same.is_clear


def test_the_same_numbers_give_the_same_interval_every_time() -> None:
    rng = np.random.default_rng(0)
    ours, theirs = by_seed(rng.normal(size=9)), by_seed(rng.normal(size=9))
    assert compare(ours, theirs) == compare(ours, theirs)


def test_many_normal_differences_give_the_interval_of_student() -> None:
    differences = np.random.default_rng(1).normal(0.3, 1.0, 400)
    found = compare(by_seed(differences), by_seed(np.zeros(400)))
    assert found is not None and found.interval is not None
    half = t.ppf(0.975, 399) * differences.std(ddof=1) / 20.0
    assert found.interval.low == pytest.approx(differences.mean() - half, abs=0.05 * half)
    assert found.interval.high == pytest.approx(differences.mean() + half, abs=0.05 * half)


def test_intervals_hold_the_true_difference_as_often_as_they_say(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(paired_statistics, "RESAMPLES", 1000)
    rng, held = np.random.default_rng(2), 0
    for _ in range(300):
        theirs = rng.gamma(4.0, size=25)
        found = compare(by_seed(theirs + rng.normal(0.5, 0.8, 25)), by_seed(theirs))
        assert found is not None and found.interval is not None
        held += found.interval.holds(0.5)
    assert 0.91 <= held / 300 <= 0.98  # 95 %, give or take three standard errors of 300 trials


def test_a_ratio_needs_a_positive_baseline_and_its_interval_one_without_zeros() -> None:
    ours = by_seed([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    assert (nothing := compare(ours, by_seed(np.zeros(6)))) is not None and nothing.ratio is None
    assert (negative := compare(ours, by_seed([-1.0, 9, 9, 9, 9, 9]))) is not None and negative.ratio is None
    assert (some := compare(ours, by_seed([0.0, 1, 1, 1, 1, 1]))) is not None and some.ratio_interval is None
    assert some.ratio == pytest.approx(3.5 / (5.0 / 6.0))
    assert (double := compare(ours, by_seed([0.5, 1.0, 1.5, 2.0, 2.5, 3.0]))) is not None
    assert double.ratio == 2.0 and double.ratio_interval == Interval(2.0, 2.0)


def test_shares_of_variants_that_always_and_sometimes_pass() -> None:
    found = compare(by_seed([1] * 10), by_seed([1, 0] * 5))
    assert found is not None and found.interval is not None
    assert found.difference == 0.5 and 0.1 <= found.interval.low <= 0.3 and 0.7 <= found.interval.high <= 0.9


def test_wilsons_interval_of_shares_is_that_of_the_textbook() -> None:
    z2 = 1.959964**2
    ten = share_interval(10, 10)
    assert ten.low == pytest.approx(10.0 / (10.0 + z2), abs=1e-6) and ten.high == pytest.approx(1.0)
    none = share_interval(0, 10)
    assert none.low == pytest.approx(0.0, abs=1e-12) and none.high == pytest.approx(z2 / (10.0 + z2), abs=1e-6)
    half = share_interval(5, 10)
    assert (half.low, half.high) == pytest.approx((0.2366, 0.7634), abs=1e-4)
