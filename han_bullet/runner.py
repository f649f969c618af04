"""Run a world and leave a folder behind: result.json, trace.csv, tracks.csv, detections.csv, video.mp4."""

from __future__ import annotations

import contextlib
import math
import os
import platform
import resource
import subprocess
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from han_bullet.ablation import NoDetector, TruthTracker
from han_bullet.assembly import build_stack, build_tracker
from han_bullet.atomic_file import write_json
from han_bullet.camera_workers import CameraStation, CameraWorkers, DetectorChoice
from han_bullet.checks import Check, check_expectations, check_world
from han_bullet.detection.detector import Detector
from han_bullet.episode import Hook, run_episode
from han_bullet.metrics import Metric, Metrics
from han_bullet.recorder import DetectionsRecorder, TraceRecorder, TracksRecorder
from han_bullet.sim.renderer import FrameSource
from han_bullet.sim.simulator import Simulator
from han_bullet.stack import NavigationStack
from han_bullet.variation import vary
from han_bullet.video import VideoRecorder
from han_bullet.world_file import find_world, load_world
from han_bullet.world_schema import Sit, World

LIBRARIES = ("numpy", "scipy", "numba", "opencv-python-headless", "pybullet", "torch", "filterpy")


@dataclass(frozen=True)
class RunOptions:
    """How to run a world.

    Attributes:
        seed: Decides starts, speeds, delays, clothes, light and image noise.
        perception: "cameras", or "truth" for the ablation without detector and tracker.
        cameras: Names of the cameras in use; None takes all.
        association: "nnjpda", "nn" or "gnn".
        detector: Which detector.
        without: Costmap layers to leave out.
        pass_side: On which side the robot overtakes, "left" or "right".
        workers: Camera processes; 1 renders and detects in this process.
        video: Whether to write video.mp4.
        gui: Whether to open PyBullet's window.
    """

    seed: int = 0
    perception: str = "cameras"
    cameras: tuple[str, ...] | None = None
    association: str = "nnjpda"
    detector: DetectorChoice = field(default_factory=DetectorChoice)
    without: tuple[str, ...] = ()
    pass_side: str = "left"
    workers: int = 2
    video: bool = True
    gui: bool = False


@dataclass(frozen=True)
class RunResult:
    """What a run came to.

    Attributes:
        folder: Where its files are.
        metrics: Every number of the run.
        checks: The world's expectations, held against them.
        real_time_factor: Simulated seconds per second of the loop.
    """

    folder: Path
    metrics: tuple[Metric, ...]
    checks: tuple[Check, ...]
    real_time_factor: float


def run_world(name_or_path: str | Path, options: RunOptions, folder: Path, hooks: Sequence[Hook] = ()) -> RunResult:
    """Run a world to its end.

    Args:
        name_or_path: A shipped world's name or a YAML file.
        options: How.
        folder: For the files; made if need be.
        hooks: Further onlookers, for example a progress bar.

    Raises:
        BadInputError: The world, an option or a model cannot be used; nothing has been written then.
        WorkerDiedError: A camera process ended; what was written is whole.
    """
    started = time.perf_counter()
    world = load_world(name_or_path)
    if options.cameras is not None:
        world = world.model_copy(update={"cameras": tuple(world.camera(name) for name in options.cameras)})
    concrete = vary(world, options.seed)
    check_world(concrete, f"{find_world(name_or_path)} (seed {options.seed})")
    with contextlib.ExitStack() as stack_of_contexts:
        frames, detector = _open_cameras(concrete, options, stack_of_contexts)
        simulator = Simulator(concrete, renderer=frames, gui=options.gui)
        stack_of_contexts.callback(simulator.close)
        stack = _build(concrete, options, simulator, detector)
        metrics = Metrics(concrete)
        check_expectations(world.expectations, metrics.results())
        folder.mkdir(parents=True, exist_ok=True)
        recorders = _recorders(concrete, options, folder)
        prepared = time.perf_counter()
        run_episode(simulator, stack, duration=world.duration, hooks=[metrics, *recorders, *hooks])
        finished = time.perf_counter()
        peak_memory = _peak_memory()
    results = metrics.results()
    checks = check_expectations(world.expectations, results)
    simulated = simulator.truth_time
    result = {
        "world": world.name,
        "seed": options.seed,
        "perception": options.perception,
        "localization": simulator.localization_name,
        "cameras": [camera.name for camera in world.cameras] if options.perception == "cameras" else [],
        "association": options.association if options.perception == "cameras" else None,
        "detector": asdict(options.detector) if options.perception == "cameras" else None,
        "layers": [layer.name for layer in stack.layers],
        "pass": options.pass_side,
        "versions": _versions(),
        "git_commit": _git_commit(),
        "outcome": next(metric.value for metric in results if metric.name == "outcome"),
        "metrics": [asdict(replace(metric, value=_plain(metric.value))) for metric in results],
        "checks": [asdict(replace(check, value=_plain(check.value))) for check in checks],
        "timings": {
            "workers": options.workers if options.perception == "cameras" else 0,
            "simulated_s": round(simulated, 3),
            "loop_s": round(finished - prepared, 3),
            "preparation_s": round(prepared - started, 3),
            "real_time_factor": round(simulated / (finished - prepared), 3),
            "peak_memory_mib": peak_memory,
        },
    }
    write_json(folder / "result.json", result)
    return RunResult(folder, tuple(results), tuple(checks), simulated / (finished - prepared))


def _open_cameras(
    world: World, options: RunOptions, contexts: contextlib.ExitStack
) -> tuple[FrameSource | None, Detector]:
    """Return what renders and what detects: nothing, this process, or worker processes."""
    if options.perception == "truth":
        return None, NoDetector()
    names = [camera.name for camera in world.cameras]
    if options.workers <= 1:
        station = CameraStation(world, options.seed, names, options.detector)
        contexts.callback(station.frames.close)
        return station.frames, station.detector
    workers = contexts.enter_context(CameraWorkers(world, options.seed, names, options.detector, options.workers))
    workers.wait_until_ready()
    return workers, workers


def _build(world: World, options: RunOptions, simulator: Simulator, detector: Detector) -> NavigationStack:
    if options.perception == "truth":
        seated = {p.name: p.behaviour.on for p in world.people if isinstance(p.behaviour, Sit)}
        tracker: TruthTracker | Any = TruthTracker(lambda: simulator.truth, seated)
    else:
        tracker = build_tracker(world, options.association)
    return build_stack(world, detector=detector, tracker=tracker, without=options.without, pass_side=options.pass_side)


def _recorders(world: World, options: RunOptions, folder: Path) -> list[Hook]:
    recorders: list[Hook] = [
        TraceRecorder(folder / "trace.csv", world),
        TracksRecorder(folder / "tracks.csv"),
        DetectionsRecorder(folder / "detections.csv"),
    ]
    if options.video:
        recorders.append(VideoRecorder(folder / "video.mp4", world, show_cameras=options.perception == "cameras"))
    return recorders


def _plain(value: float | int | str | bool | None) -> float | int | str | bool | None:
    """Round floats to a micro-unit; what is not a number becomes None."""
    if isinstance(value, float):
        return round(value, 6) if math.isfinite(value) else None
    return value


def _versions() -> dict[str, str]:
    own = {"han_bullet": version("han_bullet"), "python": platform.python_version()}
    return own | {library: version(library) for library in LIBRARIES}


def _git_commit() -> str:
    """Return the commit of the checkout this runs from, or "unknown" for an installed copy."""
    command = ["git", "-C", str(Path(__file__).parent), "rev-parse", "HEAD"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def _peak_memory() -> int:
    """Return the sum of the peaks of this process and of its children that are still running [MiB]."""
    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return round((own + sum(map(_peak_of, _children()))) / 1024)


def _children() -> list[str]:
    own = os.getpid()
    try:
        return Path(f"/proc/{own}/task/{own}/children").read_text().split()
    except OSError:
        return []


def _peak_of(process: str) -> int:
    try:
        lines = Path(f"/proc/{process}/status").read_text().splitlines()
    except OSError:
        return 0
    return next((int(line.split()[1]) for line in lines if line.startswith("VmHWM")), 0)
