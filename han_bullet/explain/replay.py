"""A run over again: the stack fed with the boxes, poses and messages of its files; no pictures, no physics."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from han_bullet.ablation import NoDetector, TruthTracker
from han_bullet.assembly import build_stack, build_tracker, known_devices
from han_bullet.costmap.layers import STANDARD
from han_bullet.coverage import empty_image
from han_bullet.detection.camera_detector import FrameDetector
from han_bullet.device_payload import write_payload
from han_bullet.episode import Tick
from han_bullet.explain.recorded_run import RecordedRun, TrackRow
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.localization.localizer import Localization
from han_bullet.messages import (
    Detections,
    Frame,
    FrameDetections,
    LaserScan,
    LegScan,
    Observation,
    Odometry,
    PoseEstimate,
    Scan,
    TrackedPerson,
    Truth,
)
from han_bullet.stack import NavigationStack
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
        looks: Camera -> its last frame; cameras without one are missing.
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
        self.name = str(run.settings["localization"])
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

    def detect(self, frames: Sequence[Frame]) -> list[FrameDetections]:
        """Return the recorded boxes of each frame."""
        recorded = self._run.detections
        ticks = [round(frame.time / CONTROL_PERIOD) for frame in frames]
        boxes = [recorded.get((tick, f.camera), Detections.none()) for tick, f in zip(ticks, frames, strict=True)]
        return [found.at(frame.camera, frame.time) for found, frame in zip(boxes, frames, strict=True)]


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


def replay(run: RecordedRun, time: float) -> Replay:
    """Run the stack on a run's files up to a time [s].

    Raises:
        BadInputError: The run has no such time.
    """
    last = run.tick_at(time)
    stack = _stack(run)
    looks: dict[str, Look] = {}
    differences = []
    for number, truth in enumerate(run.truths[: last + 1]):
        observation = _observation(run, number)
        decision = stack.step(observation)
        looks |= {s.camera: Look(f, s, truth) for f, s in zip(decision.detections, decision.scans, strict=True)}
        differences.append(_apart(decision.people, run.tracks.get(number, ())))
    first = next((number for number, apart in enumerate(differences) if apart > AGREEMENT), None)
    return Replay(
        run,
        stack,
        Tick(observation, decision, truth),
        looks,
        max(differences),
        None if first is None else run.truths[first].time,
    )


def _stack(run: RecordedRun) -> NavigationStack:
    world, settings = run.world, run.settings
    tracker: PeopleTracker
    if run.sees:
        tracker = build_tracker(world, settings["association"])
    else:
        seated = {p.name: p.behaviour.on for p in world.people if isinstance(p.behaviour, Sit)}
        tracker = TruthTracker(iter(run.truths).__next__, seated)
    return build_stack(
        world,
        localization=RecordedLocalization(run),
        detector=RecordedDetector(run) if run.sees else NoDetector(),
        tracker=tracker,
        leg_finder=RecordedLegs(run),
        without=[layer.name for layer in STANDARD if layer.name not in settings["layers"]],
        pass_side=settings["pass"],
        devices=known_devices(world, settings["device_session"]),
    )


def _observation(run: RecordedRun, number: int) -> Observation:
    """Return what the robot sensed at a tick, with images that have no pixels; where it was is known, not odometry."""
    truth = run.truths[number]
    due = [camera for camera in run.world.cameras if run.sees and number % camera.ticks_per_frame == 0]
    images = tuple(empty_image(camera, truth.time) for camera in due)
    messages = tuple(map(write_payload, run.messages.get(number, ())))
    nowhere = Odometry(truth.time, Pose2D(0.0, 0.0, 0.0), Twist2D())
    return Observation(truth.time, nowhere, None, images, messages)


def _apart(people: Sequence[TrackedPerson], recorded: Sequence[TrackRow]) -> float:
    """Return the largest difference between tracks and recorded ones [m], [m/s]; infinite between other ids."""
    if [person.id for person in people] != [row.id for row in recorded]:
        return math.inf
    states = [(*person.position_in_world, *person.velocity_in_world) for person in people]
    differences = np.abs(np.array(states) - np.array([row.state for row in recorded]))
    return float(differences.max(initial=0.0))
