"""The folder of a run, read: what it came to, the ways of robot, people and tracks, and the world it was in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from han_bullet.errors import BadInputError
from han_bullet.messages import DeviceMessage
from han_bullet.run_folder import ResultFile, Step, read_doings, read_result, read_table, steps_of
from han_bullet.run_tables import Trace, TrackRow, messages_of, trace_of, tracks_of
from han_bullet.world_file import load_world
from han_bullet.world_schema import CONTROL_PERIOD, World


@dataclass(frozen=True)
class Run:
    """A run as its folder tells it.

    Attributes:
        folder: Where it lies.
        result: Of result.json.
        trace: Of trace.csv.
        tracks: Tick -> what the stack believed of people.
        steps: What the robot tried where it could not go on.
        devices_on: When the robot was first told that a device is on [s], by its name.
        world: What the map shows; None where it is not known.
        no_map: Why it is not; else empty.
    """

    folder: Path
    result: ResultFile
    trace: Trace
    tracks: Mapping[int, Sequence[TrackRow]]
    steps: Sequence[Step]
    devices_on: Mapping[str, float]
    world: World | None
    no_map: str


def read_run_files(folder: Path) -> Run:
    """Read a run.

    Raises:
        BadInputError: A file is missing or is not what a run writes.
    """
    result, trace = read_result(folder), trace_of(read_table(folder / "trace.csv"))
    tracks, messages = tracks_of(read_table(folder / "tracks.csv")), messages_of(read_table(folder / "messages.csv"))
    steps = steps_of(read_doings(folder))
    return Run(folder, result, trace, tracks, steps, _devices_on(messages), *find_map(folder))


def _devices_on(messages: Mapping[int, Sequence[DeviceMessage]]) -> dict[str, float]:
    moments: dict[str, float] = {}
    for tick, said in messages.items():
        for message in said:
            if message.on:
                moments.setdefault(message.device, tick * CONTROL_PERIOD)
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
