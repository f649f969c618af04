"""The folder of a run, read: what it came to, the ways of robot, people and tracks, and the world it was in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array
from han_bullet.run_folder import ResultFile, Step, read_doings, read_result, read_table, steps_of
from han_bullet.world_file import load_world
from han_bullet.world_schema import World


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
        steps: What the robot tried where it could not go on.
        devices_on: When the robot was first told that a device is on [s], by its name.
        world: What the map shows; None where it is not known.
        no_map: Why it is not; else empty.
    """

    folder: Path
    result: ResultFile
    trace: Trace
    tracks: Mapping[float, tuple[Array, Array]]
    steps: Sequence[Step]
    devices_on: Mapping[str, float]
    world: World | None
    no_map: str


def read_run(folder: Path) -> Run:
    """Read a run.

    Raises:
        BadInputError: A file is missing or is not what a run writes.
    """
    result = read_result(folder)
    trace, tracks, devices_on = read_trace(folder), _read_tracks(folder), _read_devices_on(folder)
    return Run(folder, result, trace, tracks, steps_of(read_doings(folder)), devices_on, *find_map(folder))


def read_trace(folder: Path) -> Trace:
    """Read trace.csv; see `read_run`."""
    table = read_table(folder / "trace.csv")
    time, x, y, yaw, vx, vy = table.numbers("time", "robot.x", "robot.y", "robot.yaw", "robot.vx", "robot.vy").T
    people = tuple(
        PersonWay(name, table.numbers(f"{name}.x", f"{name}.y"), tuple(table.words(f"{name}.posture")))
        for name in (column.removesuffix(".posture") for column in table.columns if column.endswith(".posture"))
    )
    return Trace(time, np.column_stack([x, y, yaw]), np.hypot(vx, vy), people)


def _read_tracks(folder: Path) -> dict[float, tuple[Array, Array]]:
    found = read_table(folder / "tracks.csv").numbers("time", "id", "x", "y")
    moments, starts = np.unique(found[:, 0], return_index=True)  # lines are in the order of time
    parts = np.split(found, starts[1:])
    return {float(moment): (part[:, 1], part[:, 2:]) for moment, part in zip(moments, parts, strict=False)}


def _read_devices_on(folder: Path) -> dict[str, float]:
    table = read_table(folder / "messages.csv")
    moments: dict[str, float] = {}
    (times,) = table.numbers("time").T
    for time, device, on in zip(times.tolist(), table.words("device"), table.words("on"), strict=True):
        if on == "1":
            moments.setdefault(device, time)
    return moments


def find_map(folder: Path) -> tuple[World | None, str]:
    """Return the world of a run, as it was for its seed, from the run's folder; or None, and why there is none."""
    path = folder / "world.yaml"
    if not path.is_file():
        return None, f"{folder.name} has no world.yaml"
    try:
        return load_world(path), ""
    except BadInputError as error:
        return None, str(error)
