"""The simulated people of the tracker's benchmark, and what is measured of them."""

import numpy as np
import pytest

from benchmarks.crowd import CLUTTER_DENSITY, NEAREST, SCAN_PERIOD, SPEEDS, measure, record, walk

SIDE = 12.0


def test_people_walk_stop_and_cross_each_other_but_not_through_each_other() -> None:
    positions = walk(10, SIDE, 400, np.random.default_rng(0))
    assert positions.shape == (400, 10, 2)
    assert positions.min() >= 0.3 and positions.max() <= SIDE - 0.3
    speeds = np.hypot(*np.moveaxis(np.diff(positions, axis=0), -1, 0)) / SCAN_PERIOD
    assert 0.05 < (speeds < 0.05).mean() < 0.5
    assert 0.4 < np.median(speeds[speeds > 0.05]) < SPEEDS[1]
    first, second = np.triu_indices(10, 1)
    distances = np.hypot(*np.moveaxis(positions[:, first] - positions[:, second], -1, 0))
    assert distances.min() > 0.95 * NEAREST
    assert (distances.min(axis=0) < 1.0).sum() > 5  # pairs that met


def test_nine_people_in_ten_are_measured_with_a_tenth_of_a_metre_of_noise() -> None:
    generator = np.random.default_rng(0)
    people = np.array([[2.0, 2.0], [10.0, 2.0], [2.0, 10.0], [10.0, 10.0]])
    scans = [measure(people, SIDE, generator) for _ in range(1000)]
    errors = np.concatenate([scan[:, None] - people[None] for scan in scans])
    near = errors[np.hypot(errors[..., 0], errors[..., 1]) < 0.5]
    assert len(near) / 4000 == pytest.approx(0.9, abs=0.02)
    assert near.std(axis=0) == pytest.approx([0.1, 0.1], abs=0.005)
    clutter = np.mean([len(scan) for scan in scans]) - 3.6
    assert clutter == pytest.approx(CLUTTER_DENSITY * SIDE**2, abs=0.1)


def test_a_seed_gives_one_recording_and_another_seed_another() -> None:
    first, again, other = (record(3, 5.0, 2.0, seed) for seed in (1, 1, 2))
    assert len(first.measurements) == len(first.positions) == 20
    assert np.array_equal(first.positions, again.positions)
    assert all(np.array_equal(*pair) for pair in zip(first.measurements, again.measurements, strict=True))
    assert not np.allclose(first.positions, other.positions)
