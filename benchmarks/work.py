"""How much there is to do in the loop, counted, not timed: the same on a busy machine, and nearly so on another one.

Usage: python -m benchmarks.work [--world real2] [--seed 0] [--seconds 3]
"""

import argparse
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any
from unittest.mock import patch

from benchmarks.provenance import provenance
from han_bullet.assembly import build_localization, build_stack, build_tracker
from han_bullet.camera_workers import CameraStation, DetectorChoice
from han_bullet.detection.acf import AcfDetector
from han_bullet.detection.cnn import Classifier
from han_bullet.episode import run_episode
from han_bullet.markdown import markdown_table
from han_bullet.planning.astar import AStar
from han_bullet.sim import renderer
from han_bullet.sim.simulator import Simulator
from han_bullet.variation import vary
from han_bullet.world_file import load_world
from han_bullet.world_schema import World


def counted_work(world: World, seed: int, seconds: float) -> dict[str, int]:
    """Run a world with all its cameras in this process; return what was done after the calibration, by name."""
    counts: Counter[str] = Counter()
    station = CameraStation(world, seed, [camera.name for camera in world.cameras], DetectorChoice().load())
    simulator = Simulator(world, renderer=station.frames)
    stack = build_stack(
        world,
        localization=build_localization(world, world.robot.start_pose_in_world, seed),
        detector=station.detector,
        tracker=build_tracker(world),
    )
    with ExitStack() as closing:
        closing.callback(station.frames.close)
        closing.callback(simulator.close)
        for owner, name, count in _COUNTED:
            closing.enter_context(patch.object(owner, name, _counting(getattr(owner, name), count, counts)))
        run_episode(simulator, stack, duration=seconds)
    return dict(counts)


def _counting(original: Callable[..., Any], count: Callable[[Any], dict[str, int]], counts: Counter[str]) -> Any:
    """Return a function that does what another one does, and adds up what its results tell."""

    def counting(*arguments: Any, **keywords: Any) -> Any:
        result = original(*arguments, **keywords)
        counts.update(count(result))
        return result

    return counting


_COUNTED: tuple[tuple[Any, str, Callable[[Any], dict[str, int]]], ...] = (
    (renderer, "draw", lambda pixels: {"render: meshes drawn": 1, "render: pixels tried": pixels}),
    (
        AcfDetector,
        "scan",
        lambda scan: {"ACF: images": 1, "ACF: windows scanned": scan.windows, "ACF: trees evaluated": scan.trees},
    ),
    (Classifier, "probabilities", lambda answers: {"CNN: proposals": len(answers)}),
    (
        AStar,
        "search",
        lambda path: {"A*: searches": 1, "A*: cells expanded": 0 if path is None else path.expanded},
    ),
)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--world", default="real2")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=3.0, help="simulated [s]")
    options = parser.parse_args()
    world = vary(load_world(options.world), options.seed)
    work = counted_work(world, options.seed, options.seconds)
    print(f"### Work: {options.world}, seed {options.seed}, {len(world.cameras)} cameras\n")
    print(f"{provenance()}\n")
    rows = [(name, count, count / options.seconds) for name, count in sorted(work.items())]
    print(markdown_table(("work", f"in {options.seconds:g} s", "per simulated second"), rows))


if __name__ == "__main__":
    main()
