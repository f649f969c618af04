"""Tracked people as people_msgs/People, which other software for people understands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from han_bullet.messages import TrackedPerson
from han_bullet.ros.frames import MAP
from han_bullet.ros.message_types import header, make
from han_bullet.ros.placing import point


def people_message(people: Sequence[TrackedPerson], time: float) -> Any:
    """Return a people_msgs/People on the map.

    The type has no place for direction and posture: they are tags, `yaw` [rad] only of those whose direction is known.
    All are confirmed tracks, so their reliability is 1; z is the floor.
    """
    return make("people_msgs/People", header=header(time, MAP), people=[_person(person) for person in people])


def _person(person: TrackedPerson) -> Any:
    tags = {"posture": person.posture.value}
    if person.heading is not None:
        tags["yaw"] = f"{round(person.heading, 6):.4f}"  # as tracks.csv has it, so that a bag of the run says the same
    if person.seat is not None:
        tags["seat"] = person.seat
    return make(
        "people_msgs/Person",
        name=str(person.id),
        position=point(*person.position_in_world.tolist()),
        velocity=point(*person.velocity_in_world.tolist()),
        reliability=1.0,
        tagnames=list(tags),
        tags=list(tags.values()),
    )
