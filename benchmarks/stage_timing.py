"""Where the milliseconds of the loop go, and the real-time factor with five cameras.

Usage: python -m benchmarks.stage_timing [--world real2] [--seed 0] [--seconds 10] [--workers N]
"""

import argparse
import os
import time
from collections.abc import Sequence

import numpy as np

from benchmarks.provenance import provenance
from benchmarks.stopwatch import Stopwatch
from han_bullet.assembly import build_localization, build_stack, build_tracker
from han_bullet.camera_workers import CameraStation, CameraWorkers, DetectorChoice
from han_bullet.detection.camera_detector import CameraDetector
from han_bullet.episode import Hook, Tick, run_episode
from han_bullet.markdown import markdown_table
from han_bullet.messages import Frame, FrameDetections
from han_bullet.sim.simulator import Simulator
from han_bullet.variation import vary
from han_bullet.world_file import load_world
from han_bullet.world_schema import CONTROL_PERIOD, World


class Nothing(Hook):
    """A hook that does nothing."""

    def record(self, tick: Tick) -> None:
        """Ignore the tick."""


def one_process(world: World, seed: int, seconds: float) -> str:
    """Return a table of every stage's time, all in one process."""
    watch = Stopwatch()
    names = [camera.name for camera in world.cameras]
    detector = DetectorChoice().load()
    station = CameraStation(world, seed, names, detector)
    simulator = Simulator(world, renderer=station.frames)
    stack = build_stack(
        world,
        localization=build_localization(world, world.robot.start_pose_in_world, seed),
        detector=station.detector,
        tracker=build_tracker(world),
    )
    watch.watch(station.frames.renderer, "render", lambda camera, _state: f"render {camera}")
    watch.watch(detector.proposer, "detect", "detect: ACF, one frame")
    assert detector.classifier is not None
    watch.watch(detector.classifier, "probabilities", "detect: CNN, one frame")
    watch_frames(station.detector, watch)
    watch.watch(stack.projection, "project", "project, one frame")
    watch.watch(stack.tracker, "update", "track")
    watch.watch(stack.situation, "update", "situation")
    for layer in stack.layers:
        watch.watch(layer, "apply", f"costmap: {layer.name}")
    watch.watch(stack.planner, "update", "plan")
    watch.watch(stack.follower, "follow", "follow")
    watch.watch(stack, "step", "whole stack step (with detection)")
    watch.watch(simulator, "step", "simulator step (with rendering)")
    run_episode(simulator, stack, duration=seconds, hooks=[Nothing()])
    simulated = simulator.truth.time
    rows = [
        (name, len(t), 1e3 * float(np.median(t)), 1e3 * float(np.percentile(t, 95)), 1e3 * sum(t) / simulated)
        for name, t in sorted(watch.times.items())
    ]
    rendered = sum(row[4] for row in rows if row[0].startswith("render"))
    physics = next(row[4] for row in rows if row[0].startswith("simulator")) - rendered
    rows.append(
        (
            "simulator without rendering (physics, people)",
            round(simulated / CONTROL_PERIOD),
            float("nan"),
            float("nan"),
            physics,
        )
    )
    simulator.close()
    station.frames.close()
    return markdown_table(("stage", "calls", "median [ms]", "95 % [ms]", "ms per simulated second"), rows)


def watch_frames(detector: CameraDetector, watch: Stopwatch) -> None:
    """Note how long whole frames take, by kind of camera and by whether the first stage was asked."""
    original = detector.detect

    def timed(frames: Sequence[Frame]) -> list[FrameDetections]:
        return [_look(frame) for frame in frames]

    def _look(frame: Frame) -> FrameDetections:
        asked = len(watch.times["detect: ACF, one frame"])
        started = time.perf_counter()
        (found,) = original([frame])
        took = time.perf_counter() - started
        looked = len(watch.times["detect: ACF, one frame"]) > asked
        camera = "ceiling" if frame.fixed else "onboard"
        watch.times[f"detect: {camera} frame, {'all stages' if looked else 'nothing changed'}"].append(took)
        return found

    detector.detect = timed  # type: ignore[method-assign]


def with_workers(world: World, seed: int, seconds: float, workers: int) -> tuple[float, float]:
    """Return simulated seconds and the wall-clock seconds they took with camera processes."""
    names = [camera.name for camera in world.cameras]
    with CameraWorkers(world, seed, names, DetectorChoice(), workers) as cameras:
        simulator = Simulator(world, renderer=cameras)
        stack = build_stack(
            world,
            localization=build_localization(world, world.robot.start_pose_in_world, seed),
            detector=cameras,
            tracker=build_tracker(world),
        )
        run_episode(simulator, stack, duration=0.5)  # compiled code loaded, backgrounds rendered
        stack = build_stack(
            world,
            localization=build_localization(world, world.robot.start_pose_in_world, seed),
            detector=cameras,
            tracker=build_tracker(world),
        )
        started = time.perf_counter()
        run_episode(simulator, stack, duration=seconds)
        took = time.perf_counter() - started
        simulated = simulator.truth.time
        simulator.close()
    return simulated, took


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--world", default="real2")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=10.0, help="simulated [s]")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args()
    world = vary(load_world(options.world), options.seed)
    print(f"### Stage timing: {options.world}, seed {options.seed}, {len(world.cameras)} cameras\n")
    print(f"{provenance()}\n")
    print(one_process(world, options.seed, options.seconds) + "\n")
    simulated, took = with_workers(world, options.seed, options.seconds, options.workers)
    rows = [(options.workers, simulated, took, simulated / took)]
    print(markdown_table(("camera processes", "simulated [s]", "wall clock [s]", "real-time factor, video off"), rows))


if __name__ == "__main__":
    main()
