"""Speed, acceleration, jerk and turning, on ways whose figures can be worked out by hand."""

import math
from itertools import pairwise

import numpy as np
import pytest
from ticks import tick

from han_bullet.metrics.motion import MotionTally, path_irregularity


def test_acceleration_and_jerk_are_vector_differences_by_time() -> None:
    tally = MotionTally()
    for index, twist in enumerate([(0.0, 0.0), (0.03, 0.04), (0.06, 0.08), (0.06, 0.08)]):
        tally.record(tick(index, twist=(*twist, 0.0)))
    values = tally.values()
    # Changes of 0.05, 0.05 and 0 m/s in 0.05 s each: 1, 1 and 0 m/s^2; their changes 0 and 1 m/s^2 in 0.05 s.
    assert values["mean_acceleration"] == pytest.approx(2.0 / 3.0)
    assert values["max_acceleration"] == pytest.approx(1.0)
    assert values["mean_jerk"] == pytest.approx((0.0 + 20.0) / 2.0)
    assert values["max_jerk"] == pytest.approx(20.0)


def test_a_single_tick_has_no_changes() -> None:
    tally = MotionTally()
    tally.record(tick(0, twist=(0.3, 0.4, 0.0)))
    values = tally.values()
    assert (values["max_speed"], values["max_acceleration"], values["max_jerk"]) == (pytest.approx(0.5), 0.0, 0.0)
    assert values["path_irregularity"] is None


def polyline(*corners: tuple[float, float]) -> np.ndarray:
    """Points every 0.02 m."""
    legs = [np.linspace(a, b, round(math.dist(a, b) / 0.02), endpoint=False) for a, b in pairwise(corners)]
    return np.vstack([*legs, corners[-1]])


def test_a_straight_way_and_a_bend_have_no_irregularity() -> None:
    assert path_irregularity(polyline((3.0, 1.0), (7.0, 4.0))) == pytest.approx(0.0, abs=1e-9)
    angles = np.linspace(0.0, 0.5 * math.pi, 200)
    assert path_irregularity(2.0 * np.column_stack([np.cos(angles), np.sin(angles)])) == pytest.approx(0.0, abs=1e-9)


def test_an_evasion_turns_unnecessarily_by_all_that_it_turns() -> None:
    # 45 degrees out, 90 back, 45 straight again: 180 degrees over 2 + 2 sqrt(2) m.
    way = polyline((0.0, 0.0), (1.0, 0.0), (2.0, 1.0), (3.0, 0.0), (4.0, 0.0))
    assert path_irregularity(way) == pytest.approx(math.pi / (2.0 + 2.0 * math.sqrt(2.0)), rel=0.05)


def test_a_whole_loop_is_unnecessary_and_a_u_turn_is_not() -> None:
    around = np.linspace(0.0, 2.0 * math.pi, 800)
    # Of 63 chords of 0.1 rad each; the last half of a turn is not taken.
    loop = np.vstack([polyline((-1.0, -1.0), (0.0, -1.0)), np.column_stack([np.sin(around), -np.cos(around)])])
    assert path_irregularity(loop) == pytest.approx(2.0 * math.pi / (1.0 + 2.0 * math.pi), rel=0.03)
    half = around[:400]
    assert path_irregularity(np.column_stack([np.sin(half), -np.cos(half)])) == pytest.approx(0.0, abs=1e-9)


def test_the_jitter_of_a_base_that_stands_is_no_turning() -> None:
    rng = np.random.default_rng(0)
    standing = np.array([2.0, 0.0]) + rng.normal(0.0, 0.003, (1000, 2))
    way = np.vstack([polyline((0.0, 0.0), (2.0, 0.0)), standing, polyline((2.0, 0.0), (4.0, 0.0))])
    assert path_irregularity(way) == pytest.approx(0.0, abs=0.06)
    steps = np.diff(way, axis=0)
    turns = np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0])))
    assert np.abs(turns).sum() / 4.0 > 100.0  # [rad/m] if every tick counted


def test_where_the_base_faces_is_turning_of_the_heading_only() -> None:
    tally = MotionTally()
    for index in range(41):
        tally.record(tick(index, robot=(0.05 * index, 0.0, 0.1 * index)))
    values = tally.values()
    assert values["cumulative_heading_change"] == pytest.approx(4.0)
    assert values["path_irregularity"] == pytest.approx(0.0)
