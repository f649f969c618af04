"""On which side the robot overtook people and passed them by."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from han_bullet.episode import Tick
from han_bullet.geometry import Array
from han_bullet.messages import TruePerson
from han_bullet.metrics.tally import STILL_SPEED, Definition, Definitions, Tally, Value, person_walks

LEVEL_WITHIN = 2.5  # [m] between centres; farther away two bodies are not passing each other


@dataclass
class _Overtaking:
    """One person and the robot, so far."""

    forward: float = math.nan  # of the robot in the person's frame at the last tick [m]
    side: str = "none"
    distance_when_level: float | None = None

    def update(self, person: TruePerson, robot_in_world: Array) -> None:
        distance = person.pose_in_world.distance_to(robot_in_world)
        forward, lateral = person.pose_in_world.to_body(robot_in_world)
        if self.forward < 0.0 <= forward and person_walks(person) and distance <= LEVEL_WITHIN:
            self.side = "left" if lateral > 0.0 else "right"
            self.distance_when_level = distance
        self.forward = float(forward)


class OvertakingTally(Tally):
    """On which side of walking people the robot overtook them.

    Args:
        people: Names, for metrics that exist also where nothing was recorded.
    """

    group = "people"
    definitions: ClassVar[Definitions] = {
        "overtaking_side": Definition(
            "",
            "left or right: the person's side on which the robot was when it last drew level from behind, i.e. its "
            "forward coordinate in the person's frame turned from negative to positive while the person walked faster "
            f"than {STILL_SPEED:g} m/s within {LEVEL_WITHIN:g} m between the centres; none where it never did; "
            "it should be left [Mateus2019]",
            headline=True,
        ),
        "distance_when_level": Definition(
            "m", "true distance between the centres at that moment; none where it never came", "higher"
        ),
    }

    def __init__(self, people: Sequence[str]) -> None:
        self._overtakings = {name: _Overtaking() for name in people}

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        robot = tick.truth.pose_robot_in_world.position
        for person in tick.truth.people:
            self._overtakings[person.name].update(person, robot)

    def values(self) -> dict[str, Value]:
        """Return a side and a distance per person."""
        values: dict[str, Value] = {}
        for name, overtaking in self._overtakings.items():
            values[f"overtaking_side.{name}"] = overtaking.side
            values[f"distance_when_level.{name}"] = overtaking.distance_when_level
        return values


class PassingTally(Tally):
    """On which side of its way the robot had each person when they were nearest.

    Args:
        people: Names.
    """

    group = "people"
    definitions: ClassVar[Definitions] = {
        "passing_side": Definition(
            "",
            f"left or right: the side of the robot's direction of motion (faster than {STILL_SPEED:g} m/s) on which "
            "the person was when their centres were nearest; none where the robot never moved",
            headline=True,
        )
    }

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
