"""What the robot touched, and who hit whom."""

from __future__ import annotations

import math
from collections import Counter
from typing import ClassVar

import numpy as np

from han_bullet.episode import Tick
from han_bullet.geometry import Array
from han_bullet.messages import Contact
from han_bullet.metrics.tally import STILL_SPEED, TIME_SLACK, Definition, Definitions, Tally, Value

NEW_CONTACT_AFTER = 0.5  # [s] without touch; a body that bounces or slides along a wall is one contact

_CONTACT = (
    f"number of separate contacts of the robot with {{}}: signed distance between the surfaces <= 0 m; a touch of the "
    f"same body counts again after {NEW_CONTACT_AFTER:g} s without"
)
_TOWARDS = (
    "the part towards the person's centre of the robot's true velocity, the larger of the first touch's tick and the "
    f"one before (the impact itself slows the robot), {{}} {STILL_SPEED:g} m/s"
)


class ContactTally(Tally):
    """What the robot touched."""

    group = "task"
    definitions: ClassVar[Definitions] = {
        "contacts_person": Definition(
            "1",
            _CONTACT.format("people") + ", that the robot made: " + _TOWARDS.format("above"),
            "lower",
            "SEAN: robot-on-person collisions; HuNav: robot_on_person_collision, by angles that do not compare; "
            "Francis2023: human collision, whoever hit",
            headline=True,
        ),
        "contacts_by_person": Definition(
            "1",
            _CONTACT.format("people")
            + ", that the person made, walking into a robot that stood still or moved away: "
            + _TOWARDS.format("at most"),
            "lower",
            "SEAN: person-on-robot collisions; HuNav: person_on_robot_collision",
            headline=True,
        ),
        "contacts_wall": Definition(
            "1", _CONTACT.format("walls"), "lower", "Francis2023: wall collision", headline=True
        ),
        "contacts_object": Definition(
            "1",
            _CONTACT.format("furniture and devices"),
            "lower",
            "Francis2023: object collision; SEAN: static obstacle collision, walls too",
            headline=True,
        ),
    }

    def __init__(self) -> None:
        self._last: dict[tuple[str, str], float] = {}
        self._counts: Counter[str] = Counter()
        self._velocities: tuple[Array, Array] = (
            np.zeros(2),
            np.zeros(2),
        )  # in the world, of the last tick and this one [m/s]

    def record(self, tick: Tick) -> None:
        """Count the contacts that begin; each body's own, so that two people at once are two."""
        truth = tick.truth
        velocity = truth.twist_robot_in_body.linear_in_world(truth.pose_robot_in_world.yaw)
        self._velocities = (self._velocities[1], velocity)
        for contact in truth.contacts:
            key = (contact.kind, contact.body)
            if truth.time - self._last.get(key, -math.inf) > NEW_CONTACT_AFTER - TIME_SLACK:
                self._counts[self._name(contact, tick)] += 1
            self._last[key] = truth.time

    def _name(self, contact: Contact, tick: Tick) -> str:
        if contact.kind != "person":
            return f"contacts_{contact.kind}"
        (place,) = (p.pose_in_world.position for p in tick.truth.people if p.name == contact.body)
        towards = place - tick.truth.pose_robot_in_world.position
        return "contacts_person" if self._speed_along(towards) > STILL_SPEED else "contacts_by_person"

    def _speed_along(self, direction: Array) -> float:
        """Return the larger part of the last two velocities along a direction, (2,) [m]."""
        return float(max(np.array(self._velocities) @ direction) / max(math.hypot(*direction), 1e-9))

    def values(self) -> dict[str, Value]:
        """Return the counts."""
        return {name: self._counts[name] for name in self.definitions}
