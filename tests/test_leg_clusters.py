"""Leg-sized things in laser scans: where they are, and what is none."""

import math

import numpy as np
import pytest
from simulated_laser import SCANNER_IN_BODY, Laser

from han_bullet.geometry import Array, Pose2D, SolidBox
from han_bullet.messages import LaserScan
from han_bullet.tracking.leg_clusters import LEG_RADIUS, Legs, find_legs

ROBOT = Pose2D(1.0, -0.5, 0.4)
SCANNER = ROBOT.compose(SCANNER_IN_BODY)
CERTAIN = np.zeros((3, 3))
WALL = SolidBox("wall", "wall", np.array([3.0, 2.0, 1.3]), np.array([8.0, 0.1, 2.6]), 0.0)
POST = SolidBox("post", "object", np.array([3.0, 0.0, 0.5]), np.array([0.12, 0.12, 1.0]), 0.3)


def scan(*discs: tuple[float, float, float], boxes: tuple[SolidBox, ...] = (WALL,), seed: int = 0) -> LaserScan:
    """A sweep over round things: x, y, radius [m]."""
    return Laser(boxes).scan(0.0, ROBOT, np.array(discs).reshape(-1, 3), np.random.default_rng(seed))


def found(
    sweep: LaserScan, obstacles: tuple[SolidBox, ...] = (WALL,), covariance: Array = CERTAIN, scanner: Pose2D = SCANNER
) -> Legs:
    return find_legs(sweep, scanner, covariance, obstacles, 4.0)


@pytest.mark.parametrize("distance", [0.4, 1.0, 2.0, 3.0, 3.8])
def test_a_leg_is_found_at_its_axis(distance: float) -> None:
    for seed in range(10):
        x, y = SCANNER.to_world(distance * np.array([math.cos(-0.3), math.sin(-0.3)]))
        legs = found(scan((x, y, LEG_RADIUS), seed=seed))
        assert len(legs.positions) == 1
        assert legs.positions[0] == pytest.approx([x, y], abs=0.025)
        assert legs.ranges[0] == pytest.approx(distance, abs=0.02)


def test_legs_side_by_side_are_two_and_beyond_reach_there_is_none() -> None:
    left, right = SCANNER.to_world(np.array([[2.5, 0.1], [2.5, -0.1]]))
    far = SCANNER.to_world(np.array([4.3, -1.0]))
    legs = found(scan((*left, LEG_RADIUS), (*right, LEG_RADIUS), (*far, LEG_RADIUS)))
    assert legs.positions == pytest.approx(np.array([right, left]), abs=0.03)


@pytest.mark.parametrize("radius", [0.012, 0.25])
def test_poles_and_pillars_are_no_legs(radius: float) -> None:
    x, y = SCANNER.to_world(np.array([2.0, 0.2]))
    assert len(found(scan((x, y, radius))).positions) == 0


def test_furniture_of_the_map_is_no_leg_and_furniture_that_it_does_not_know_looks_like_one() -> None:
    sweep = scan(boxes=(WALL, POST))
    assert len(found(sweep, (WALL, POST)).positions) == 0
    assert found(sweep, (WALL,)).positions == pytest.approx(np.array([[3.0, 0.0]]), abs=0.06)


def test_a_person_beside_a_wall_is_not_the_wall() -> None:
    legs = found(scan((3.0, 1.75, LEG_RADIUS), (3.2, 1.75, LEG_RADIUS)))
    assert len(legs.positions) == 2


def test_the_map_is_taken_to_be_as_uncertain_as_the_robots_pose() -> None:
    """The robot believes to be 0.25 m aside, or turned by 0.1 rad, so that the post is off the map's."""
    sweep = scan(boxes=(WALL, POST))
    aside, turned = Pose2D(SCANNER.x, SCANNER.y - 0.25, SCANNER.yaw), Pose2D(SCANNER.x, SCANNER.y, SCANNER.yaw + 0.12)
    for scanner, covariance in ((aside, np.diag([0.1, 0.1, 0.0]) ** 2), (turned, np.diag([0.0, 0.0, 0.1]) ** 2)):
        assert len(found(sweep, (WALL, POST), CERTAIN, scanner).positions) == 1
        assert len(found(sweep, (WALL, POST), covariance, scanner).positions) == 0


def test_rays_that_meet_nothing_or_are_no_numbers_are_no_legs() -> None:
    sweep = scan(boxes=())
    assert np.isinf(sweep.ranges).all()
    assert found(sweep).positions.shape == (0, 2)
    sweep.ranges[100:104] = np.nan
    assert found(sweep).positions.shape == (0, 2)
