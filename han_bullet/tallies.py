"""The numbers of a run that need only the truth: how the robot moved, what it touched, how it met people.

Each tally looks at every tick and gives its values by name at the end; metrics.py says what each name means. Thresholds
stand here once, and the definitions quote them.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from han_bullet.episode import Tick
from han_bullet.geometry import Array
from han_bullet.messages import Posture, Status, TruePerson
from han_bullet.world_schema import CONTROL_PERIOD

Value = float | int | str | bool | None

STILL_SPEED = 0.05  # [m/s]: below it robot and people count as standing; ten times the jitter of a held base
NEW_CONTACT_AFTER = 0.5  # [s] without touch; a body that bounces or slides along a wall is one contact
PERSON_RADIUS = 0.25  # [m] of a person's body disc, as in the costmap
LEVEL_WITHIN = 2.5  # [m] between centres; farther away two bodies are not passing each other
PERSONAL_SPACE = 0.5  # of g1 or g2, whose peak at the person is 1
WALKING_DEVIATION = 0.8  # [m] ahead of a walking person, at least; [s] times their speed above 1 s [Kirby2010]
STILL_DEVIATION = 0.56  # [m]: falls to 0.1 at 1.2 m, the edge of Hall's personal distance [Hall1966]
TIME_SLACK = 1e-6  # [s] for comparing sums of control periods


class Tally(ABC):
    """A group of numbers that grows with every tick."""

    @abstractmethod
    def record(self, tick: Tick) -> None:
        """Take note of one tick."""

    @abstractmethod
    def values(self) -> dict[str, Value]:
        """Return what has been counted so far, by metric name."""


def person_walks(person: TruePerson) -> bool:
    """Tell whether a true person moves at more than `STILL_SPEED`."""
    return math.hypot(*person.velocity_in_world) > STILL_SPEED


def personal_space(person: TruePerson, point_in_world: Array) -> float:
    """Return how deep a point, (2,) [m], lies in a person's personal space: g1 or g2, in [0, 1] [Mateus2019].

    exp(-u^2 / (2 b^2) - v^2 / (2 s^2)) with u forward and v sideways in the person's frame. Walking (g1):
    b = B ahead and B/2 behind, s = 2B/3, B = max(speed, 0.8). Otherwise (g2): b = s = 0.56 m.
    """
    forward, sideways = person.pose_in_world.to_body(point_in_world)
    if person.posture is Posture.WALKING:
        ahead = max(math.hypot(*person.velocity_in_world), WALKING_DEVIATION)
        along, across = (ahead if forward > 0.0 else 0.5 * ahead), 2.0 * ahead / 3.0
    else:
        along = across = STILL_DEVIATION
    return math.exp(-0.5 * (forward / along) ** 2 - 0.5 * (sideways / across) ** 2)


class MotionTally(Tally):
    """How the robot moved and how its task ended."""

    _NAMES = (
        "outcome",
        "time_to_goal",
        "path_length",
        "mean_speed",
        "max_speed",
        "max_acceleration",
        "stalled_time",
        "cumulative_heading_change",
    )

    def __init__(self) -> None:
        self._statuses: list[Status] = []
        self._rows: list[tuple[float, ...]] = []  # time, x, y, yaw, velocity in the world

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        pose, twist = tick.truth.pose_robot_in_world, tick.truth.twist_robot_in_body
        self._statuses.append(tick.decision.status)
        self._rows.append((tick.truth.time, pose.x, pose.y, pose.yaw, *twist.linear_in_world(pose.yaw)))

    def values(self) -> dict[str, Value]:
        """Return outcome, durations, lengths and speeds."""
        if not self._rows:
            return dict.fromkeys(self._NAMES)
        time, x, y, yaw, vx, vy = np.array(self._rows).T
        speed = np.hypot(vx, vy)
        acceleration = np.hypot(np.diff(vx), np.diff(vy)) / np.diff(time)
        turns = (np.diff(yaw) + math.pi) % (2.0 * math.pi) - math.pi
        arrival = self._arrival()
        values: tuple[Value, ...] = (
            self._outcome(),
            None if arrival is None else float(time[arrival] - time[0]),
            float(np.hypot(np.diff(x), np.diff(y)).sum()),
            float(speed.mean()),
            float(speed.max()),
            float(acceleration.max(initial=0.0)),
            _stalled_ticks(speed[:arrival]) * CONTROL_PERIOD,
            float(np.abs(turns).sum()),
        )
        return dict(zip(self._NAMES, values, strict=True))

    def _arrival(self) -> int | None:
        """Return the first tick that has arrived."""
        return self._statuses.index(Status.ARRIVED) if Status.ARRIVED in self._statuses else None

    def _outcome(self) -> str:
        if self._arrival() is not None:
            return "arrived"
        return "blocked" if self._statuses[-1] is Status.BLOCKED else "timeout"


def _stalled_ticks(speed: Array) -> int:
    """Count the slow ticks after the first quick one; `speed` has shape (n,) [m/s]."""
    slow = speed < STILL_SPEED
    return int(slow[int(np.argmin(slow)) :].sum()) if not slow.all() else 0


class ContactTally(Tally):
    """What the robot touched."""

    def __init__(self) -> None:
        self._last: dict[tuple[str, str], float] = {}
        self._counts: Counter[str] = Counter()

    def record(self, tick: Tick) -> None:
        """Count the contacts that begin; each body's own, so that two people at once are two."""
        for contact in tick.truth.contacts:
            key = (contact.kind, contact.body)
            if tick.truth.time - self._last.get(key, -math.inf) > NEW_CONTACT_AFTER - TIME_SLACK:
                self._counts[contact.kind] += 1
            self._last[key] = tick.truth.time

    def values(self) -> dict[str, Value]:
        """Return one count per kind of body."""
        return {f"contacts_{kind}": self._counts[kind] for kind in ("person", "wall", "object")}


@dataclass
class _Encounter:
    """One person and the robot, so far."""

    distance: float = math.inf
    forward: float = math.nan  # of the robot in the person's frame at the last tick [m]
    side: str = "none"
    distance_when_level: float | None = None

    def update(self, person: TruePerson, robot_in_world: Array) -> None:
        distance = person.pose_in_world.distance_to(robot_in_world)
        forward, lateral = person.pose_in_world.to_body(robot_in_world)
        self.distance = min(self.distance, distance)
        if self.forward < 0.0 <= forward and person_walks(person) and distance <= LEVEL_WITHIN:
            self.side = "left" if lateral > 0.0 else "right"
            self.distance_when_level = distance
        self.forward = float(forward)


class EncounterTally(Tally):
    """How near the robot came to each person, and on which side it overtook.

    Args:
        people: Names, for metrics that exist also where nothing was recorded.
        robot_radius: Of the footprint [m].
    """

    def __init__(self, people: Sequence[str], robot_radius: float) -> None:
        self._encounters = {name: _Encounter() for name in people}
        self._reach = robot_radius + PERSON_RADIUS
        self._ticks = 0
        self._intruding = 0

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        robot = tick.truth.pose_robot_in_world.position
        for person in tick.truth.people:
            self._encounters[person.name].update(person, robot)
        self._ticks += 1
        self._intruding += any(personal_space(person, robot) > PERSONAL_SPACE for person in tick.truth.people)

    def values(self) -> dict[str, Value]:
        """Return distances, sides and the share of time in somebody's personal space."""
        values: dict[str, Value] = {"personal_space_share": self._intruding / self._ticks if self._ticks else None}
        for name, encounter in self._encounters.items():
            values[f"minimum_distance.{name}"] = encounter.distance
            values[f"minimum_gap.{name}"] = encounter.distance - self._reach
            values[f"overtaking_side.{name}"] = encounter.side
            values[f"distance_when_level.{name}"] = encounter.distance_when_level
        return values
