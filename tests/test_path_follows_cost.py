"""The way follows the costs: a law of optimal ways, on random scenes and on one scene for each layer."""

import itertools
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from benchmarks import path_follows_cost
from benchmarks.path_follows_cost import (
    AMPLITUDES,
    CASES,
    COUCH,
    RESOLUTION,
    TELEVISION,
    WEIGHT,
    best_way,
    blocked_map,
    exposure,
    exposure_to_layer,
    length,
)
from han_bullet.costmap.grid import INSCRIBED, SOCIAL_MAX, Costmap
from han_bullet.costmap.layers import standard_layers
from han_bullet.geometry import Array, Pose2D, SolidBox
from han_bullet.messages import GoTo, Posture, Scene, TrackedPerson
from han_bullet.planning.astar import AStar

FLOOR = [((0.0, 7.0), (0.0, 7.0))]
COARSE = 0.1  # [m]
START, GOAL = np.array([0.75, 3.55]), np.array([6.25, 3.55])
EQUAL = 1e-6  # [m]: sums in another order
TURN = (2.0 * np.sqrt(2.0) - 2.0) * RESOLUTION  # [m]: by how much two diagonal steps are longer than two straight ones
SOCIAL = ("personal_walking", "personal_still", "visibility", "interaction", "overtake", "oncoming")


def random_scene(seed: int) -> tuple[list[SolidBox], Scene]:
    """Up to three boxes and four people of any posture."""
    rng = np.random.default_rng(seed)
    boxes = [
        SolidBox(
            "box", "object", np.array([*rng.uniform(1.5, 5.5, 2), 0.4]), np.array([*rng.uniform(0.2, 1.0, 2), 0.8]), 0.0
        )
        for _ in range(rng.integers(4))
    ]
    people = []
    for number in range(rng.integers(1, 5)):
        posture = list(Posture)[rng.integers(3)]
        heading, speed = rng.uniform(-np.pi, np.pi), rng.uniform(0.2, 1.2) * (posture is Posture.WALKING)
        place = COUCH.position_in_world if posture is Posture.SEATED else rng.uniform(0.5, 6.5, 2)
        velocity, seat = speed * np.array([np.cos(heading), np.sin(heading)]), COUCH.name
        people.append(TrackedPerson(number, 0.0, place, velocity, 1e-4 * np.eye(4), posture, heading, seat))
    task = GoTo(Pose2D(*GOAL.tolist(), 0.0))
    return boxes, Scene(0.0, tuple(people), (TELEVISION,), (COUCH,), task, Pose2D(*START, 0.0))


def costmap(seed: int, amplitude: float, blocking: bool = True) -> Costmap:
    """Social costs at an amplitude; what blocks has no costs around it, so that the sum of costs is a sum."""
    boxes, scene = random_scene(seed)
    grid = Costmap.covering(FLOOR, COARSE)
    parameters = {name: {"amplitude": amplitude} for name in SOCIAL}
    without = () if blocking else ("static", "inflation", "body")
    layers = standard_layers(boxes, robot_radius=0.3, inflation_radius=0.3, without=without, parameters=parameters)
    for layer in layers:
        layer.apply(grid, scene)
    return grid


def figures(way: Array, unit: Costmap) -> tuple[float, float]:
    return length(way), exposure(way, unit.cost_at(way) / SOCIAL_MAX)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.lists(st.floats(0.0, 40.0), min_size=2, max_size=5, unique=True))
def test_the_dearer_a_full_cost_the_longer_the_optimal_way_and_the_less_its_exposure(
    seed: int, weights: list[float]
) -> None:
    grid = costmap(seed, 1.0)
    assume(grid.cost_at(START) < INSCRIBED and (grid.cost < INSCRIBED).any())
    ways = [AStar(weight=weight).search(grid, START, GOAL) for weight in sorted(weights)]
    found = [figures(way.points_in_world, grid) for way in ways if way is not None]
    assume(len(found) == len(weights))
    for (shorter, more), (longer, less) in itertools.pairwise(found):
        assert longer >= shorter - EQUAL
        assert less <= more + EQUAL


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_the_higher_the_amplitude_the_longer_the_way_and_the_less_its_exposure_but_for_rounded_costs(
    seed: int, one: float, other: float
) -> None:
    low, high = sorted((one, other))
    assume(high - low > 0.05)
    unit = costmap(seed, 1.0)
    assume(unit.cost_at(START) < INSCRIBED)
    ways = [AStar(weight=WEIGHT).search(costmap(seed, a), START, GOAL) for a in (low, high)]
    assume(all(way is not None for way in ways))
    (shorter, more), (longer, less) = (figures(way.points_in_world, unit) for way in ways if way is not None)
    # A metre on a map of amplitude a is priced with up to half a number of rounding there and half in `unit`. Adding
    # F_low(P_low) <= F_low(P_high) and F_high(P_high) <= F_high(P_low) leaves of the law what follows.
    rounding = (0.5 + 0.5) * WEIGHT / SOCIAL_MAX * (shorter + longer)
    slack = 2.0 * rounding / (WEIGHT * (high - low))
    assert less <= more + slack + EQUAL
    assert longer >= shorter - WEIGHT * low * slack - rounding - EQUAL


@pytest.mark.parametrize("name", CASES)
def test_the_detour_round_a_layer_grows_with_its_amplitude_from_none_at_all(name: str) -> None:
    case = CASES[name]
    ways = [best_way(case, amplitude).points_in_world for amplitude in AMPLITUDES]
    lengths, exposures = [length(way) for way in ways], [exposure_to_layer(case, way) for way in ways]
    # Costs are whole numbers, so that between two amplitudes a way may win back the turn of one cell.
    assert (np.diff(lengths) >= -TURN - EQUAL).all()
    assert (np.diff(exposures) <= TURN).all()
    assert lengths[-1] > lengths[0] + 0.5
    assert exposures[-1] < 0.1 * exposures[0]


@pytest.mark.parametrize("name", CASES)
def test_where_no_cost_is_rounded_anew_the_detour_never_shrinks(name: str) -> None:
    case = CASES[name]
    grid = blocked_map(case)
    case.layer().apply(grid, case.scene)
    ends = np.array(case.start), np.array(case.goal)
    ways = [AStar(weight=WEIGHT * part).search(grid, *ends) for part in np.linspace(0.0, 1.0, 21)]
    points = [way.points_in_world for way in ways if way is not None]
    lengths, exposures = [length(each) for each in points], [exposure_to_layer(case, each) for each in points]
    assert len(points) == 21
    assert (np.diff(lengths) >= -EQUAL).all()
    assert (np.diff(exposures) <= EQUAL).all()


def test_the_benchmark_prints_a_row_for_each_layer_and_draws(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["path_follows_cost", "--out", str(tmp_path / "ways.png")])
    path_follows_cost.main()
    printed = capsys.readouterr().out
    assert all(f"| {name} | 0.00 (" in printed for name in SOCIAL)
    assert (tmp_path / "ways.png").read_bytes().startswith(b"\x89PNG")
