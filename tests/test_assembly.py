"""Parameters of a world where they belong."""

from han_bullet.ablation import NoDetector, TrueLocalization, TruthTracker
from han_bullet.assembly import build_stack
from han_bullet.costmap.oncoming import OncomingLayer
from han_bullet.messages import Truth
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
