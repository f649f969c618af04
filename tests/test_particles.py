"""Weighted samples: how many are worth it, how many suffice, how they are drawn; and particles on a map."""

import math

import numpy as np
import pytest
from scipy import stats
from simulated_laser import CORRIDOR, CORRIDOR_FLOOR, FLOOR, NOBODY, ROOM, Laser

from han_bullet.geometry import Pose2D, SolidBox
from han_bullet.localization.beams import Beams
from han_bullet.localization.likelihood_field import LikelihoodField
from han_bullet.localization.monte_carlo import LEAST, MonteCarlo
from han_bullet.localization.occupancy_grid import FREE, OccupancyGrid
from han_bullet.localization.odometry_model import OdometryModel
from han_bullet.localization.particles import BIN, drawn, effective_count, sufficient_count, tempered


def particles(boxes: list[SolidBox], floor: tuple[tuple[float, float], tuple[float, float]]) -> MonteCarlo:
    grid = OccupancyGrid.of_building([floor], boxes, scan_height=0.25)
    return MonteCarlo(grid, LikelihoodField.of_map(grid), OdometryModel(), np.random.default_rng(0))


def test_equal_weights_are_worth_their_number_and_one_that_has_all_is_worth_one() -> None:
    assert effective_count(np.full(8, 0.125)) == pytest.approx(8.0)
    assert effective_count(np.array([0.0, 1.0, 0.0])) == 1.0


@pytest.mark.parametrize("bins", [10, 100, 1000])
def test_samples_suffice_that_keep_the_divergence_small_by_the_chi_square_law(bins: int) -> None:
    poses = np.zeros((bins, 3))
    poses[:, 0] = (np.arange(bins) + 0.5) * BIN[0]
    assert sufficient_count(poses, 1, 10**6) == pytest.approx(stats.chi2.ppf(0.99, bins - 1) / (2 * 0.05), rel=0.01)


def test_samples_in_one_bin_need_no_more_than_the_least() -> None:
    assert sufficient_count(np.full((50, 3), 0.01), 30, 1000) == 30
    assert sufficient_count(np.random.default_rng(0).uniform(0, 50, (2000, 3)), 30, 1000) == 1000


def test_drawing_with_low_variance_takes_each_as_often_as_its_weight_says_rounded_up_or_down() -> None:
    weights = np.array([0.5, 0.0, 0.23, 0.27])
    for seed in range(20):
        counts = np.bincount(drawn(weights, 100, np.random.default_rng(seed)), minlength=4)
        assert np.abs(counts - 100 * weights).max() < 1.0 and counts.sum() == 100


def test_particles_lie_on_free_floor_only_and_everywhere_on_it() -> None:
    robot = particles(ROOM, FLOOR)
    grid = OccupancyGrid.of_building([FLOOR], ROOM, scan_height=0.25)
    column, row = np.floor((robot.poses[:, :2] - grid.origin_in_world) / grid.resolution).astype(int).T
    assert (grid.cells[row, column] == FREE).all()
    assert np.histogram2d(*robot.poses[:, :2].T, bins=4, range=FLOOR)[0].min() > 100
    assert np.histogram(robot.poses[:, 2], 8, (-math.pi, math.pi))[0].min() > 1000


def test_after_some_scans_few_particles_are_left_and_most_are_where_the_robot_is() -> None:
    robot, true, generator = particles(ROOM, FLOOR), Pose2D(3.0, 2.5, 0.4), np.random.default_rng(1)
    at_first = len(robot.poses)
    for _ in range(5):
        scan = Laser(ROOM).scan(0.0, true, NOBODY, generator)
        robot.weigh(Beams.of_scan(scan, scan.scanner_in_body))
    assert at_first > 8000 and len(robot.poses) < 2 * LEAST
    near = np.hypot(robot.poses[:, 0] - true.x, robot.poses[:, 1] - true.y) < 0.3
    assert robot.weights[near].sum() > 0.8
    assert true.distance_to(robot.clusters(1)[0, :2]) < 0.2


def test_along_a_corridor_without_an_end_in_sight_particles_stay_spread_out() -> None:
    robot, generator = particles(CORRIDOR, CORRIDOR_FLOOR), np.random.default_rng(1)
    for _ in range(5):
        scan = Laser(CORRIDOR).scan(0.0, Pose2D(20.0, 0.0, 0.0), NOBODY, generator)
        robot.weigh(Beams.of_scan(scan, scan.scanner_in_body))
    assert math.sqrt(robot.covariance()[0, 0]) > 5.0
    assert len(robot.poses) > 2 * LEAST


def test_moving_carries_each_particle_along_its_own_direction() -> None:
    robot = particles(ROOM, FLOOR)
    robot.poses = np.array([[1.0, 1.0, 0.0], [1.0, 1.0, 0.5 * math.pi]])
    robot.move(Pose2D(0.5, 0.0, 0.0))
    assert robot.poses[:, :2] == pytest.approx(np.array([[1.5, 1.0], [1.0, 1.5]]), abs=0.05)


def test_weights_are_sharpened_no_further_than_some_samples_keep_their_worth() -> None:
    equal, logs = np.full(1000, 1e-3), np.linspace(-500.0, 0.0, 1000)
    assert effective_count(tempered(equal, logs, 1.0, 100.0)) == pytest.approx(100.0, rel=0.1)
    gentle = tempered(equal, 1e-3 * logs, 1.0, 100.0)
    assert gentle / gentle[0] == pytest.approx(np.exp(1e-3 * (logs - logs[0])))
