"""The numbers of a run on what the paper's social rules ask for: sides, seats, televisions, hand-overs; truth only."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from han_bullet.episode import Tick
from han_bullet.geometry import Array, wrap_angle
from han_bullet.messages import Posture, Seat, Status, TruePerson
from han_bullet.tallies import STILL_SPEED, Tally, Value
from han_bullet.world_schema import CONTROL_PERIOD, HandOverTask

BEHIND_DEVIATION = 1.2  # [m] behind a seated person's back [Mateus2019]
BESIDE_DEVIATION = 0.8  # [m] to either side of them [Mateus2019]
EARLY = 1.2  # [m] between centres: from here on a hand-over's approach must come from the front


def behind_seated(person: TruePerson, point_in_world: Array) -> float:
    """Return how much a point, (2,) [m], is behind a person's back: g3, in [0, 1]; 0 before them [Mateus2019].

    exp(-u^2 / (2 1.2^2) - v^2 / (2 0.8^2)) with u backward and v sideways in the person's frame.
    """
    forward, sideways = person.pose_in_world.to_body(point_in_world)
    if forward > 0.0:
        return 0.0
    return math.exp(-0.5 * (forward / BEHIND_DEVIATION) ** 2 - 0.5 * (sideways / BESIDE_DEVIATION) ** 2)


class PassingTally(Tally):
    """On which side of its way the robot had each person when they were nearest.

    Args:
        people: Names.
    """

    def __init__(self, people: Sequence[str]) -> None:
        self._nearest = dict.fromkeys(people, math.inf)
        self._sides: dict[str, Value] = dict.fromkeys(people)

    def record(self, tick: Tick) -> None:
        """Take note of one tick in which the robot moves."""
        pose, twist = tick.truth.pose_robot_in_world, tick.truth.twist_robot_in_body
        if twist.speed < STILL_SPEED:
            return
        ahead = twist.linear_in_world(pose.yaw)
        for person in tick.truth.people:
            x, y = person.pose_in_world.position - pose.position
            if math.hypot(x, y) < self._nearest[person.name]:
                self._nearest[person.name] = math.hypot(x, y)
                self._sides[person.name] = "left" if ahead[0] * y - ahead[1] * x > 0.0 else "right"

    def values(self) -> dict[str, Value]:
        """Return a side per person; None where the robot never moved."""
        return {f"passing_side.{name}": side for name, side in self._sides.items()}


class SeatedTally(Tally):
    """How much the robot was behind seated people.

    Args:
        people: Names of all people.
    """

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


class HandOverTally(Tally):
    """How a hand-over ended, and how it was approached; the person is who stood nearest to its place at first.

    Args:
        task: Of the world.
    """

    _NAMES = ("hand_over_distance", "hand_over_bearing", "hand_over_facing", "hand_over_early_bearing")

    def __init__(self, task: HandOverTask) -> None:
        self._place = np.array(task.place)
        self._name: str | None = None
        self._values: dict[str, Value] = dict.fromkeys(self._NAMES)

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        people = {person.name: person for person in tick.truth.people}
        if self._name is None and people:
            self._name = min(people, key=lambda name: people[name].pose_in_world.distance_to(self._place))
        if self._name is None:
            return
        person, robot = people[self._name].pose_in_world, tick.truth.pose_robot_in_world
        x, y = robot.position - person.position
        bearing = abs(wrap_angle(math.atan2(y, x) - person.yaw))
        if self._values["hand_over_early_bearing"] is None and math.hypot(x, y) <= EARLY:
            self._values["hand_over_early_bearing"] = bearing
        if tick.decision.status is Status.ARRIVED:
            self._values["hand_over_distance"] = math.hypot(x, y)
            self._values["hand_over_bearing"] = bearing
            self._values["hand_over_facing"] = abs(wrap_angle(math.atan2(-y, -x) - robot.yaw))

    def values(self) -> dict[str, Value]:
        """Return distance and angles; None where it did not come to that."""
        return dict(self._values)
