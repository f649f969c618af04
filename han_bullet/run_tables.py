"""Tables of a run that pages and explanations both read: where everybody was, the tracks, what devices said."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from han_bullet.geometry import Array
from han_bullet.messages import DeviceMessage, Posture
from han_bullet.run_folder import Table


@dataclass(frozen=True)
class PersonWay:
    """Where a true person was.

    Attributes:
        name: As in the world file.
        poses: x, y [m], yaw [rad] at each tick, shape (n, 3).
        postures: At each tick.
    """

    name: str
    poses: Array
    postures: tuple[Posture, ...]

    @property
    def places(self) -> Array:
        """Return where they were at each tick, shape (n, 2) [m]."""
        return self.poses[:, :2]


@dataclass(frozen=True)
class Trace:
    """The truth of a run, tick by tick.

    Attributes:
        time: Shape (n,) [s].
        poses: Of the robot: x, y [m], yaw [rad], shape (n, 3).
        twists: Of the robot in its body: vx, vy [m/s], omega [rad/s], shape (n, 3).
        people: In the order of the world file.
    """

    time: Array
    poses: Array
    twists: Array
    people: tuple[PersonWay, ...]

    @property
    def speed(self) -> Array:
        """Return the robot's speed, shape (n,) [m/s]."""
        speed: Array = np.hypot(self.twists[:, 0], self.twists[:, 1])
        return speed

    def distances(self) -> Array:
        """Return the distances between the centres of robot and people, shape (people, n) [m]."""
        ways = np.array([person.places for person in self.people]).reshape(-1, len(self.time), 2)
        difference = ways - self.poses[:, :2]
        distances: Array = np.hypot(difference[..., 0], difference[..., 1])
        return distances


@dataclass(frozen=True)
class TrackRow:
    """A line of tracks.csv: id, and (x, y, vx, vy) [m], [m/s]."""

    id: int
    state: tuple[float, float, float, float]


def trace_of(table: Table, people: Sequence[str] | None = None) -> Trace:
    """Read trace.csv.

    Args:
        table: The file.
        people: Names of those who must be in it; None takes whoever is.

    Raises:
        BadInputError: A column is missing, or a cell is not what a run writes.
    """
    if people is None:
        people = [column.removesuffix(".posture") for column in table.columns if column.endswith(".posture")]
    ways = tuple(_way_of(table, name) for name in people)
    robot = table.numbers("time", *(f"robot.{name}" for name in ("x", "y", "yaw", "vx", "vy", "omega")))
    return Trace(robot[:, 0], robot[:, 1:4], robot[:, 4:], ways)


def tracks_of(table: Table) -> dict[int, list[TrackRow]]:
    """Read tracks.csv: tick -> what the stack believed of people; ticks without are missing.

    Raises:
        BadInputError: A column is missing, or a cell is not what a run writes.
    """
    found: dict[int, list[TrackRow]] = {}
    states = table.numbers("x", "y", "vx", "vy").tolist()
    rows = zip(table.ticks().tolist(), table.whole_numbers("id").tolist(), states, strict=True)
    for tick, identity, (x, y, vx, vy) in rows:
        found.setdefault(tick, []).append(TrackRow(identity, (x, y, vx, vy)))
    return found


def messages_of(table: Table) -> dict[int, list[DeviceMessage]]:
    """Read messages.csv: tick -> what devices said; ticks without are missing.

    Raises:
        BadInputError: A column is missing, or a cell is not what a run writes.
    """
    found: dict[int, list[DeviceMessage]] = {}
    devices, sessions = table.words("device"), table.words("session")
    rows = zip(table.ticks().tolist(), devices, table.numbers("sent", "on").tolist(), sessions, strict=True)
    for tick, device, (sent, on), session in rows:
        found.setdefault(tick, []).append(DeviceMessage(device, sent, on=bool(on), session=session))
    return found


def _way_of(table: Table, name: str) -> PersonWay:
    poses = table.numbers(*(f"{name}.{axis}" for axis in ("x", "y", "yaw")))
    postures = []
    for index, word in enumerate(table.words(f"{name}.posture")):
        try:
            postures.append(Posture(word))
        except ValueError as error:
            raise table.unreadable(index, str(error)) from error
    return PersonWay(name, poses, tuple(postures))
