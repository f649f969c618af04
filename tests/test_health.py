"""When a pose is doubted, scan by scan."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from simulated_laser import CORRIDOR, CORRIDOR_FLOOR, FLOOR, NOBODY, ROOM, Laser

from han_bullet.geometry import Pose2D
from han_bullet.localization.beams import Beams
from han_bullet.localization.fit import Fit
from han_bullet.localization.health import LONGEST_STEP, SUSPECT, TIME_CONSTANT, Health
from han_bullet.localization.likelihood_field import LikelihoodField
from han_bullet.localization.occupancy_grid import OccupancyGrid
from han_bullet.localization.scan_matching import ScanMatcher

FIELD = LikelihoodField.of_map(OccupancyGrid.of_building([FLOOR], ROOM, scan_height=0.25))
HERE, THERE = Pose2D(3.0, 2.5, 0.4), Pose2D(3.8, 2.9, 0.4)


def seen(pose: Pose2D) -> Beams:
    scan = Laser(ROOM).scan(0.0, pose, NOBODY, np.random.default_rng(0))
    return Beams.of_scan(scan, scan.scanner_in_body)


def health() -> Health:
    return Health(FIELD, ScanMatcher(FIELD), np.random.default_rng(0))


def test_one_scan_that_does_not_fit_is_forgiven_and_half_a_second_of_them_is_not() -> None:
    robot = health()
    assert not any(robot.lost(0.1 * k, HERE, seen(HERE)) for k in range(5))
    assert not robot.lost(0.5, HERE, seen(THERE))
    assert not any(robot.lost(0.1 * k, HERE, seen(HERE)) for k in range(6, 20))
    doubts = [robot.lost(0.1 * k, HERE, seen(THERE)) for k in range(20, 30)]
    assert not doubts[0] and 0.2 <= 0.1 * doubts.index(True) <= 0.6


@pytest.mark.parametrize("gap", [0.3, 30.0])
def test_one_scan_does_not_decide_after_a_gap_either_and_a_few_do(gap: float) -> None:
    robot = health()
    robot.lost(0.0, HERE, seen(HERE))
    doubts = [robot.lost(gap * k, HERE, seen(THERE)) for k in range(1, 6)]
    assert not any(doubts[:2]) and doubts[-1]


def test_a_scan_fits_to_its_place_and_clearly_better_than_another() -> None:
    here, there = Fit.of(HERE, seen(HERE), FIELD), Fit.of(THERE, seen(HERE), FIELD)
    assert here.good and here.explained > 0.95 and here.blocked < 0.03
    assert here.clearly_better_than(there) and not there.clearly_better_than(here)


def test_a_pose_that_is_nearly_the_same_is_no_other_one_however_much_better() -> None:
    near = Fit.of(Pose2D(HERE.x + 0.2, HERE.y, HERE.yaw + math.radians(5.0)), seen(HERE), FIELD)
    here = Fit.of(HERE, seen(HERE), FIELD)
    assert here.log_likelihood - near.log_likelihood > 100.0
    assert not here.clearly_better_than(near)


@pytest.mark.parametrize("blind", [Pose2D(-30.0, 0.0, 0.0), Pose2D(6.0, 1.0, 0.0)])
def test_a_pose_off_the_map_or_within_a_couch_is_doubted(blind: Pose2D) -> None:
    robot = health()
    assert any(robot.lost(0.1 * k, blind, seen(HERE)) for k in range(10))


def test_an_end_of_a_corridor_that_is_nearer_than_it_should_be_is_noticed_though_no_beam_goes_through_a_wall() -> None:
    field = LikelihoodField.of_map(OccupancyGrid.of_building([CORRIDOR_FLOOR], CORRIDOR, scan_height=0.25))
    robot = Health(field, ScanMatcher(field), np.random.default_rng(0))
    scan = Laser(CORRIDOR).scan(0.0, Pose2D(37.0, 0.0, 0.0), NOBODY, np.random.default_rng(0))
    beams, believed = Beams.of_scan(scan, scan.scanner_in_body), Pose2D(36.0, 0.0, 0.0)
    assert Fit.of(believed, beams, field).good
    assert any(robot.lost(0.1 * k, believed, beams) for k in range(10))


@pytest.mark.parametrize("seed", range(5))
def test_looking_closely_only_when_the_answer_depends_on_it_changes_no_answer(seed: int) -> None:
    generator = np.random.default_rng(seed)
    # Bad scans come in bouts; some are plain at once, others ask for a closer look.
    bad = np.repeat(generator.random(60) < 0.4, generator.integers(1, 6, size=60))
    plain = generator.random(len(bad)) < 0.3
    gaps = generator.choice([0.05, 0.1, 0.3], size=len(bad))

    class Told(Health):
        def _judged(self, pose: Pose2D, beams: Beams) -> bool | Callable[[], bool]:
            return bool(bad[k]) if plain[k] else lambda verdict=bool(bad[k]): verdict

    robot, beams = Told(FIELD, ScanMatcher(FIELD), np.random.default_rng(0)), seen(HERE)
    answers, eager, smoothed, time = [], [], 0.0, 0.0
    for k, gap in enumerate(gaps):
        time += gap
        keep = 1.0 if k == 0 else math.exp(-min(gap, LONGEST_STEP) / TIME_CONSTANT)
        smoothed = keep * smoothed + (1.0 - keep) * bad[k]
        answers.append(robot.lost(time, HERE, beams))
        eager.append(smoothed > SUSPECT)
    assert answers == eager and True in answers and False in answers


def test_a_robot_that_knows_where_it_is_looks_closely_at_little_more_than_half_of_the_scans() -> None:
    looked = []

    class AllGood(Health):
        def _judged(self, pose: Pose2D, beams: Beams) -> bool | Callable[[], bool]:
            return lambda: bool(looked.append(True))

    robot, beams = AllGood(FIELD, ScanMatcher(FIELD), np.random.default_rng(0)), seen(HERE)
    assert not any(robot.lost(0.1 * k, HERE, beams) for k in range(100))
    assert len(looked) <= 60
