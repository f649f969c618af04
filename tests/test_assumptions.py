"""An assumption that is scaled reaches the layer or the planner that makes it, and nothing else."""

from pathlib import Path

import pytest

from han_bullet.ablation import NoDetector, TrueLocalization, TruthTracker
from han_bullet.assembly import build_stack
from han_bullet.assumptions import ASSUMPTIONS, ASTAR_WEIGHT, Scaled
from han_bullet.messages import Truth
from han_bullet.runner import RunOptions, run_world
from han_bullet.stack import NavigationStack
from han_bullet.world_file import load_world
from han_bullet.world_schema import World


def no_truth() -> Truth:
    raise AssertionError("nobody asks")


def stack_of(world: World) -> NavigationStack:
    return build_stack(
        world,
        localization=TrueLocalization(no_truth),
        detector=NoDetector(),
        tracker=TruthTracker(no_truth),
    )


def value(stack: NavigationStack, name: str) -> float:
    """What a stack has made of an assumption."""
    if name == ASTAR_WEIGHT:
        return stack.planner._astar.weight
    layer, parameter = name.split(".")
    (found,) = (getattr(one, parameter) for one in stack.layers if one.name == layer)
    return float(found)


@pytest.mark.parametrize("name", ASSUMPTIONS)
def test_a_scaled_assumption_is_what_the_stack_works_with_and_the_others_stay(name: str) -> None:
    world = load_world("sim2")
    before, after = stack_of(world), stack_of(Scaled(name, 0.5).apply(world))
    for other in ASSUMPTIONS:
        factor = 0.5 if other == name else 1.0
        assert value(after, other) == pytest.approx(factor * value(before, other), rel=1e-12)


def test_a_value_that_the_world_gives_itself_is_scaled_from_there() -> None:
    world = load_world("sim2").model_copy(update={"layers": {"oncoming": {"horizon": 3.0, "side": 0.4}}})
    assert Scaled("oncoming.horizon", 2.0).apply(world).layers == {"oncoming": {"horizon": 6.0, "side": 0.4}}


def test_a_cost_never_exceeds_the_dearest() -> None:
    assert value(stack_of(Scaled("interaction.gamma", 2.0).apply(load_world("sim2"))), "interaction.gamma") == 1.0


def test_a_result_says_what_was_scaled(tmp_path: Path) -> None:
    world = tmp_path / "brief.yaml"
    world.write_text("extends: real2\nduration: 0.1\n")
    scaled = (Scaled(ASTAR_WEIGHT, 2.0),)
    run_world(world, RunOptions(perception="truth", video=False, scaled=scaled), tmp_path / "run")
    assert '"scaled": [\n    "costmap.astar_weight*2"' in (tmp_path / "run/result.json").read_text()
    assert "astar_weight: 20.0" in (tmp_path / "run/world.yaml").read_text()
