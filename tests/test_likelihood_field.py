"""Distances from a map's surfaces, and how likely scans are by them."""

import math

import numpy as np
import pytest
from simulated_laser import FLOOR, NOBODY, ROOM, Laser, block

from han_bullet.geometry import Pose2D
from han_bullet.localization.beams import Beams
from han_bullet.localization.likelihood_field import BLOCKED, SHORT, LikelihoodField
from han_bullet.localization.occupancy_grid import OccupancyGrid
from han_bullet.messages import LaserScan

FIELD = LikelihoodField.of_map(OccupancyGrid.of_building([FLOOR], ROOM[:4], scan_height=0.25))


def beam(length: float, returned: bool = True) -> Beams:
    """One beam straight ahead."""
    return Beams(np.zeros(2), np.array([[length, 0.0]]), np.array([returned]))


def log_likelihood(pose: tuple[float, float, float], beams: Beams) -> float:
    return float(FIELD.likelihoods(np.array([pose]), beams, 0.05)[0][0])


def test_distances_are_from_the_walls_surface_and_negative_behind_it() -> None:
    row = FIELD.distance[60]  # y = 2.925 m; x from -0.1 m on
    assert row[:4] == pytest.approx([-0.075, -0.025, 0.025, 0.075])
    assert row[42] == pytest.approx(2.025)


def test_a_beam_that_ends_at_a_wall_is_certain_and_one_that_ends_before_is_as_likely_as_a_person() -> None:
    assert log_likelihood((3.0, 3.0, 0.0), beam(5.0)) == pytest.approx(0.0, abs=0.15)
    assert log_likelihood((3.0, 3.0, 0.0), beam(2.0)) == pytest.approx(math.log(SHORT))


def test_a_beam_that_goes_through_a_wall_is_least_likely_whether_something_is_behind_or_nothing() -> None:
    assert log_likelihood((7.0, 3.0, 0.0), beam(5.0)) == pytest.approx(math.log(BLOCKED))
    assert log_likelihood((7.0, 3.0, 0.0), beam(5.0, returned=False)) == pytest.approx(math.log(BLOCKED))
    assert log_likelihood((1.0, 3.0, 0.0), beam(5.0, returned=False)) == 0.0


def test_a_scan_is_likeliest_where_it_was_taken() -> None:
    field = LikelihoodField.of_map(OccupancyGrid.of_building([FLOOR], ROOM, scan_height=0.25))
    pose = Pose2D(3.0, 2.0, 0.4)
    scan = Laser(ROOM).scan(0.0, pose, NOBODY, np.random.default_rng(0))
    offsets = [(0.0, 0.0, 0.0), (0.3, 0, 0), (-0.3, 0, 0), (0, 0.3, 0), (0, -0.3, 0), (0, 0, 0.2), (0, 0, -0.2)]
    beams = Beams.of_scan(scan, scan.scanner_in_body)
    logs, hits, blocked = field.likelihoods(np.array([3.0, 2.0, 0.4]) + offsets, beams, 0.1)
    assert np.argmax(logs) == 0
    assert hits[0] + blocked[0] == 541 and blocked[0] < 6  # past corners, of which the cells show more


def test_what_is_not_on_the_map_hides_some_of_it_and_contradicts_nothing() -> None:
    scene = [*ROOM[:4], block(4.0, 3.0, 0.5, 0.5)]
    scan = Laser(scene).scan(0.0, Pose2D(2.0, 3.0, 0.0), NOBODY, np.random.default_rng(0))
    _, hits, blocked = FIELD.likelihoods(np.array([[2.0, 3.0, 0.0]]), Beams.of_scan(scan, scan.scanner_in_body), 0.1)
    assert 450 < hits[0] < 541 and blocked[0] == 0


def test_an_empty_map_makes_every_beam_that_met_something_unlikely() -> None:
    field = LikelihoodField.of_map(OccupancyGrid.of_building([FLOOR], [], scan_height=0.25))
    logs, _, _ = field.likelihoods(np.array([[4.0, 3.0, 0.0]]), beam(2.0), 0.1)
    assert logs[0] == pytest.approx(math.log(SHORT))


def test_rays_without_a_measurement_are_left_out_and_those_without_an_echo_reach_as_far_as_they_can() -> None:
    ranges = np.array([0.01, math.nan, 2.0, math.inf, 9.0])
    scan = LaserScan(0.0, ranges, 0.0, 0.5 * math.pi, 0.05, 8.0, Pose2D(0.2, 0.0, 0.0))
    beams = Beams.of_scan(scan, scan.scanner_in_body)
    assert beams.returned.tolist() == [True, False, False]
    assert beams.ends_in_body == pytest.approx(np.array([[-1.8, 0.0], [0.2, -8.0], [8.2, 0.0]]))


def test_of_many_beams_no_more_are_taken_than_wanted_from_all_sides() -> None:
    beams = Beams(np.zeros(2), np.arange(1082.0).reshape(-1, 2), np.ones(541, bool))
    assert len(beams.some(45).returned) == 42
    assert beams.some(45).ends_in_body[-1, 0] == 1066.0
    assert len(beams.some(1000).returned) == 541
