"""A finished run, read from its folder."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Pose2D, Twist2D
from han_bullet.messages import (
    Detections,
    DeviceMessage,
    Fault,
    ImageHealth,
    LaserScan,
    LegScan,
    Odometry,
    PoseEstimate,
    Posture,
    RecoveryStep,
    Status,
    TruePerson,
    Truth,
)
from han_bullet.recorder import (
    COMMANDS_HEADER,
    DETECTIONS_HEADER,
    FRAMES_HEADER,
    LASER_HEADER,
    LEGS_HEADER,
    ODOMETRY_HEADER,
    POSES_HEADER,
    ray_columns,
)
from han_bullet.run_folder import (
    Doing,
    OrderEntry,
    ResultFile,
    Table,
    is_run,
    read_doings,
    read_result,
    read_table,
    steps_of,
)
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
Image = tuple[int, str]  # tick of the exposure, and camera


@dataclass(frozen=True)
class TrackRow:
    """A line of tracks.csv: id, and (x, y, vx, vy) [m], [m/s]."""

    id: int
    state: tuple[float, float, float, float]


@dataclass(frozen=True)
class FrameRow:
    """A line of frames.csv: which camera's frame of which time [s] arrived, and what its pixels told."""

    camera: str
    exposed: float
    health: ImageHealth | None = None


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
    tracks = _tracks(read_table(folder / "tracks.csv"))
    truths = _truths(read_table(folder / "trace.csv"), world, tracks if result.perception == "truth" else {})
    feet, seats = _feet(read_table(folder / "feet.csv")), _empty_seats(read_table(folder / "empty_seats.csv"))
    detections = _detections(read_table(folder / "detections.csv"), feet, seats)
    return RecordedRun(
        folder,
        world,
        result,
        truths,
        _poses(_of_every_tick(read_table(folder / "poses.csv"), len(truths))),
        _odometry(_of_every_tick(read_table(folder / "odometry.csv"), len(truths))),
        _commands(_of_every_tick(read_table(folder / "commands.csv"), len(truths))),
        _scans(read_table(folder / "laser.csv")),
        _frames(read_table(folder / "frames.csv")),
        detections,
        _legs(read_table(folder / "legs.csv")),
        _messages(read_table(folder / "messages.csv")),
        tracks,
        read_doings(folder),
    )


def _of_every_tick(table: Table, count: int | None = None) -> Table:
    """Return a table if it has a row per tick: as many as there are, where that is known."""
    ticks = table.ticks().tolist()
    if ticks != list(range(len(ticks) if count is None else count)) or not ticks:
        end = "..." if count is None else f"..., {(count - 1) * CONTROL_PERIOD:g}"
        raise BadInputError(
            f"{table.path}: its times are not 0, {CONTROL_PERIOD:g}, {end} s; a row per tick would be right"
        )
    return table


def _tracks(table: Table) -> dict[int, list[TrackRow]]:
    found: dict[int, list[TrackRow]] = {}
    states = table.numbers("x", "y", "vx", "vy").tolist()
    rows = zip(table.ticks().tolist(), table.whole_numbers("id").tolist(), states, strict=True)
    for tick, identity, (x, y, vx, vy) in rows:
        found.setdefault(tick, []).append(TrackRow(identity, (x, y, vx, vy)))
    return found


def _messages(table: Table) -> dict[int, list[DeviceMessage]]:
    found: dict[int, list[DeviceMessage]] = {}
    sent_on = table.numbers("sent", "on").tolist()
    rows = zip(table.ticks().tolist(), table.words("device"), sent_on, table.words("session"), strict=True)
    for tick, device, (sent, on), session in rows:
        found.setdefault(tick, []).append(DeviceMessage(device, sent, on=bool(on), session=session))
    return found


def _poses(table: Table) -> dict[int, PoseEstimate]:
    rows = table.numbers(*POSES_HEADER).tolist()
    estimates = (
        PoseEstimate(time, Pose2D(x, y, yaw), _symmetric(upper), lost=bool(lost))
        for time, x, y, yaw, lost, *upper in rows
    )
    return dict(zip(table.ticks().tolist(), estimates, strict=True))


def _symmetric(upper: Sequence[float]) -> Array:
    """Return the symmetric matrix, shape (3, 3), of the numbers of its upper triangle, row by row."""
    matrix = np.zeros((3, 3))
    matrix[np.triu_indices(3)] = upper
    matrix.T[np.triu_indices(3)] = upper
    return matrix


def _odometry(table: Table) -> dict[int, Odometry]:
    rows = table.numbers(*ODOMETRY_HEADER).tolist()
    values = (Odometry(time, Pose2D(x, y, yaw), Twist2D(vx, vy, omega)) for time, x, y, yaw, vx, vy, omega in rows)
    return dict(zip(table.ticks().tolist(), values, strict=True))


def _commands(table: Table) -> dict[int, Twist2D]:
    twists = (Twist2D(*row) for row in table.numbers(*COMMANDS_HEADER[1:]).tolist())
    return dict(zip(table.ticks().tolist(), twists, strict=True))


def _frames(table: Table) -> dict[int, list[FrameRow]]:
    found: dict[int, list[FrameRow]] = {}
    exposed = table.numbers("exposed")[:, 0].tolist()
    told = zip(*(table.words(name) for name in FRAMES_HEADER[3:]), strict=True)
    rows = zip(table.ticks().tolist(), table.words("camera"), exposed, told, strict=True)
    for index, (tick, camera, time, (checksum, *numbers)) in enumerate(rows):
        try:
            brightness, contrast, right, down = map(float, numbers) if checksum else (0.0,) * 4
            health = ImageHealth(int(checksum), brightness, contrast, (right, down)) if checksum else None
        except ValueError as error:
            raise table.unreadable(index, str(error)) from error
        found.setdefault(tick, []).append(FrameRow(camera, time, health))
    return found


def _scans(table: Table) -> dict[int, LaserScan]:
    rays = len(table.columns) - len(LASER_HEADER)
    rows = zip(table.ticks().tolist(), table.numbers(*LASER_HEADER, *ray_columns(rays)), strict=True)
    found = {}
    for tick, row in rows:
        time, start, increment, nearest, farthest, *place = row[: len(LASER_HEADER)].tolist()
        ranges = row[len(LASER_HEADER) :]
        found[tick] = LaserScan(time, ranges, start, increment, nearest, farthest, Pose2D(*place))
    return found


def _detections(
    table: Table, feet: Mapping[Image, Mapping[int, float]], seats: Mapping[Image, tuple[str, ...]]
) -> dict[Image, Detections]:
    """Gather the boxes of each frame, as the detector ordered them, with known feet and the seats seen empty."""
    frames: dict[Image, list[list[float]]] = {image: [] for image in seats}
    boxes = table.numbers(*DETECTIONS_HEADER[2:]).tolist()
    for tick, camera, box in zip(table.ticks().tolist(), table.words("camera"), boxes, strict=True):
        frames.setdefault((tick, camera), []).append(box)
    found = {}
    for image, rows in frames.items():
        known, of_frame = feet.get(image, {}), np.array(rows).reshape(-1, len(DETECTIONS_HEADER) - 2)
        ends = np.array([known.get(number, math.nan) for number in range(len(rows))])
        found[image] = Detections(
            of_frame[:, :4], of_frame[:, 4], of_frame[:, 5], feet=ends, empty_seats=seats.get(image, ())
        )
    return found


def _empty_seats(table: Table) -> dict[Image, tuple[str, ...]]:
    found: dict[Image, tuple[str, ...]] = {}
    for tick, camera, seat in zip(table.ticks().tolist(), table.words("camera"), table.words("seat"), strict=True):
        found[tick, camera] = (*found.get((tick, camera), ()), seat)
    return found


def _feet(table: Table) -> dict[Image, dict[int, float]]:
    """Gather the rows of known feet [px] of each frame, by the number of their box."""
    frames: dict[Image, dict[int, float]] = {}
    ends, numbers = table.numbers("row")[:, 0].tolist(), table.whole_numbers("detection").tolist()
    for tick, camera, number, row in zip(table.ticks().tolist(), table.words("camera"), numbers, ends, strict=True):
        frames.setdefault((tick, camera), {})[number] = row
    return frames


def _legs(table: Table) -> dict[int, LegScan]:
    """Gather what the laser said at each tick: measurements, and the people whose place was empty."""
    times = {tick: time for tick, (time,) in zip(table.ticks().tolist(), table.numbers("time").tolist(), strict=True)}
    measured: dict[int, list[list[float]]] = {tick: [] for tick in times}
    vacant: dict[int, tuple[int, ...]] = dict.fromkeys(times, ())
    columns = (table.words(name) for name in LEGS_HEADER[1:])
    for index, (tick, *cells, person) in enumerate(zip(table.ticks().tolist(), *columns, strict=True)):
        try:
            if person:
                vacant[tick] = (*vacant[tick], int(person))
            else:
                measured[tick].append([float(cell) for cell in cells])
        except ValueError as error:
            raise table.unreadable(index, str(error)) from error
    return {tick: _leg_scan(time, measured[tick], vacant[tick]) for tick, time in times.items()}


def _leg_scan(time: float, rows: Sequence[Sequence[float]], vacant: tuple[int, ...]) -> LegScan:
    x, y, right, up, correlation = np.array(rows).reshape(-1, 5).T
    both = correlation * right * up
    covariances = np.array([[right**2, both], [both, up**2]]).transpose(2, 0, 1)
    return LegScan(time, np.column_stack([x, y]), covariances, vacant)


def _truths(table: Table, world: World, tracks: Mapping[int, Sequence[TrackRow]]) -> tuple[Truth, ...]:
    """Read the trace; a true person's velocity is that of the track with their number, where there is one."""
    people = [_person(table, person.name, number, tracks) for number, person in enumerate(world.people)]
    robots = table.numbers(*(f"robot.{name}" for name in ("x", "y", "yaw", "vx", "vy", "omega"))).tolist()
    times = _of_every_tick(table).numbers("time")[:, 0].tolist()
    return tuple(
        Truth(time, Pose2D(*robot[:3]), Twist2D(*robot[3:]), tuple(person[tick] for person in people))
        for tick, (time, robot) in enumerate(zip(times, robots, strict=True))
    )


def _person(table: Table, name: str, number: int, tracks: Mapping[int, Sequence[TrackRow]]) -> list[TruePerson]:
    """Return a true person at every tick."""
    poses = table.numbers(*(f"{name}.{axis}" for axis in ("x", "y", "yaw"))).tolist()
    found = []
    for tick, (pose, word) in enumerate(zip(poses, table.words(f"{name}.posture"), strict=True)):
        velocity = next((track.state[2:] for track in tracks.get(tick, ()) if track.id == number), (0.0, 0.0))
        try:
            found.append(TruePerson(name, Pose2D(*pose), np.array(velocity), Posture(word)))
        except ValueError as error:
            raise table.unreadable(tick, str(error)) from error
    return found
