"""Gaussians and discs on the grid: the windows and shortcuts of the kernels against the plain formulas."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.costmap.grid import INSCRIBED, LETHAL, SOCIAL_MAX, UNKNOWN, Costmap
from han_bullet.costmap.shapes import raise_asym_gauss, raise_disc
from han_bullet.geometry import Array

ROOM = [((-1.0, 7.0), (2.0, 8.0))]  # [m]: 160 x 120 cells
places = st.tuples(st.floats(-2.0, 8.0), st.floats(1.0, 9.0))
deviations = st.floats(0.06, 1.5)


def room(seed: int) -> Costmap:
    """A map of every cost there is, in patches, a good part of it free."""
    costmap = Costmap.covering(ROOM, 0.05)
    values = np.random.default_rng(seed).integers(0, 256, (15, 20)).astype(np.uint8)
    values[values > 200] = 0
    values[0, :4] = SOCIAL_MAX, INSCRIBED, LETHAL, UNKNOWN
    costmap.cost[:] = np.kron(values, np.ones((8, 8), np.uint8))
    return costmap


def centres(costmap: Costmap) -> tuple[Array, Array]:
    rows, columns = costmap.shape
    x = costmap.origin_in_world[0] + (np.arange(columns) + 0.5) * costmap.resolution
    y = costmap.origin_in_world[1] + (np.arange(rows) + 0.5) * costmap.resolution
    return x[None, :], y[:, None]


@settings(max_examples=100, deadline=None)
@given(
    places,
    st.floats(-4.0, 4.0),
    deviations,
    deviations,
    st.one_of(st.just(0.0075), deviations),
    st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.0, 1.0)),
    st.integers(0, 9),
)
def test_a_gaussian_raises_every_cell_of_the_map_to_252_a_g_rounded_and_leaves_blocked_ones(
    place: tuple[float, float], direction: float, ahead: float, side: float, rear: float, amplitude: float, seed: int
) -> None:
    costmap = room(seed)
    before = costmap.cost.copy()
    x, y = centres(costmap)
    dx, dy = x - place[0], y - place[1]
    c, s = math.cos(direction), math.sin(direction)
    u, v = c * dx + s * dy, c * dy - s * dx
    behind = np.inf if rear < 0.05 else (u / rear) ** 2
    g = np.exp(-0.5 * (np.where(u >= 0.0, (u / ahead) ** 2, behind) + (v / side) ** 2))
    raise_asym_gauss(costmap, np.array(place), direction, ahead, side, rear, amplitude)
    exact = SOCIAL_MAX * amplitude * g + 0.5
    expected = np.where(before > SOCIAL_MAX, before, np.maximum(before, exact.astype(np.uint8)))
    # Where 252 g is half a number to the last digits, or u is zero, the order of sums decides.
    doubtful = (np.abs(exact - np.round(exact)) < 1e-7) | (np.abs(u) < 1e-9)
    assert (expected == costmap.cost)[~doubtful].all()
    assert doubtful.sum() <= 0.01 * doubtful.size


@settings(max_examples=100, deadline=None)
@given(places, st.floats(0.0, 3.0), st.sampled_from([227, SOCIAL_MAX, LETHAL]), st.integers(0, 9))
def test_a_disc_raises_the_cells_whose_centres_it_covers(
    place: tuple[float, float], radius: float, value: int, seed: int
) -> None:
    costmap = room(seed)
    x, y = centres(costmap)
    inside = (x - place[0]) ** 2 + (y - place[1]) ** 2 <= radius**2
    expected = np.where(inside, np.maximum(costmap.cost, value), costmap.cost)
    raise_disc(costmap, np.array(place), radius, value)
    assert np.array_equal(costmap.cost, expected)


def test_a_centre_exactly_on_the_circle_belongs_to_the_disc() -> None:
    costmap = Costmap.covering([((0.0, 4.0), (0.0, 4.0))], 0.5)
    raise_disc(costmap, np.array([1.25, 1.25]), 1.0, LETHAL)
    assert (costmap.cost == LETHAL).sum() == 13
    assert costmap.cost_at(np.array([[2.25, 1.25], [1.25, 0.25]])).tolist() == [LETHAL, LETHAL]


@pytest.mark.parametrize("cost", [0, 1, 60, 126, 251, 252])
def test_a_cell_rises_only_nearer_than_where_the_gaussian_gives_what_it_costs_already(
    cost: int,
) -> None:
    costmap = Costmap.covering([((0.0, 8.0), (0.0, 1.0))], 0.05)
    costmap.cost[:] = cost
    centre = costmap.cell_to_world(np.array([10, 100]))
    for nearer, expected in ((1.0 + 1e-6, cost), (1.0 - 1e-6, min(cost + 1, SOCIAL_MAX))):
        reached = math.sqrt(2.0 * math.log(SOCIAL_MAX / (cost + 0.5))) if cost < SOCIAL_MAX else 1.0
        peak = centre - np.array([reached * nearer, 0.0])
        raise_asym_gauss(costmap, peak, 0.0, 1.0, 1.0, 1.0)
        assert costmap.cost[10, 100] == expected
