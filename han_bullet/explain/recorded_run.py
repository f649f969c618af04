"""A finished run, read from its folder."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from han_bullet.errors import BadInputError
from han_bullet.explain.recorded_tables import (
    FrameRow,
    Image,
    commands_of,
    detections_of,
    empty_seats_of,
    feet_of,
    frames_of,
    legs_of,
    odometry_of,
    of_every_tick,
    poses_of,
    scans_of,
)
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.messages import (
    Detections,
    DeviceMessage,
    Fault,
    LaserScan,
    LegScan,
    Odometry,
    PoseEstimate,
    RecoveryStep,
    Status,
    TruePerson,
    Truth,
)
from han_bullet.run_folder import (
    Doing,
    OrderEntry,
    ResultFile,
    is_run,
    read_doings,
    read_result,
    read_table,
    steps_of,
)
from han_bullet.run_tables import PersonWay, Trace, TrackRow, messages_of, trace_of, tracks_of
from han_bullet.world_file import load_world
from han_bullet.world_schema import CONTROL_PERIOD, World

TABLES = (
    "trace.csv",
    "poses.csv",
    "odometry.csv",
    "commands.csv",
    "status.csv",
    "laser.csv",
    "tracks.csv",
    "frames.csv",
    "detections.csv",
    "feet.csv",
    "empty_seats.csv",
    "legs.csv",
    "messages.csv",
)
FILES = ("result.json", "world.yaml", *TABLES)


@dataclass(frozen=True)
class RecordedRun:
    """What a run left behind; ticks count from 0.

    Attributes:
        folder: Of the run.
        world: The concrete one, with the cameras that were in use.
        result: Of result.json.
        truths: Robot and people of each tick; velocities only in a run with true perception.
        poses: Where the robot believed itself to be, by tick.
        odometry: What the wheels told, by tick.
        commands: What the robot was told to do then, by tick.
        scans: Tick -> what the laser measured.
        frames: Tick -> which frames arrived.
        detections: (tick of the exposure, camera) -> what was found in that frame; frames that showed nothing are
            missing.
        legs: Tick -> what the laser said of people; ticks without are missing.
        messages: Tick -> what devices said.
        tracks: Tick -> what the stack believed of people.
        doings: What the robot was up to, and what it tried where it could not go on; one per change.
    """

    folder: Path
    world: World
    result: ResultFile
    truths: tuple[Truth, ...]
    poses: Mapping[int, PoseEstimate]
    odometry: Mapping[int, Odometry]
    commands: Mapping[int, Twist2D]
    scans: Mapping[int, LaserScan]
    frames: Mapping[int, Sequence[FrameRow]]
    detections: Mapping[Image, Detections]
    legs: Mapping[int, LegScan]
    messages: Mapping[int, Sequence[DeviceMessage]]
    tracks: Mapping[int, Sequence[TrackRow]]
    doings: Sequence[Doing]

    @property
    def sees(self) -> bool:
        """Tell whether cameras looked, rather than the simulator telling where people are."""
        return self.result.perception == "cameras"

    def tick_at(self, time: float) -> int:
        """Return the last tick at or before a time [s].

        Raises:
            BadInputError: The run has no such time.
        """
        end = self.truths[-1].time
        if not 0.0 <= time <= end + CONTROL_PERIOD:
            raise BadInputError(f"time is {time:g} s; the run {str(self.folder)!r} lasts from 0 to {end:g} s")
        return min(int(time / CONTROL_PERIOD + 1e-6), len(self.truths) - 1)

    def orders_at(self, number: int) -> list[OrderEntry]:
        """Return the orders that the decision of a tick was the first to know of."""
        return [order for order in self.result.orders if round(order.time / CONTROL_PERIOD) == number]

    def doing_at(self, time: float) -> tuple[Status, RecoveryStep | None] | None:
        """Return what the robot was up to at a time [s], and what it tried if it could not go on; None: not written."""
        status, step = next(((s, step) for since, s, step in reversed(self.doings) if since <= time), (None, None))
        return None if status is None else (status, step)

    def faults_at(self, time: float) -> tuple[Fault, ...]:
        """Return what the robot had noticed of its sensors at a time [s]."""
        noticed = (fault for fault in self.result.faults if fault.since <= time + 1e-6)
        open_ = (fault for fault in noticed if fault.until is None or time < fault.until - 1e-6)
        return tuple(Fault(fault.sensor, fault.kind, fault.since) for fault in open_)

    def step_at(self, time: float) -> tuple[float, RecoveryStep] | None:
        """Return since when [s] the robot tried what at a time [s]; None where it could go on."""
        steps = steps_of([doing for doing in self.doings if doing[0] <= time])
        since, step = steps[-1] if steps else (0.0, None)
        return None if step is None else (since, step)


def read_run(folder: Path) -> RecordedRun:
    """Read a run.

    Raises:
        BadInputError: The folder is missing, is no run's, lacks files, or one of them cannot be read.
    """
    if not folder.is_dir():
        raise BadInputError(f"run {str(folder)!r} is no folder; one that `han-bullet run` made would be right")
    missing = [name for name in FILES if not (folder / name).is_file()]
    if not is_run(folder):
        raise BadInputError(f"{str(folder)!r} holds no result.json; the folder of a finished run would be right")
    if missing:
        raise BadInputError(
            f"run {str(folder)!r} lacks {', '.join(missing)}, as one of another version does; run its world again"
        )
    result = read_result(folder)
    world = load_world(folder / "world.yaml")
    tracks = tracks_of(read_table(folder / "tracks.csv"))
    table = read_table(folder / "trace.csv")
    trace = trace_of(table, [person.name for person in world.people])
    of_every_tick(table)
    truths = _truths(trace, tracks if result.perception == "truth" else {})
    feet, seats = feet_of(read_table(folder / "feet.csv")), empty_seats_of(read_table(folder / "empty_seats.csv"))
    detections = detections_of(read_table(folder / "detections.csv"), feet, seats)
    return RecordedRun(
        folder,
        world,
        result,
        truths,
        poses_of(of_every_tick(read_table(folder / "poses.csv"), len(truths))),
        odometry_of(of_every_tick(read_table(folder / "odometry.csv"), len(truths))),
        commands_of(of_every_tick(read_table(folder / "commands.csv"), len(truths))),
        scans_of(read_table(folder / "laser.csv")),
        frames_of(read_table(folder / "frames.csv")),
        detections,
        legs_of(read_table(folder / "legs.csv")),
        messages_of(read_table(folder / "messages.csv")),
        tracks,
        read_doings(folder),
    )


def _truths(trace: Trace, tracks: Mapping[int, Sequence[TrackRow]]) -> tuple[Truth, ...]:
    """Return the trace by tick; a true person's velocity is that of the track with their number, where there is one."""
    people = [list(_person(way, number, tracks)) for number, way in enumerate(trace.people)]
    rows = zip(trace.time.tolist(), trace.poses.tolist(), trace.twists.tolist(), strict=True)
    return tuple(
        Truth(time, Pose2D(*pose), Twist2D(*twist), tuple(person[tick] for person in people))
        for tick, (time, pose, twist) in enumerate(rows)
    )


def _person(way: PersonWay, number: int, tracks: Mapping[int, Sequence[TrackRow]]) -> Iterator[TruePerson]:
    """Yield a true person at every tick."""
    for tick, (pose, posture) in enumerate(zip(way.poses.tolist(), way.postures, strict=True)):
        velocity = next((track.state[2:] for track in tracks.get(tick, ()) if track.id == number), (0.0, 0.0))
        yield TruePerson(way.name, Pose2D(*pose), np.array(velocity), posture)
