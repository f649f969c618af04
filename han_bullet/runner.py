"""Run a world and leave a folder behind: its world as a file, result.json, thirteen tables and video.mp4."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from han_bullet.ablation import NoDetector, TrueLocalization, TruthTracker
from han_bullet.assembly import ASSOCIATIONS, build_localization, build_stack, build_tracker, known_devices
from han_bullet.assumptions import Scaled
from han_bullet.atomic_file import write_json
from han_bullet.camera_workers import CameraStation, CameraWorkers
from han_bullet.checks import Check, check_expectations, check_world
from han_bullet.costmap.layer import Layer
from han_bullet.detection.camera_detector import FrameDetector
from han_bullet.detection.detector import Detector
from han_bullet.detection.model_files import classifier_file, has_one_stage, is_shipped_proposer, model_name
from han_bullet.detector_choice import DetectorChoice
from han_bullet.device_channel import DeviceChannel, EmbeddedChannel
from han_bullet.episode import Hook, Operator, run_episode
from han_bullet.errors import BadInputError
from han_bullet.geometry import Pose2D
from han_bullet.known_devices import KnownDevices
from han_bullet.latency import Latency
from han_bullet.localization.localizer import Localization
from han_bullet.memory import peak_memory
from han_bullet.metrics import Metric, Metrics, written
from han_bullet.mirroring import OTHER_SIDE, mirrored
from han_bullet.noticed_faults import NoticedFault, NoticedFaults
from han_bullet.orders import GivenOrder, GivenOrders
from han_bullet.provenance import git_commit, sha256, versions
from han_bullet.recorder import (
    CommandsRecorder,
    DetectionsRecorder,
    EmptySeatsRecorder,
    FeetRecorder,
    FramesRecorder,
    LaserRecorder,
    LegsRecorder,
    MessagesRecorder,
    OdometryRecorder,
    PosesRecorder,
    StatusRecorder,
    TraceRecorder,
    TracksRecorder,
)
from han_bullet.rehearsal import rehearse
from han_bullet.sim.renderer import FrameSource
from han_bullet.sim.simulator import Simulator
from han_bullet.stack import NavigationStack
from han_bullet.tracking.tracker import PeopleTracker
from han_bullet.variation import vary
from han_bullet.world_file import find_world, load_world, save_world, world_files
from han_bullet.world_schema import InjectedFault, Sit, World

PERCEPTIONS = ("cameras", "truth")
LOCALIZATIONS = ("lidar", "truth")
NOT_CHECKED = "the robot was given orders, so its task was not the world's: no expectation was held against the run"


@dataclass(frozen=True)
class RunOptions:
    """How to run a world.

    Attributes:
        seed: Decides starts, speeds, delays, clothes, light, and the errors of images, odometry and laser.
        perception: "cameras", or "truth" for the ablation without detector and tracker.
        localization: "lidar", or "truth" for the ablation in which the simulator tells where the robot is.
        cameras: Names of the cameras in use; None takes all.
        association: "nnjpda", "nn" or "gnn".
        detector: Which shipped or own model.
        without: Costmap layers to leave out.
        pass_side: On which side the robot overtakes, "left" or "right"; in a mirrored world on the other.
        mirrored: Whether to run the world's mirror image at its x axis, with left for right.
        scaled: Assumptions that are made otherwise than the world has them.
        workers: Camera processes at most; 1 renders and detects in this process.
        video: Whether to write video.mp4.
        gui: Whether to open PyBullet's window.
        mqtt: Address of the broker through which devices speak, HOST[:PORT]; None keeps them in this process.
        faults: Of sensors, besides those that the world file has.
    """

    seed: int = 0
    perception: str = "cameras"
    localization: str = "lidar"
    cameras: tuple[str, ...] | None = None
    association: str = "nnjpda"
    detector: DetectorChoice = field(default_factory=DetectorChoice)
    without: tuple[str, ...] = ()
    pass_side: str = "left"
    mirrored: bool = False
    scaled: tuple[Scaled, ...] = ()
    workers: int = 2
    video: bool = True
    gui: bool = False
    mqtt: str | None = None
    faults: tuple[InjectedFault, ...] = ()

    def __post_init__(self) -> None:
        """Check what no other part checks."""
        if self.seed < 0 or self.workers < 1:
            raise BadInputError(f"seed is {self.seed} and workers is {self.workers}; at least 0 and 1 would be right")
        if self.localization not in LOCALIZATIONS:
            right = ", ".join(LOCALIZATIONS)
            raise BadInputError(f"localization is {self.localization!r}; one of {right} would be right")
        if self.perception not in PERCEPTIONS:
            raise BadInputError(f"perception is {self.perception!r}; one of {', '.join(PERCEPTIONS)} would be right")
        if self.association not in ASSOCIATIONS:
            right = ", ".join(ASSOCIATIONS)
            raise BadInputError(f"association is {self.association!r}; one of {right} would be right")
        if self.cameras is not None and (not self.cameras or len(set(self.cameras)) < len(self.cameras)):
            raise BadInputError(f"cameras are {list(self.cameras)}; at least one, each once, would be right")


@dataclass(frozen=True)
class RunResult:
    """What a run came to.

    Attributes:
        folder: Where its files are.
        metrics: Every number of the run.
        checks: The world's expectations, held against them.
        faults: Of sensors, as the robot noticed them.
        real_time_factor: Simulated seconds per second of the loop.
        gave_up: Why the robot gave up, in a sentence; None where it did not.
        orders: That an operator gave; with any, no expectation is held against the run.
    """

    folder: Path
    metrics: tuple[Metric, ...]
    checks: tuple[Check, ...]
    faults: tuple[NoticedFault, ...]
    real_time_factor: float
    gave_up: str | None
    orders: tuple[GivenOrder, ...] = ()


def run_world(
    name_or_path: str | Path,
    options: RunOptions,
    folder: Path,
    hooks: Sequence[Hook] = (),
    *,
    layers: Sequence[Layer] = (),
    detector: Detector | None = None,
    operator: Operator | None = None,
) -> RunResult:
    """Run a world to its end.

    Args:
        name_or_path: A shipped world's name or a YAML file.
        options: How.
        folder: For the files; made if need be, what an earlier run left there is replaced.
        hooks: Further onlookers, for example a progress bar.
        layers: Costmap layers of one's own, applied after the standard ones.
        detector: One's own detector of images instead of a shipped one; cameras are then rendered in this process.
        operator: Gives orders while it runs, and says when it is over; None leaves the robot to the world's task.

    Raises:
        BadInputError: The world, an option or a model cannot be used; nothing has been written then.
        WorkerDiedError: A camera process ended; what was written is whole.
    """
    started = time.perf_counter()
    concrete, start = _concrete(name_or_path, options)
    if options.mirrored:
        options = replace(options, pass_side=OTHER_SIDE.get(options.pass_side, options.pass_side))
    check_world(concrete, f"{find_world(name_or_path)} (seed {options.seed})")
    result = _describe(concrete, options, world_files(name_or_path))
    with contextlib.ExitStack() as closing:
        channel = _open_channel(options, closing)
        frames, people_finder, detector_description = _open_cameras(concrete, options, detector, closing)
        latency = Latency()
        watched = None if frames is None else latency.watched(frames)
        simulator = Simulator(concrete, renderer=watched, seed=options.seed, gui=options.gui, channel=channel)
        closing.callback(simulator.close)
        devices = known_devices(concrete, channel.session)
        unused = known_devices(concrete, channel.session)
        rehearse(_build(concrete, options, start, simulator, NoDetector(), (), unused), concrete)
        if isinstance(people_finder, CameraWorkers):  # which have been loading the detector in the meantime
            detector_description = (detector_description or {}) | {"threshold": people_finder.wait_until_ready()}
        stack = _build(concrete, options, start, simulator, people_finder, layers, devices)
        metrics, noticed, given = Metrics(concrete), NoticedFaults(), GivenOrders()
        recorders = _recorders(concrete, options, folder)
        prepared = time.perf_counter()
        onlookers = [latency, metrics, noticed, given, *recorders, *hooks]
        end = run_episode(simulator, stack, duration=concrete.duration, hooks=onlookers, operator=operator)
        finished = time.perf_counter()
        memory = peak_memory()
    results = metrics.results()
    checks = [] if given.orders else check_expectations(concrete.expectations, results)
    simulated, took = simulator.truth_time, finished - prepared
    result |= {
        "localization": stack.localization.name,
        "detector": detector_description,
        "devices": channel.name,
        "device_session": channel.session,
        "device_messages": dict(devices.counts),
        "layers": [layer.name for layer in stack.layers],
        "faults": [fault.as_json() for fault in noticed.faults],
        "outcome": next(metric.value for metric in results if metric.name == "outcome"),
        "outcome_detail": end.gave_up,
        "metrics": [asdict(replace(metric, value=written(metric.value))) for metric in results],
        "checks": [asdict(check) for check in checks],
        "timings": {
            "workers": _worker_count(concrete, options, detector),
            "simulated_s": round(simulated, 3),
            "loop_s": round(took, 3),
            "preparation_s": round(prepared - started, 3),
            "real_time_factor": round(simulated / took, 3),
            **latency.timings(),
            "peak_memory_mib": memory,
        },
    }
    if given.orders:
        result |= {"orders": [order.as_json() for order in given.orders], "checks_detail": NOT_CHECKED}
    write_json(folder / "result.json", result)
    factor = simulated / took
    return RunResult(folder, tuple(results), tuple(checks), noticed.faults, factor, end.gave_up, given.orders)


def _concrete(name_or_path: str | Path, options: RunOptions) -> tuple[World, Pose2D]:
    """Return the world as the options make it, and where the robot was meant to be put, before the seed moved it."""
    world = load_world(name_or_path)
    if options.cameras is not None:
        world = world.with_cameras(options.cameras)
    start, world = world.robot.start_pose_in_world, vary(world, options.seed)
    for assumption in options.scaled:
        world = assumption.apply(world)
    world = world.with_faults(options.faults)
    # Last, so that a seed's mirrored run is the mirror image of its run.
    if options.mirrored:
        return mirrored(world), Pose2D(start.x, -start.y, -start.yaw)
    return world, start


def _describe(world: World, options: RunOptions, sources: Sequence[Path]) -> dict[str, Any]:
    """Return what a result says of how it was made; asked for first, so that a run is not lost over it."""
    with_cameras = options.perception == "cameras"
    return {
        "world": world.name,
        "world_sha256": sha256(*sources),
        "seed": options.seed,
        "perception": options.perception,
        "localization": None,
        "cameras": [camera.name for camera in world.cameras] if with_cameras else [],
        "association": options.association if with_cameras else None,
        "detector": None,
        "devices": None,
        "device_session": None,
        "device_messages": {},
        "layers": [],
        "pass": options.pass_side,
        "mirrored": options.mirrored,
        "injected_faults": [fault.model_dump(mode="json") for fault in world.faults],
        "asked_faults": [fault.model_dump(mode="json") for fault in options.faults],
        "faults": [],
        "scaled": [str(assumption) for assumption in options.scaled],
        "versions": versions(),
        "git_commit": git_commit(),
    }


def _worker_count(world: World, options: RunOptions, detector: Detector | None) -> int:
    """Return the number of camera processes that are of use; 0 renders and detects in this process."""
    count = min(options.workers, len(world.cameras))
    return 0 if options.perception == "truth" or detector is not None or count <= 1 else count


def _open_channel(options: RunOptions, closing: contextlib.ExitStack) -> DeviceChannel:
    """Return the network of the devices."""
    if options.mqtt is None:
        return EmbeddedChannel()
    from han_bullet.mqtt_channel import MqttChannel

    return closing.enter_context(MqttChannel(options.mqtt))


def _open_cameras(
    world: World, options: RunOptions, own: Detector | None, closing: contextlib.ExitStack
) -> tuple[FrameSource | None, FrameDetector, dict[str, Any] | None]:
    """Return what renders, what detects, and what a result says of the detector."""
    if options.perception == "truth":
        return None, NoDetector(), None
    names = [camera.name for camera in world.cameras]
    if own is not None:
        station = CameraStation(world, options.seed, names, own)
        closing.callback(station.frames.close)
        return station.frames, station.detector, {"class": type(own).__name__}
    choice = options.detector
    if choice.threshold is None and is_shipped_proposer(choice.name):  # a world's threshold is for no other model
        choice = replace(choice, threshold=world.score_threshold)
    description = {
        "proposer": model_name(choice.name),
        "classifier": None if has_one_stage(choice.name) else classifier_file(choice.classifier).stem,
    }
    count = _worker_count(world, options, own)
    if count == 0:
        chosen = choice.load()
        station = CameraStation(world, options.seed, names, chosen)
        closing.callback(station.frames.close)
        return station.frames, station.detector, description | {"threshold": chosen.threshold}
    workers = closing.enter_context(CameraWorkers(world, options.seed, names, choice, count))
    return workers, workers, description


def _build(
    world: World,
    options: RunOptions,
    start: Pose2D,
    simulator: Simulator,
    detector: FrameDetector,
    layers: Sequence[Layer],
    devices: KnownDevices,
) -> NavigationStack:
    tracker: PeopleTracker
    if options.perception == "truth":
        seated = {p.name: p.behaviour.on for p in world.people if isinstance(p.behaviour, Sit)}
        tracker = TruthTracker(lambda: simulator.truth, seated)
    else:
        tracker = build_tracker(world, options.association)
    return build_stack(
        world,
        localization=_localization(world, options, start, simulator),
        detector=detector,
        tracker=tracker,
        without=options.without,
        pass_side=options.pass_side,
        layers=layers,
        devices=devices,
        sees=options.perception == "cameras",
    )


def _localization(world: World, options: RunOptions, start: Pose2D, simulator: Simulator) -> Localization:
    if options.localization == "truth":
        return TrueLocalization(lambda: simulator.truth)
    return build_localization(world, start, options.seed)


def _recorders(world: World, options: RunOptions, folder: Path) -> list[Hook]:
    """Make the folder, take away what an earlier run left, write the concrete world, and open the files."""
    folder.mkdir(parents=True, exist_ok=True)
    for stale in ("result.json", "video.mp4", "report.html"):
        (folder / stale).unlink(missing_ok=True)
    save_world(world, folder / "world.yaml", f"{world.name} as seed {options.seed} makes it, with the cameras in use")
    recorders: list[Hook] = [
        TraceRecorder(folder / "trace.csv", world),
        PosesRecorder(folder / "poses.csv"),
        OdometryRecorder(folder / "odometry.csv"),
        CommandsRecorder(folder / "commands.csv"),
        StatusRecorder(folder / "status.csv"),
        LaserRecorder(folder / "laser.csv", 0 if world.robot.laser is None else world.robot.laser.ray_count),
        TracksRecorder(folder / "tracks.csv"),
        FramesRecorder(folder / "frames.csv"),
        DetectionsRecorder(folder / "detections.csv"),
        FeetRecorder(folder / "feet.csv"),
        EmptySeatsRecorder(folder / "empty_seats.csv"),
        LegsRecorder(folder / "legs.csv"),
        MessagesRecorder(folder / "messages.csv", [device.name for device in world.devices]),
    ]
    if options.video:
        from han_bullet.video import VideoRecorder  # with matplotlib for its letters

        recorders.append(VideoRecorder(folder / "video.mp4", world, show_cameras=options.perception == "cameras"))
    return recorders
