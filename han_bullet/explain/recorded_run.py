"""A finished run, read from its folder."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from han_bullet.errors import BadInputError, quoted
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.messages import Detections, DeviceMessage, LegScan, PoseEstimate, Posture, TruePerson, Truth
from han_bullet.recorder import (
    DETECTIONS_HEADER,
    FEET_HEADER,
    LEGS_HEADER,
    MESSAGES_HEADER,
    POSES_HEADER,
    TRACKS_HEADER,
)
from han_bullet.world_file import load_world
from han_bullet.world_schema import CONTROL_PERIOD, World

FILES = (
    "result.json",
    "world.yaml",
    "trace.csv",
    "poses.csv",
    "tracks.csv",
    "detections.csv",
    "feet.csv",
    "legs.csv",
    "messages.csv",
)
Row = dict[str, str]
Value = TypeVar("Value")
SETTINGS = ("perception", "association", "layers", "pass", "seed", "localization", "device_session", "git_commit")


@dataclass(frozen=True)
class TrackRow:
    """A line of tracks.csv: id, and (x, y, vx, vy) [m], [m/s]."""

    id: int
    state: tuple[float, float, float, float]


@dataclass(frozen=True)
class RecordedRun:
    """What a run left behind; ticks count from 0.

    Attributes:
        folder: Of the run.
        world: The concrete one, with the cameras that were in use.
        settings: The run's result.json.
        truths: Robot and people of each tick; velocities only in a run with true perception.
        poses: Where the robot believed itself to be, by tick.
        detections: (tick, camera) -> the boxes of that frame; frames without boxes are missing.
        legs: Tick -> what the laser said of people; ticks without are missing.
        messages: Tick -> what devices said.
        tracks: Tick -> what the stack believed of people.
    """

    folder: Path
    world: World
    settings: Mapping[str, Any]
    truths: tuple[Truth, ...]
    poses: Mapping[int, PoseEstimate]
    detections: Mapping[tuple[int, str], Detections]
    legs: Mapping[int, LegScan]
    messages: Mapping[int, Sequence[DeviceMessage]]
    tracks: Mapping[int, Sequence[TrackRow]]

    @property
    def sees(self) -> bool:
        """Tell whether cameras looked, rather than the simulator telling where people are."""
        return bool(self.settings["perception"] == "cameras")

    def tick_at(self, time: float) -> int:
        """Return the last tick at or before a time [s].

        Raises:
            BadInputError: The run has no such time.
        """
        end = self.truths[-1].time
        if not 0.0 <= time <= end + CONTROL_PERIOD:
            raise BadInputError(f"time is {time:g} s; the run {str(self.folder)!r} lasts from 0 to {end:g} s")
        return min(int(time / CONTROL_PERIOD + 1e-6), len(self.truths) - 1)


def read_run(folder: Path) -> RecordedRun:
    """Read a run.

    Raises:
        BadInputError: The folder is missing, is no run's, lacks files, or one of them cannot be read.
    """
    if not folder.is_dir():
        raise BadInputError(f"run {str(folder)!r} is no folder; one that `han-bullet run` made would be right")
    missing = [name for name in FILES if not (folder / name).is_file()]
    if "result.json" in missing:
        raise BadInputError(f"{str(folder)!r} holds no result.json; the folder of a finished run would be right")
    if missing:
        raise BadInputError(
            f"run {str(folder)!r} lacks {', '.join(missing)}, as one of another version does; run its world again"
        )
    settings = _settings(folder / "result.json")
    world = load_world(folder / "world.yaml")
    tracks = _by_tick(_rows(folder / "tracks.csv", TRACKS_HEADER, _track))
    truths = _truths(folder / "trace.csv", world, tracks if settings["perception"] == "truth" else {})
    return RecordedRun(
        folder,
        world,
        settings,
        truths,
        dict(_rows(folder / "poses.csv", POSES_HEADER, _pose)),
        _detections(folder / "detections.csv", _feet(folder / "feet.csv")),
        _legs(folder / "legs.csv"),
        _by_tick(_rows(folder / "messages.csv", MESSAGES_HEADER, _message)),
        tracks,
    )


def _settings(path: Path) -> dict[str, Any]:
    try:
        settings = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, OSError) as error:
        raise BadInputError(f"{path}: not readable as JSON: {quoted(error)}") from error
    missing = [name for name in SETTINGS if not isinstance(settings, dict) or name not in settings]
    if missing:
        raise BadInputError(f"{path}: has no {missing[0]!r}; the result of `han-bullet run` would be right")
    return dict(settings)


def _rows(path: Path, header: Sequence[str], parse: Callable[[Row], Value]) -> Iterator[tuple[int, Value]]:
    """Return the tick and the value of each line; `time` is the first column of every table."""
    with path.open(encoding="utf-8", newline="") as file:
        lines = csv.DictReader(file)
        try:
            missing = sorted(set(header) - set(lines.fieldnames or ()))
            if missing:
                raise BadInputError(f"{path}: has no column {missing[0]!r}; a run of this version writes it")
            for row in lines:
                yield round(float(row["time"]) / CONTROL_PERIOD), parse(row)
        except (ValueError, TypeError, KeyError, OverflowError, csv.Error) as error:
            raise BadInputError(f"{path}: line {lines.line_num} cannot be read: {quoted(error)}") from error


def _by_tick(rows: Iterable[tuple[int, Value]]) -> dict[int, list[Value]]:
    found: dict[int, list[Value]] = {}
    for tick, value in rows:
        found.setdefault(tick, []).append(value)
    return found


def _numbers(row: Row, *columns: str) -> list[float]:
    return [float(row[column]) for column in columns]


def _track(row: Row) -> TrackRow:
    x, y, vx, vy = _numbers(row, "x", "y", "vx", "vy")
    return TrackRow(int(row["id"]), (x, y, vx, vy))


def _pose(row: Row) -> PoseEstimate:
    time, x, y, yaw = _numbers(row, "time", "x", "y", "yaw")
    return PoseEstimate(time, Pose2D(x, y, yaw), lost=bool(int(row["lost"])))


def _message(row: Row) -> DeviceMessage:
    return DeviceMessage(row["device"], float(row["sent"]), on=bool(int(row["on"])), session=row["session"])


def _detections(path: Path, feet: Mapping[tuple[int, str], Mapping[int, float]]) -> dict[tuple[int, str], Detections]:
    """Gather the boxes of each frame, in the order in which the detector gave them, with the rows of known feet."""
    frames: dict[tuple[int, str], list[list[float]]] = {}
    columns = DETECTIONS_HEADER[2:]
    for tick, (camera, box) in _rows(path, DETECTIONS_HEADER, lambda row: (row["camera"], _numbers(row, *columns))):
        frames.setdefault((tick, camera), []).append(box)
    tables = {key: np.array(boxes) for key, boxes in frames.items()}
    found = {}
    for key, table in tables.items():
        known = feet.get(key, {})
        rows = np.array([known.get(number, math.nan) for number in range(len(table))])
        found[key] = Detections(table[:, :4], table[:, 4], table[:, 5], feet=rows)
    return found


def _feet(path: Path) -> dict[tuple[int, str], dict[int, float]]:
    """Gather the rows of known feet [px] of each frame, by the number of their box."""
    frames: dict[tuple[int, str], dict[int, float]] = {}
    parsed = _rows(path, FEET_HEADER, lambda row: (row["camera"], int(row["detection"]), float(row["row"])))
    for tick, (camera, number, row) in parsed:
        frames.setdefault((tick, camera), {})[number] = row
    return frames


def _legs(path: Path) -> dict[int, LegScan]:
    """Gather what the laser said at each tick: measurements, and the people whose place was empty."""
    found = {}
    for tick, rows in _by_tick(_rows(path, LEGS_HEADER, _leg_row)).items():
        table = np.array([numbers for _, numbers, vacant in rows if vacant is None]).reshape(-1, 5)
        x, y, right, up, correlation = table.T
        both = correlation * right * up
        covariances = np.array([[right**2, both], [both, up**2]]).transpose(2, 0, 1)
        vacant = tuple(vacant for _, _, vacant in rows if vacant is not None)
        found[tick] = LegScan(rows[0][0], np.column_stack([x, y]), covariances, vacant)
    return found


def _leg_row(row: Row) -> tuple[float, list[float], int | None]:
    """Return the time [s], what is measured in the order of the header, and whose place is empty."""
    if row["vacant"]:
        return float(row["time"]), [], int(row["vacant"])
    return float(row["time"]), _numbers(row, *LEGS_HEADER[1:6]), None


def _truths(path: Path, world: World, tracks: Mapping[int, Sequence[TrackRow]]) -> tuple[Truth, ...]:
    """Read the trace; a true person's velocity is that of the track with their number, where there is one."""

    def truth(row: Row) -> Truth:
        time = float(row["time"])
        velocities = {track.id: track.state[2:] for track in tracks.get(round(time / CONTROL_PERIOD), ())}
        people = tuple(
            TruePerson(
                person.name,
                Pose2D(*_numbers(row, *(f"{person.name}.{name}" for name in ("x", "y", "yaw")))),
                np.array(velocities.get(number, (0.0, 0.0))),
                Posture(row[f"{person.name}.posture"]),
            )
            for number, person in enumerate(world.people)
        )
        robot = _numbers(row, *(f"robot.{name}" for name in ("x", "y", "yaw", "vx", "vy", "omega")))
        return Truth(time, Pose2D(*robot[:3]), Twist2D(*robot[3:]), people)

    rows = list(_rows(path, ("time", "robot.x", *(f"{person.name}.x" for person in world.people)), truth))
    if [tick for tick, _ in rows] != list(range(len(rows))) or not rows:
        raise BadInputError(f"{path}: its times are not 0, {CONTROL_PERIOD:g}, ... s; a row per tick would be right")
    return tuple(one for _, one in rows)
