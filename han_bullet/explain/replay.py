"""A run over again: the stack fed with the boxes, poses and messages of its files; no pictures, no physics."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from han_bullet.ablation import NoDetector, TruthTracker
from han_bullet.assembly import build_stack, build_tracker, known_devices
from han_bullet.control.recovery import Clearable, Recovering, Recovery
from han_bullet.costmap.layers import STANDARD
from han_bullet.coverage import empty_image
from han_bullet.detection.camera_detector import FrameDetector
from han_bullet.device_payload import write_payload
from han_bullet.episode import Tick
from han_bullet.explain.recorded_run import RecordedRun
from han_bullet.explain.recorded_tables import FrameRow
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.localization.localizer import Localization
from han_bullet.messages import (
    CameraImage,
    Detections,
    Frame,
    FrameDetections,
    GoTo,
    HandOver,
    LaserScan,
    LegScan,
    Observation,
    Odometry,
    PoseEstimate,
    RecoveryStep,
    Scan,
    Status,
    TrackedPerson,
    Truth,
)
from han_bullet.run_folder import OrderEntry
from han_bullet.run_tables import TrackRow
from han_bullet.stack import Decision, NavigationStack
from han_bullet.tracking.legs import LegFinder
from han_bullet.tracking.tracker import PeopleTracker
from han_bullet.world_schema import CONTROL_PERIOD, Sit

# Tracks of files with six decimals agree to this [m], [m/s].
AGREEMENT = 1e-4


@dataclass(frozen=True)
class Look:
    """The last frame of a camera and what came of it.

    Attributes:
        found: Its boxes.
        scan: The same on the floor, with the frame and the robot's pose at that time.
        truth: Of the exposure.
    """

    found: FrameDetections
    scan: Scan
    truth: Truth


@dataclass(frozen=True)
class Replay:
    """The stack as it was at some time of a run.

    Attributes:
        run: What was replayed.
        stack: After the last tick.
        tick: The last one.
        looks: Camera -> its last frame of use; cameras without one are missing.
        difference: Largest between a replayed and a recorded track [m], [m/s].
        differs_since: First tick [s] with other ids, or with more than `AGREEMENT` between tracks; None: none.
    """

    run: RecordedRun
    stack: NavigationStack
    tick: Tick
    looks: dict[str, Look]
    difference: float
    differs_since: float | None


class RecordedLocalization(Localization):
    """Believes at each tick what was believed then during a run.

    Args:
        run: The run.
    """

    def __init__(self, run: RecordedRun) -> None:
        self.name = str(run.result.localization)
        self._poses = run.poses

    def update(self, odometry: Odometry, scan: LaserScan | None) -> PoseEstimate:
        """Return the recorded pose."""
        return self._poses[round(odometry.time / CONTROL_PERIOD)]

    def relocalize(self) -> None:
        """Do nothing: what was believed is written."""


class RecordedDetector(FrameDetector):
    """Finds in each frame what was found there during a run.

    Args:
        run: The run.
    """

    def __init__(self, run: RecordedRun) -> None:
        self._run = run
        rows = [row for frames in run.frames.values() for row in frames]
        self._health = {(round(row.exposed / CONTROL_PERIOD), row.camera): row.health for row in rows}

    def detect(self, frames: Sequence[Frame]) -> list[FrameDetections]:
        """Return the recorded boxes of each frame, and what its pixels told."""
        return [self._look(frame) for frame in frames]

    def _look(self, frame: Frame) -> FrameDetections:
        key = (round(frame.time / CONTROL_PERIOD), frame.camera)
        found = self._run.detections.get(key, Detections.none())
        return found.at(frame.camera, frame.time, self._health.get(key))


class RecordedLegs(LegFinder):
    """Says of people what the laser said during a run.

    Args:
        run: The run.
    """

    def __init__(self, run: RecordedRun) -> None:
        self._legs = run.legs

    def find(self, scan: LaserScan | None, estimate: PoseEstimate, people: Sequence[TrackedPerson]) -> LegScan | None:
        """Return what is written of that tick."""
        return self._legs.get(round(estimate.time / CONTROL_PERIOD))


class RecordedRecovery(Recovery):
    """Does when it cannot go on what was done during a run, and says what was said; a replay moves nothing.

    Args:
        run: The run.
        obstacles: What is told to forget when it was.
    """

    def __init__(self, run: RecordedRun, obstacles: Sequence[Clearable]) -> None:
        super().__init__(relocalize=lambda: None, obstacles=obstacles)
        self._run = run
        self._step: RecoveryStep | None = None
        self._was_lost = False

    def update(self, estimate: PoseEstimate, status: Status) -> Recovering:
        """Return the recorded status and step; where nothing is written, what the stack says."""
        then, step = self._run.doing_at(estimate.time) or (status, None)
        found = self._was_lost and not estimate.lost
        if found or (step is RecoveryStep.CLEAR and self._step is not step):
            self.clear()
        self._step, self._was_lost = step, estimate.lost
        return then, step, None


def replay(run: RecordedRun, time: float) -> Replay:
    """Run the stack on a run's files up to a time [s].

    Raises:
        BadInputError: The run has no such time.
    """
    last = run.tick_at(time)
    stack = recorded_stack(run)
    looks: dict[str, Look] = {}
    differences = []
    for number in range(last + 1):
        observation = recorded_observation(run, number)
        decision = decide_again(run, stack, observation)
        looks |= _looks(run, decision)
        differences.append(_apart(decision.people, run.tracks.get(number, ())))
    first = next((number for number, apart in enumerate(differences) if apart > AGREEMENT), None)
    return Replay(
        run,
        stack,
        Tick(observation, decision, run.truths[last]),
        looks,
        max(differences),
        None if first is None else run.truths[first].time,
    )


def _looks(run: RecordedRun, decision: Decision) -> dict[str, Look]:
    """Return what each camera had that gave a frame of use, with the truth of its exposure."""
    found = {detections.camera: detections for detections in decision.detections}
    exposed = {scan.camera: run.truths[round(scan.time / CONTROL_PERIOD)] for scan in decision.scans}
    return {scan.camera: Look(found[scan.camera], scan, exposed[scan.camera]) for scan in decision.scans}


def recorded_stack(run: RecordedRun) -> NavigationStack:
    """Return the stack of a run, which believes, finds and says what was believed, found and said then."""
    world, result = run.world, run.result
    tracker: PeopleTracker
    if run.sees:
        tracker = build_tracker(world, str(result.association))
    else:
        seated = {p.name: p.behaviour.on for p in world.people if isinstance(p.behaviour, Sit)}
        tracker = TruthTracker(iter(run.truths).__next__, seated)
    stack = build_stack(
        world,
        localization=RecordedLocalization(run),
        detector=RecordedDetector(run) if run.sees else NoDetector(),
        tracker=tracker,
        leg_finder=RecordedLegs(run),
        without=[layer.name for layer in STANDARD if layer.name not in result.layers],
        pass_side=result.pass_side,
        devices=known_devices(world, result.device_session),
        sees=run.sees,
        own_senses=False,
    )
    stack.recovery = RecordedRecovery(run, [layer for layer in stack.layers if isinstance(layer, Clearable)])
    return stack


def decide_again(run: RecordedRun, stack: NavigationStack, observation: Observation) -> Decision:
    """Return the decision on an observation of a run, given the orders that were given then."""
    for order in run.orders_at(round(observation.time / CONTROL_PERIOD)):
        _give(stack, order)
    return stack.step(observation)


def _give(stack: NavigationStack, order: OrderEntry) -> None:
    """Give the stack an order again; a hand-over to somebody by the place where they were, as tracks may differ."""
    if order.pose is not None:
        stack.take(GoTo(Pose2D(*order.pose)))
    elif order.place is not None and order.distance is not None:
        stack.take(HandOver(np.array(order.place), order.distance))
    elif order.order == "cancel":
        stack.cancel()
    elif order.order == "clear_obstacles":
        stack.clear_obstacles()
    elif order.order == "drive":
        stack.override(Twist2D(), hold=0.0)


def recorded_observation(run: RecordedRun, number: int) -> Observation:
    """Return what the robot sensed at a tick, with images that have no pixels."""
    truth = run.truths[number]
    images = tuple(_image(run, row) for row in run.frames.get(number, ()))
    messages = tuple(map(write_payload, run.messages.get(number, ())))
    return Observation(truth.time, run.odometry[number], run.scans.get(number), images, messages)


def _image(run: RecordedRun, row: FrameRow) -> CameraImage:
    """Return an image without pixels."""
    return empty_image(run.world.camera(row.camera), row.exposed)


def _apart(people: Sequence[TrackedPerson], recorded: Sequence[TrackRow]) -> float:
    """Return the largest difference between tracks and recorded ones [m], [m/s]; infinite between other ids."""
    if [person.id for person in people] != [row.id for row in recorded]:
        return math.inf
    states = [(*person.position_in_world, *person.velocity_in_world) for person in people]
    differences = np.abs(np.array(states) - np.array([row.state for row in recorded]))
    return float(differences.max(initial=0.0))
