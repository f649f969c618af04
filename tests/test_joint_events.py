"""Sums over all joint events: exact against counting them one by one, and never too many of them."""

import math
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from joint_sums import one_by_one

from benchmarks.crowd import record
from benchmarks.tracker import ours
from han_bullet.tracking import joint_events
from han_bullet.tracking.association import gate
from han_bullet.tracking.joint_events import MOST_SUMS, Sweep, pair_probabilities, plan, thinned
from han_bullet.tracking.kalman import ConstantVelocity

# Decimal exponents of ratios from 1e-300 to 1e300, many of them alike; None is outside the gates.
exponents = st.one_of(st.none(), st.floats(-2.0, 2.0), st.integers(-300, 300), st.sampled_from([-300, 0, 300]))


@st.composite
def clusters(draw: st.DrawFn) -> list[list[float | None]]:
    rows, columns = draw(st.integers(1, 5)), draw(st.integers(1, 5))
    return [[draw(exponents) for _ in range(columns)] for _ in range(rows)]


def brute_force(powers: list[list[float | None]]) -> np.ndarray:
    return one_by_one([[Decimal(0) if p is None else Decimal(10) ** Decimal(p) for p in row] for row in powers])


def logarithms(powers: list[list[float | None]]) -> np.ndarray:
    return np.array([[-math.inf if p is None else p * math.log(10.0) for p in row] for row in powers])


@settings(max_examples=120, deadline=None)
@given(clusters())
def test_pairs_are_as_probable_as_in_all_events_one_by_one_however_large_or_small_the_ratios(
    powers: list[list[float | None]],
) -> None:
    assert pair_probabilities(logarithms(powers)) == pytest.approx(brute_force(powers), abs=1e-9)


@pytest.mark.parametrize("power", [-300, -1, 0, 1, 300])
def test_five_tracks_that_share_all_of_five_measurements_are_summed_exactly(power: int) -> None:
    rng = np.random.default_rng(power + 300)
    powers = (power + rng.uniform(-3.0, 3.0, (5, 5))).tolist()
    exact = brute_force(powers)
    assert exact.max() > (0.0 if power < 0 else 0.2)
    assert pair_probabilities(logarithms(powers)) == pytest.approx(exact, abs=1e-9, rel=1e-9)


def test_three_tracks_that_all_want_the_same_measurement_very_much_have_it_in_a_third_of_the_events() -> None:
    """All floats but the largest product vanish here: 1e300 to the power of one, of three tracks."""
    assert pair_probabilities(np.full((3, 1), 300.0 * math.log(10.0))) == pytest.approx(np.full((3, 1), 1.0 / 3.0))
    assert pair_probabilities(np.full((3, 2), 300.0 * math.log(10.0))) == pytest.approx(np.full((3, 2), 1.0 / 3.0))
    assert pair_probabilities(np.full((40, 2), 300.0 * math.log(10.0))) == pytest.approx(np.full((40, 2), 1.0 / 40.0))


def test_tracks_and_measurements_are_interchangeable() -> None:
    log_ratios = np.random.default_rng(4).normal(0.0, 3.0, (7, 3))
    assert np.array_equal(pair_probabilities(log_ratios), pair_probabilities(log_ratios.T).T)


@pytest.mark.parametrize("size", [8, 10, 12, 14])
def test_large_clusters_in_which_all_pairs_are_alike_have_the_probability_of_the_closed_form(size: int) -> None:
    """C(n, k)^2 k! events have k pairs; each of the n^2 pairs is in k of n^2 of them."""
    ratio = 0.7
    events = [math.comb(size, k) ** 2 * math.factorial(k) * ratio**k for k in range(size + 1)]
    one = sum(k * weight for k, weight in enumerate(events)) / sum(events) / size**2
    assert plan(np.ones((size, size), bool)).sums <= MOST_SUMS
    assert pair_probabilities(np.full((size, size), math.log(ratio))) == pytest.approx(one, rel=1e-12)


@pytest.fixture
def planned(monkeypatch: pytest.MonkeyPatch) -> list[Sweep]:
    """All sweeps that are made from here on."""
    sweeps: list[Sweep] = []
    monkeypatch.setattr(joint_events, "plan", lambda possible: sweeps.append(plan(possible)) or sweeps[-1])
    return sweeps


@pytest.mark.parametrize("acceleration", [0.3, 1.5])
def test_twenty_people_in_five_metres_square_need_no_more_than_two_hundred_partial_sums(
    acceleration: float, planned: list[Sweep]
) -> None:
    """One event at a time, the largest of these clusters, 5 of each, would be a thousand; of 8 and 7, ten thousands."""
    recording = record(20, 5.0, 10.0, seed=1)
    step = ours("nnjpda", ConstantVelocity(acceleration_deviation=acceleration))(recording)
    for k in range(100):
        step(k)
    assert len(planned) > 100 and max(len(sweep.order) for sweep in planned) >= 5
    assert max(sweep.sums for sweep in planned) <= 200


def packed(rng: np.random.Generator) -> np.ndarray:
    """Return which of twenty people, half a metre apart in four rows of five, may have which measurement.

    Each is known to 0.2 m, as after 1.6 s without a hit, and so has four or five measurements to choose from.
    """
    places = rng.permutation(0.5 * np.array([(x, y) for x in range(5) for y in range(4)], float))
    tracks, noise = (np.tile(deviation**2 * np.eye(2), (20, 1, 1)) for deviation in (0.2, 0.1))
    return gate(places, tracks, places + rng.normal(0.0, 0.1, places.shape), noise).inside


def test_a_packed_crowd_whose_tracks_are_all_uncertain_is_still_summed_exactly() -> None:
    for seed in range(10):
        inside = packed(np.random.default_rng(seed))
        assert inside.sum(axis=1).mean() > 4.0
        assert plan(inside).sums <= MOST_SUMS


def test_people_in_a_line_are_swept_from_end_to_end_in_whatever_order_they_came() -> None:
    neighbours = np.abs(np.arange(40)[:, None] - np.arange(40)) <= 1
    for seed in range(10):
        rng = np.random.default_rng(seed)
        shuffled = neighbours[rng.permutation(40)][:, rng.permutation(40)]
        assert plan(shuffled).width <= 4


def test_nobodys_measurement_and_one_that_a_single_track_wants_cost_nothing() -> None:
    possible = np.array([[1, 1, 0, 0, 0], [1, 0, 1, 1, 0], [1, 0, 0, 0, 0]], bool)
    assert plan(possible).width == 1
    assert plan(possible).sums == 8


def test_few_tracks_among_many_measurements_need_few_sums_and_so_do_many_tracks_of_few(planned: list[Sweep]) -> None:
    pair_probabilities(np.zeros((3, 18)))
    pair_probabilities(np.zeros((18, 3)))
    assert [sweep.sums for sweep in planned] == [19 << 3] * 2


@pytest.mark.parametrize(("size", "exact"), [(14, True), (15, False), (20, False), (70, False)])
def test_a_cluster_beyond_the_limit_is_thinned_until_it_needs_no_more_than_that(
    size: int, exact: bool, planned: list[Sweep]
) -> None:
    log_ratios = np.random.default_rng(0).normal(0.0, 3.0, (size, size)) + 12.0 * np.eye(size)
    probabilities = pair_probabilities(log_ratios)
    assert (len(planned) == 1) is exact
    assert planned[-1].sums <= MOST_SUMS and (exact or planned[-2].sums > MOST_SUMS)
    assert probabilities.sum(axis=0).max() <= 1.0 + 1e-12 and probabilities.sum(axis=1).max() <= 1.0 + 1e-12
    assert np.trace(probabilities) > 0.8 * size


def test_what_is_left_of_a_thinned_cluster_is_close_to_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten people half a metre from each other in a ring: pairs of those opposite are as good as impossible."""
    angles = 2.0 * math.pi * np.arange(10) / 10
    places = np.column_stack([np.cos(angles), np.sin(angles)]) * 0.8
    squared = ((places[:, None] - places[None]) ** 2).sum(axis=2) / 0.15**2
    log_ratios = 3.0 - 0.5 * squared
    whole = pair_probabilities(log_ratios)
    monkeypatch.setattr(joint_events, "MOST_SUMS", 2000)
    assert plan(log_ratios > -math.inf).sums > 10_000
    assert pair_probabilities(log_ratios) == pytest.approx(whole, abs=1e-6)


def test_thinning_takes_the_tenth_of_the_pairs_that_lies_farthest_behind_its_rows_best() -> None:
    log_ratios = np.arange(20.0).reshape(4, 5) * np.array([[1.0], [-1.0], [1.0], [2.0]])
    left = thinned(log_ratios)
    # The best are at columns 4, 0, 4, 4; of the 16 others two go, those 8 and 6 behind.
    assert np.argwhere(left == -math.inf).tolist() == [[3, 0], [3, 1]]
    assert np.array_equal(left[left > -math.inf], log_ratios[left > -math.inf])
    for _ in range(40):
        left = thinned(left)
    assert np.isfinite(left).sum(axis=1).tolist() == [1, 1, 1, 1]
