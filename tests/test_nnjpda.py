"""Association: exact marginals against brute force, and who takes what."""

from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from joint_sums import one_by_one

from han_bullet.errors import BadInputError
from han_bullet.tracking.association import (
    Association,
    Gating,
    GlobalNearestNeighbour,
    NearestNeighbour,
    gate,
)
from han_bullet.tracking.nnjpda import Nnjpda, clusters

NNJPDA = Nnjpda()


def scene(tracks: list[tuple[float, float]], measurements: list[tuple[float, float]], sigma: float = 0.2) -> Gating:
    """Gate tracks and measurements [m] that all have the same deviation [m]."""
    noise = sigma**2 * np.eye(2)
    return gate(
        np.array(tracks, float).reshape(-1, 2),
        np.broadcast_to(noise, (len(tracks), 2, 2)),
        np.array(measurements, float).reshape(-1, 2),
        np.broadcast_to(noise, (len(measurements), 2, 2)),
    )


def brute_force(gating: Gating) -> np.ndarray:
    """Sum the probability of every joint event, one by one."""
    to_miss = Decimal("0.9") / Decimal("0.005") / Decimal("0.109")  # 1 - 0.9 * 0.99
    pairs = one_by_one(
        [
            [to_miss * Decimal(float(density)) if inside else Decimal(0) for density, inside in zip(*row, strict=True)]
            for row in zip(gating.density, gating.inside, strict=True)
        ]
    )
    return np.column_stack([1.0 - pairs.sum(axis=1), pairs])


points = st.lists(st.tuples(st.floats(-0.9, 0.9), st.floats(-0.9, 0.9)), min_size=1, max_size=4)


@settings(max_examples=150, deadline=None)
@given(points, points, st.floats(0.05, 0.5))
def test_marginals_equal_those_of_every_joint_event(
    tracks: list[tuple[float, float]], measurements: list[tuple[float, float]], sigma: float
) -> None:
    gating = scene(tracks, measurements, sigma)
    beta = NNJPDA.marginals(gating)
    assert beta == pytest.approx(brute_force(gating), abs=1e-9)
    assert beta.sum(axis=1) == pytest.approx(np.ones(len(tracks)), abs=1e-12)


@st.composite
def any_gating(draw: st.DrawFn) -> Gating:
    """Up to five tracks and measurements, any of them gated, with densities [1/m^2] that no scene has."""
    shape = draw(st.integers(1, 5)), draw(st.integers(0, 5))
    count = shape[0] * shape[1]
    powers = draw(st.lists(st.one_of(st.floats(-3, 2), st.integers(-320, 300)), min_size=count, max_size=count))
    inside = draw(st.one_of(st.just([True] * count), st.lists(st.booleans(), min_size=count, max_size=count)))
    density = 10.0 ** np.array(powers, float).reshape(shape)
    return Gating(np.ones(shape), density, np.array(inside, bool).reshape(shape))


@settings(max_examples=150, deadline=None)
@given(any_gating())
def test_marginals_of_any_gates_and_densities_equal_those_of_every_joint_event(gating: Gating) -> None:
    beta = NNJPDA.marginals(gating)
    assert beta == pytest.approx(brute_force(gating), abs=1e-9)
    assert (beta[:, 1:][~gating.inside] == 0.0).all()
    for association in (NNJPDA, NearestNeighbour(), GlobalNearestNeighbour()):
        pairs = association.assign(gating)
        assert len({i for i, _ in pairs}) == len({j for _, j in pairs}) == len(pairs)
        assert all(gating.inside[pair] for pair in pairs)


@settings(max_examples=60, deadline=None)
@given(points, points, st.sampled_from([NNJPDA, NearestNeighbour(), GlobalNearestNeighbour()]))
def test_every_association_pairs_each_row_once_and_only_inside_the_gates(
    tracks: list[tuple[float, float]], measurements: list[tuple[float, float]], association: Association
) -> None:
    gating = scene(tracks, measurements)
    pairs = association.assign(gating)
    assert list(pairs) == sorted(pairs)
    assert len({i for i, _ in pairs}) == len({j for _, j in pairs}) == len(pairs)
    assert all(gating.inside[pair] for pair in pairs)


def test_twenty_people_in_a_row_whose_gates_overlap_are_still_summed_exactly() -> None:
    places = [(0.7 * k, 0.0) for k in range(20)]
    gating = scene(places, [(x + 0.05, 0.0) for x, _ in places])
    assert len(clusters(gating.inside)) == 1
    beta = NNJPDA.marginals(gating)
    assert beta.sum(axis=1) == pytest.approx(np.ones(20), abs=1e-12)
    assert NNJPDA.assign(gating) == tuple((k, k) for k in range(20))
    # Column sums: no measurement belongs to more than one person.
    assert beta[:, 1:].sum(axis=0).max() <= 1.0 + 1e-12


def test_people_far_apart_are_separate_clusters() -> None:
    groups = clusters(scene([(0, 0), (5, 0), (5.5, 0)], [(0.1, 0), (5.2, 0), (9, 0)]).inside)
    assert [(g.tolist(), m.tolist()) for g, m in groups] == [([0], [0]), ([1, 2], [1])]


def test_a_measurement_more_than_a_metre_away_is_nobodys_even_of_a_very_uncertain_track() -> None:
    gating = scene([(0, 0)], [(1.05, 0), (0.95, 0)], sigma=2.0)
    assert gating.squared_mahalanobis.max() < 9.21
    assert gating.inside.tolist() == [[False, True]]


def test_a_measurement_beyond_the_mahalanobis_gate_is_nobodys_even_when_close() -> None:
    gating = scene([(0, 0)], [(0.5, 0)], sigma=0.1)
    assert gating.squared_mahalanobis[0, 0] == pytest.approx(12.5)
    assert not gating.inside.any()
    for association in (NNJPDA, NearestNeighbour(), GlobalNearestNeighbour()):
        assert association.assign(gating) == ()


def test_a_pair_less_probable_than_no_measurement_does_not_stand() -> None:
    # At 2.9 deviations of 0.2 m the density is 0.06 per square metre; with one false positive per square metre,
    # "missed" (0.109) outweighs 0.9 * 0.06.
    gating = scene([(0, 0)], [(0.58, 0)], sigma=0.2 / np.sqrt(2))
    assert gating.inside.all()
    crowded = Nnjpda(clutter_density=1.0)
    assert crowded.marginals(gating)[0, 1] < crowded.marginals(gating)[0, 0]
    assert crowded.assign(gating) == ()
    assert GlobalNearestNeighbour(clutter_density=1.0).assign(gating) == ()
    assert GlobalNearestNeighbour().assign(gating) == ((0, 0),)
    assert NNJPDA.assign(gating) == ((0, 0),)


def test_the_nearest_neighbour_takes_what_another_needs_and_the_joint_rules_do_not() -> None:
    # Track 0 lies a little closer to measurement 0, which is the only one that track 1 can have.
    gating = scene([(0.0, 0.0), (0.75, 0.0)], [(0.36, 0.0), (-0.40, 0.0)])
    assert gating.inside.tolist() == [[True, True], [True, False]]
    assert NearestNeighbour().assign(gating) == ((0, 0),)
    assert GlobalNearestNeighbour().assign(gating) == ((0, 1), (1, 0))
    assert NNJPDA.assign(gating) == ((0, 1), (1, 0))


def test_the_pairs_of_most_events_are_not_always_those_of_the_likeliest_event() -> None:
    """Of three ways to give each their own, everybody the first is the likeliest, but the two others share a pair."""
    density = np.array([[1.0, 0.9, 0.0], [0.9, 1.0, 0.9], [0.9, 0.0, 1.0]])
    gating = Gating(np.ones((3, 3)), density, density > 0.0)
    assert GlobalNearestNeighbour().assign(gating) == ((0, 0), (1, 1), (2, 2))
    # Without the few events in which somebody is missed: 1 of 2.539, and 0.81 + 0.729.
    assert NNJPDA.marginals(gating)[0, 1:3] == pytest.approx([1.0 / 2.539, 1.539 / 2.539], abs=0.01)
    assert NNJPDA.assign(gating) == ((0, 1), (1, 0), (2, 2))


def test_without_tracks_or_measurements_there_are_no_pairs() -> None:
    for association in (NNJPDA, NearestNeighbour(), GlobalNearestNeighbour()):
        assert association.assign(scene([], [(0, 0)])) == ()
        assert association.assign(scene([(0, 0)], [])) == ()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("clutter_density", 0.0),
        ("detection_probability", 0.0),
        ("detection_probability", 1.01),
        ("clutter_density", -1.0),
    ],
)
def test_a_density_or_probability_that_has_no_weight_is_refused(name: str, value: float) -> None:
    for association in (Nnjpda, NearestNeighbour, GlobalNearestNeighbour):
        with pytest.raises(BadInputError, match=f"association: {name} is {value}; it must be"):
            association(**{name: value})
