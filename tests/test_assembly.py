"""Parameters of a world where they belong."""

import numpy as np
import pytest

from han_bullet.ablation import NoDetector, TrueLocalization, TruthTracker
from han_bullet.assembly import build_localization, build_stack
from han_bullet.costmap.oncoming import OncomingLayer
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.messages import Odometry, Truth
from han_bullet.world_file import load_world


def no_truth() -> Truth:
    raise AssertionError("nobody asks")


def test_the_layer_that_meets_people_knows_how_fast_the_worlds_robot_is() -> None:
    world = load_world("crossing")
    slow = world.model_copy(update={"robot": world.robot.model_copy(update={"max_speed": 0.6})})
    stack = build_stack(
        slow,
        localization=TrueLocalization(no_truth),
        detector=NoDetector(),
        tracker=TruthTracker(no_truth),
    )
    (speed,) = (layer.robot_speed for layer in stack.layers if isinstance(layer, OncomingLayer))
    assert speed == 0.6


def test_localization_trusts_the_wheels_as_much_as_the_world_says() -> None:
    def spread(slip: float) -> float:
        world = load_world("real2")
        slipping = world.robot.model_copy(update={"slip": world.robot.slip.model_copy(update={"distance": slip})})
        start = Pose2D(1.5, 0.0, 0.0)
        robot = build_localization(world.model_copy(update={"robot": slipping}), start, seed=0)
        for k in range(100):
            estimate = robot.update(Odometry(0.05 * k, Pose2D(0.05 * k, 0.0, 0.0), Twist2D()), None)
        return float(np.sqrt(estimate.covariance[0, 0]))

    assert spread(0.1) > 3.0 * spread(0.02)


def test_planner_and_proximity_reckon_with_people_as_large_as_the_body_layer_makes_them() -> None:
    world = load_world("real2")
    robot = world.robot.model_copy(update={"radius": 0.45})
    large = world.model_copy(update={"robot": robot, "layers": {"body": {"body_radius": 0.3, "smallest_margin": 0.05}}})
    for one, disc, contact, gap in ((world, 0.75, 0.55, 0.08), (large, 0.95, 0.75, 0.04)):
        stack = build_stack(
            one,
            localization=TrueLocalization(no_truth),
            detector=NoDetector(),
            tracker=TruthTracker(no_truth),
        )
        assert stack.planner.largest_body == pytest.approx(disc + one.costmap.resolution)
        assert stack.follower.proximity.contact_distance == pytest.approx(contact)
        assert stack.follower.proximity.smallest_gap == pytest.approx(gap)
