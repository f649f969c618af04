"""Tracked people as people_msgs/People."""

import dataclasses
from typing import Any

from ticks import track

from han_bullet.ros.message_types import definition, deserialize, serialize
from han_bullet.ros.people_messages import people_message


def tags(person: Any) -> dict[str, str]:
    return dict(zip(person.tagnames, person.tags, strict=True))


def test_the_type_is_the_one_that_others_know() -> None:
    assert definition("people_msgs/People").md5 == "18722f4b8db20cc2369740732357847b"


def test_position_velocity_and_direction_come_back_from_the_wire() -> None:
    walker = track(4, 1.0, 2.0, velocity=(0.5, -0.5), heading=-0.7854, posture="walking")
    message = deserialize("people_msgs/People", bytes(serialize(people_message([walker], 3.0))))
    (person,) = message.people
    assert (person.name, person.position.x, person.position.y, person.position.z) == ("4", 1.0, 2.0, 0.0)
    assert (person.velocity.x, person.velocity.y, person.velocity.z) == (0.5, -0.5, 0.0)
    assert tags(person) == {"posture": "walking", "yaw": "-0.7854"}
    assert message.header.frame_id == "map" and message.header.stamp.sec == 3


def test_who_faces_nobody_knows_where_has_no_yaw() -> None:
    assert tags(people_message([track(heading=None)], 0.0).people[0]) == {"posture": "standing"}


def test_who_sits_is_on_a_seat() -> None:
    seated = dataclasses.replace(track(heading=1.0, posture="seated"), seat="couch")
    assert tags(people_message([seated], 0.0).people[0]) == {"posture": "seated", "yaw": "1.0000", "seat": "couch"}


def test_nobody_is_an_empty_message() -> None:
    assert people_message([], 0.0).people == []
