"""The folder of a run, read: what it came to, the ways of robot, people and tracks, and the world it was in."""

from __future__ import annotations

import csv
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from han_bullet.errors import BadInputError, quoted
from han_bullet.geometry import Array
from han_bullet.messages import RecoveryStep
from han_bullet.world_file import load_world
from han_bullet.world_schema import World

Value = float | int | str | bool | None


class _Entry(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True)


class MetricEntry(_Entry):
    """A figure in result.json."""

    name: str
    value: Value
    unit: str
    definition: str


class CheckEntry(_Entry):
    """An expectation in result.json."""

    metric: str
    expected: str
    value: Value
    passed: bool


class ResultFile(_Entry):
    """What result.json says, as far as a report shows it."""

    world: str
    world_sha256: str
    seed: int
    perception: str
    localization: str | None
    cameras: tuple[str, ...]
    association: str | None
    detector: dict[str, Any] | None
    layers: tuple[str, ...]
    pass_side: str = Field(alias="pass")
    mirrored: bool
    scaled: tuple[str, ...]
    versions: dict[str, str]
    git_commit: str
    outcome: str
    outcome_detail: str | None = None
    metrics: tuple[MetricEntry, ...]
    checks: tuple[CheckEntry, ...]
    timings: dict[str, float | int | None]

    def metric(self, name: str) -> MetricEntry | None:
        """Return a metric by its name."""
        return next((metric for metric in self.metrics if metric.name == name), None)


@dataclass(frozen=True)
class PersonWay:
    """Where a true person was.

    Attributes:
        name: As in the world file.
        places: At each tick, shape (n, 2) [m].
        postures: One word per tick.
    """

    name: str
    places: Array
    postures: tuple[str, ...]


@dataclass(frozen=True)
class Trace:
    """The truth of a run, tick by tick.

    Attributes:
        time: Shape (n,) [s].
        poses: Of the robot: x, y [m], yaw [rad], shape (n, 3).
        speed: Of the robot, shape (n,) [m/s].
        people: In the order of the world file.
    """

    time: Array
    poses: Array
    speed: Array
    people: tuple[PersonWay, ...]

    def distances(self) -> Array:
        """Return the distances between the centres of robot and people, shape (people, n) [m]."""
        ways = np.array([person.places for person in self.people]).reshape(-1, len(self.time), 2)
        difference = ways - self.poses[:, :2]
        distances: Array = np.hypot(difference[..., 0], difference[..., 1])
        return distances


@dataclass(frozen=True)
class Run:
    """A run as its folder tells it.

    Attributes:
        folder: Where it lies.
        result: Of result.json.
        trace: Of trace.csv.
        tracks: Of tracks.csv: per moment with any, the track ids, shape (k,), and places, shape (k, 2) [m].
        steps: When [s] the robot began what, since it could not go on, and None when it could again.
        devices_on: When the robot was first told that a device is on [s], by its name.
        world: What the map shows; None where it is not known.
    """

    folder: Path
    result: ResultFile
    trace: Trace
    tracks: Mapping[float, tuple[Array, Array]]
    steps: Sequence[tuple[float, RecoveryStep | None]]
    devices_on: Mapping[str, float]
    world: World | None


def is_run(folder: Path) -> bool:
    """Tell whether a folder holds a finished run."""
    return (folder / "result.json").is_file()


def read_run(folder: Path) -> Run:
    """Read a run.

    Raises:
        BadInputError: A file is missing or is not what a run writes.
    """
    result = read_result(folder)
    trace, tracks, devices_on = read_trace(folder), _read_tracks(folder), _read_devices_on(folder)
    return Run(folder, result, trace, tracks, _read_steps(folder), devices_on, find_map(folder))


def read_result(folder: Path) -> ResultFile:
    """Read result.json; see `read_run`."""
    path = folder / "result.json"
    try:
        return ResultFile.model_validate_json(path.read_text(encoding="utf-8"))
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(map(str, first["loc"])) or "the document"
        raise BadInputError(f"{path}: {field}: {first['msg']}; a file that `han-bullet run` wrote is needed") from error
    except (OSError, UnicodeDecodeError) as error:
        raise BadInputError(f"{path}: not readable: {quoted(error)}") from error


def read_trace(folder: Path) -> Trace:
    """Read trace.csv; see `read_run`."""
    header, rows = _read_table(folder / "trace.csv")
    columns = dict(zip(header, zip(*rows, strict=True), strict=True)) if rows else {}
    try:
        time, x, y, yaw, vx, vy = (
            np.array(columns[name], float)
            for name in ("time", "robot.x", "robot.y", "robot.yaw", "robot.vx", "robot.vy")
        )
        names = [name.removesuffix(".posture") for name in header if name.endswith(".posture")]
        people = tuple(
            PersonWay(
                name,
                np.array([columns[f"{name}.x"], columns[f"{name}.y"]], float).T,
                tuple(columns[f"{name}.posture"]),
            )
            for name in names
        )
    except (KeyError, ValueError) as error:
        raise BadInputError(f"{folder / 'trace.csv'}: no trace of a run ({quoted(error)})") from error
    return Trace(time, np.column_stack([x, y, yaw]), np.hypot(vx, vy), people)


def _read_tracks(folder: Path) -> dict[float, tuple[Array, Array]]:
    header, rows = _read_table(folder / "tracks.csv")
    by_time: defaultdict[float, list[tuple[float, float, float]]] = defaultdict(list)
    try:
        time, identity, x, y = (header.index(name) for name in ("time", "id", "x", "y"))
        for row in rows:
            by_time[float(row[time])].append((float(row[identity]), float(row[x]), float(row[y])))
    except (ValueError, IndexError) as error:
        raise BadInputError(f"{folder / 'tracks.csv'}: no tracks of a run ({quoted(error)})") from error
    tables = {moment: np.array(found) for moment, found in by_time.items()}
    return {moment: (found[:, 0], found[:, 1:]) for moment, found in tables.items()}


def _read_steps(folder: Path) -> list[tuple[float, RecoveryStep | None]]:
    """Return the changes of the recovery's step; the run begins without one."""
    header, rows = _read_table(folder / "status.csv")
    steps: list[tuple[float, RecoveryStep | None]] = [(0.0, None)]
    try:
        time, name = (header.index(name) for name in ("time", "step"))
        for row in rows:
            step = RecoveryStep[row[name].upper()] if row[name] else None
            if step is not steps[-1][1]:
                steps.append((float(row[time]), step))
    except (ValueError, KeyError) as error:
        raise BadInputError(f"{folder / 'status.csv'}: no statuses of a run ({quoted(error)})") from error
    return steps[1:]


def _read_devices_on(folder: Path) -> dict[str, float]:
    header, rows = _read_table(folder / "messages.csv")
    moments: dict[str, float] = {}
    try:
        time, device, on = (header.index(name) for name in ("time", "device", "on"))
        for row in rows:
            if row[on] == "1":
                moments.setdefault(row[device], float(row[time]))
    except ValueError as error:
        raise BadInputError(f"{folder / 'messages.csv'}: no messages of a run ({quoted(error)})") from error
    return moments


def _read_table(path: Path) -> tuple[list[str], Sequence[Sequence[str]]]:
    """Return header and rows of a table; a last line that is not whole is left out."""
    try:
        with path.open(encoding="utf-8", newline="") as file:
            header, *rows = csv.reader(file)
    except (OSError, UnicodeDecodeError, csv.Error, ValueError) as error:
        raise BadInputError(f"{path}: not readable as a table of a run: {quoted(error)}") from error
    return header, [row for row in rows if len(row) == len(header)]


def find_map(folder: Path) -> World | None:
    """Return the world of a run, as it was for its seed, from the run's folder; None where no copy of it is left."""
    try:
        return load_world(folder / "world.yaml")
    except BadInputError:
        return None
