"""The pose between scans: how it moves, how uncertain it gets, what it learns of the wheels."""

import math

import numpy as np
import pytest

from han_bullet.errors import BadInputError
from han_bullet.geometry import Pose2D
from han_bullet.localization.odometry_model import OdometryModel
from han_bullet.localization.pose_filter import PoseFilter

EXACT = OdometryModel(slip=0.0, position_per_way=0.0, yaw_per_way=0.0, yaw_per_turn=0.0)
SLIPPING = OdometryModel(slip=0.02, position_per_way=0.0, yaw_per_way=0.0, yaw_per_turn=0.0)
CERTAIN = 1e-8 * np.eye(3)


def test_a_step_sideways_while_turned_goes_where_the_body_points() -> None:
    robot = PoseFilter(Pose2D(1.0, 2.0, 0.5 * math.pi), CERTAIN, EXACT)
    robot.move(Pose2D(0.0, 1.0, 0.1))
    assert (robot.pose.x, robot.pose.y, robot.pose.yaw) == pytest.approx((0.0, 2.0, 0.5 * math.pi + 0.1))


def test_the_slip_makes_the_deviation_grow_with_the_way_and_noise_with_its_root_however_it_is_cut() -> None:
    for steps in (1, 10, 100):
        robot = PoseFilter(Pose2D(0.0, 0.0, 0.0), CERTAIN, SLIPPING)
        for _ in range(steps):
            robot.move(Pose2D(10.0 / steps, 0.0, 0.0))
        assert math.sqrt(robot.covariance[0, 0]) == pytest.approx(0.2, rel=1e-3)
    noisy = PoseFilter(Pose2D(0.0, 0.0, 0.0), CERTAIN, OdometryModel(slip=0.0, position_per_way=0.01, yaw_per_way=0.0))
    for _ in range(100):
        noisy.move(Pose2D(0.04, 0.0, 0.0))
    assert math.sqrt(noisy.covariance[0, 0]) == pytest.approx(0.02, rel=1e-3)


def test_an_uncertain_direction_makes_the_place_ahead_uncertain_to_the_sides() -> None:
    robot = PoseFilter(Pose2D(0.0, 0.0, 0.0), np.diag([1e-8, 1e-8, 0.1**2]), EXACT)
    robot.move(Pose2D(2.0, 0.0, 0.0))
    assert np.sqrt(np.diag(robot.covariance)) == pytest.approx([1e-4, 0.2, 0.1], rel=1e-2)
    assert robot.covariance[1, 2] == pytest.approx(0.02, rel=1e-3)


def test_the_covariance_is_that_of_many_robots_with_slips_of_their_own() -> None:
    model, generator = OdometryModel(position_per_way=0.02), np.random.default_rng(0)
    steps = [Pose2D(0.1, 0.03, 0.02)] * 50
    robot = PoseFilter(Pose2D(0.0, 0.0, 0.0), CERTAIN, model)
    factors = 1.0 + generator.normal(0.0, model.slip, (4000, 2))
    places = np.zeros((4000, 3))
    for step in steps:
        robot.move(step)
        dx, dy, turn = (
            np.column_stack([factors * [step.x, step.y], np.full(4000, step.yaw)])
            + generator.normal(size=(4000, 3)) * np.sqrt(model.variances(step))
        ).T
        c, s = np.cos(places[:, 2]), np.sin(places[:, 2])
        places = places + np.column_stack([c * dx - s * dy, s * dx + c * dy, turn])
    assert places.mean(axis=0) == pytest.approx([robot.pose.x, robot.pose.y, robot.pose.yaw], abs=0.02)
    assert np.cov(places.T) == pytest.approx(robot.covariance, rel=0.15, abs=2e-4)


def test_a_place_that_is_known_again_tells_the_slip_and_later_ways_are_measured_better() -> None:
    robot = PoseFilter(Pose2D(0.0, 0.0, 0.0), CERTAIN, SLIPPING)
    robot.move(Pose2D(10.0, 0.0, 0.0))  # while the wheels slip, and it is but 9.7 m
    robot.take_in(Pose2D(9.7, 0.0, 0.0), 1e-6 * np.eye(3))
    robot.move(Pose2D(10.0, 0.0, 0.0))
    assert robot.pose.x == pytest.approx(19.4, abs=0.01)
    assert math.sqrt(robot.covariance[0, 0]) < 0.01


def test_drawn_steps_scatter_as_the_model_says() -> None:
    model = OdometryModel(slip=0.02, position_per_way=0.05)
    drawn = model.sampled(np.zeros((20000, 3)), Pose2D(1.0, 0.0, 0.5), np.random.default_rng(0))
    assert drawn.mean(axis=0) == pytest.approx([1.0, 0.0, 0.5], abs=0.002)
    expected = np.sqrt(model.variances(Pose2D(1.0, 0.0, 0.5)) + np.array([0.02**2, 0.0, 0.0]))
    assert drawn.std(axis=0) == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("name", ["slip", "position_per_way", "yaw_per_way", "yaw_per_turn"])
@pytest.mark.parametrize("value", [-0.01, math.nan])
def test_odometry_cannot_be_wrong_by_less_than_nothing(name: str, value: float) -> None:
    with pytest.raises(BadInputError, match=f"odometry model: {name} is {value}; it must be 0 or a positive number"):
        OdometryModel(**{name: value})
