"""What the robot touched, and who hit whom."""

from __future__ import annotations

import math
from collections import Counter
from typing import ClassVar

import numpy as np

from han_bullet.episode import Tick
from han_bullet.geometry import Array
from han_bullet.messages import Contact, TruePerson
from han_bullet.metrics.tally import STILL_SPEED, TIME_SLACK, Definition, Definitions, Tally, Value

NEW_CONTACT_AFTER = 0.5  # [s] without touch; a body that bounces or slides along a wall is one contact

_CONTACT = (
    f"number of separate contacts of the robot with {{}}: signed distance between the surfaces <= 0 m; a touch of the "
    f"same body counts again after {NEW_CONTACT_AFTER:g} s without"
)
_OWN = (
    "the part towards the person's centre of the robot's true velocity, the larger of the first touch's tick and the "
    "one before (the impact itself slows the robot)"
)
_BY_PERSON = (
    f"{_OWN}, was at most {STILL_SPEED:g} m/s, and the robot was no faster altogether or the person came towards it "
    "faster than that"
)


class ContactTally(Tally):
    """What the robot touched."""

    group = "task"
    definitions: ClassVar[Definitions] = {
        "contacts_person": Definition(
            "1",
            _CONTACT.format("people")
            + f", that the robot made: all but contacts_by_person, so where {_OWN}, was above {STILL_SPEED:g} m/s, or "
            "where it grazed somebody who stood",
            "lower",
            "SEAN: robot-on-person collisions; HuNav: robot_on_person_collision, by angles that do not compare; "
            "Francis2023: human collision, whoever hit",
            headline=True,
        ),
        "contacts_by_person": Definition(
            "1",
            _CONTACT.format("people")
            + f", that the person made, walking into a robot that stood still or did not come nearer: {_BY_PERSON}",
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
        # In the world, of the last tick and this one [m/s].
        self._velocities: tuple[Array, Array] = (np.zeros(2), np.zeros(2))

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
        (person,) = (p for p in tick.truth.people if p.name == contact.body)
        return (
            "contacts_by_person" if self._is_by(person, tick.truth.pose_robot_in_world.position) else "contacts_person"
        )

    def _is_by(self, person: TruePerson, robot_in_world: Array) -> bool:
        """Tell whether a person made the contact that begins."""
        towards = person.pose_in_world.position - robot_in_world
        towards = towards / max(math.hypot(*towards), 1e-9)
        velocities = np.array(self._velocities)
        robot_stands = bool(np.hypot(*velocities.T).max() <= STILL_SPEED)
        person_comes = bool(-(person.velocity_in_world @ towards) > STILL_SPEED)
        return bool((velocities @ towards).max() <= STILL_SPEED) and (robot_stands or person_comes)

    def values(self) -> dict[str, Value]:
        """Return the counts."""
        return {name: self._counts[name] for name in self.definitions}
