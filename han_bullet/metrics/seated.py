"""What people who sit and watch put up with: the robot behind them, and before their television."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import ClassVar

from han_bullet.episode import Tick
from han_bullet.geometry import Array
from han_bullet.messages import Posture, Seat, TruePerson
from han_bullet.metrics.tally import Definition, Definitions, Tally, Value
from han_bullet.world_schema import CONTROL_PERIOD

BEHIND_DEVIATION = 1.2  # [m] behind a seated person's back [Mateus2019]
BESIDE_DEVIATION = 0.8  # [m] to either side of them [Mateus2019]


def behind_seated(person: TruePerson, point_in_world: Array) -> float:
    """Return how much a point, (2,) [m], is behind a person's back: g3, in [0, 1]; 0 before them [Mateus2019].

    exp(-u^2 / (2 1.2^2) - v^2 / (2 0.8^2)) with u backward and v sideways in the person's frame.
    """
    forward, sideways = person.pose_in_world.to_body(point_in_world)
    if forward > 0.0:
        return 0.0
    return math.exp(-0.5 * (forward / BEHIND_DEVIATION) ** 2 - 0.5 * (sideways / BESIDE_DEVIATION) ** 2)


class SeatedTally(Tally):
    """How much the robot was behind seated people.

    Args:
        people: Names of those who sit.
    """

    group = "people"
    definitions: ClassVar[Definitions] = {
        "behind_seated": Definition(
            "1",
            "largest g3 at the robot's centre, of the true person while seated: exp(-u^2 / (2 "
            f"{BEHIND_DEVIATION:g}^2) - v^2 / (2 {BESIDE_DEVIATION:g}^2)), u backward and v sideways from their centre "
            "[m], 0 before them [Mateus2019]",
            "lower",
            headline=True,
        )
    }

    def __init__(self, people: Sequence[str]) -> None:
        self._most = dict.fromkeys(people, 0.0)

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        robot = tick.truth.pose_robot_in_world.position
        for person in tick.truth.people:
            if person.posture is Posture.SEATED:
                self._most[person.name] = max(self._most[person.name], behind_seated(person, robot))

    def values(self) -> dict[str, Value]:
        """Return the largest g3 per person."""
        return {f"behind_seated.{name}": most for name, most in self._most.items()}


class TransitTally(Tally):
    """How long the robot was between seated people and what they watch, and how soon it planned anew for that.

    Args:
        seats: Of the world.
        devices: Place of each, shape (2,) [m].
        on_seats: Name of the seat of each person who sits.
    """

    group = "people"
    definitions: ClassVar[Definitions] = {
        "transit_time_on": Definition(
            "s",
            "time of the robot's centre in the disc whose diameter joins the centres of somebody seated and of the "
            "device that their seat watches, while that is truly on [Mateus2019]",
            "lower",
            "navmet: relation_disturbance, of the segment",
            headline=True,
        ),
        "transit_time_off": Definition(
            "s", "time of the robot's centre in the same disc while the device is truly off"
        ),
        "replan_delay": Definition(
            "s",
            "from the first tick in which the device is truly on to the first whose way was searched anew knowing "
            "that; none where either never came",
            "lower",
            headline=True,
        ),
    }

    def __init__(self, seats: Sequence[Seat], devices: Mapping[str, Array], on_seats: Mapping[str, str]) -> None:
        self._seats = {seat.name: seat for seat in seats}
        self._devices = dict(devices)
        self._on_seats = dict(on_seats)
        self._ticks = {(device, on): 0 for device in self._devices for on in (False, True)}
        self._on_since: dict[str, float] = {}
        self._delays: dict[str, Value] = dict.fromkeys(self._devices)

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        robot = tick.truth.pose_robot_in_world.position
        states = dict(tick.truth.devices_on)
        between = {device for device, centre, radius in self._discs(tick.truth.people) if _near(robot, centre, radius)}
        for device in between:
            self._ticks[device, states[device]] += 1
        known = {device.name: device.on for device in tick.decision.scene.devices}
        planned = tick.decision.path is not None and tick.decision.path.expanded > 0
        for device, on in states.items():
            if on:
                since = self._on_since.setdefault(device, tick.truth.time)
                if self._delays[device] is None and planned and known.get(device, False):
                    self._delays[device] = tick.truth.time - since

    def values(self) -> dict[str, Value]:
        """Return two durations and a delay per device."""
        values: dict[str, Value] = {}
        for device in self._devices:
            values[f"transit_time_on.{device}"] = self._ticks[device, True] * CONTROL_PERIOD
            values[f"transit_time_off.{device}"] = self._ticks[device, False] * CONTROL_PERIOD
            values[f"replan_delay.{device}"] = self._delays[device]
        return values

    def _discs(self, people: Sequence[TruePerson]) -> Iterator[tuple[str, Array, float]]:
        """Return device, centre and radius of the disc between each seated person and the device they watch."""
        for person in people:
            seat = self._seats.get(self._on_seats.get(person.name, ""))
            if person.posture is Posture.SEATED and seat is not None and seat.watches is not None:
                here, there = person.pose_in_world.position, self._devices[seat.watches]
                yield seat.watches, 0.5 * (here + there), 0.5 * math.dist(here, there)


def _near(point: Array, centre: Array, radius: float) -> bool:
    return math.dist(point, centre) <= radius
