"""How a hand-over was approached, and how it ended."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from han_bullet.episode import Tick
from han_bullet.geometry import wrap_angle
from han_bullet.messages import Status
from han_bullet.metrics.tally import Definition, Definitions, Tally, Value
from han_bullet.world_schema import HandOverTask

EARLY = 1.2  # [m] between centres: from here on a hand-over's approach must come from the front


class HandOverTally(Tally):
    """How a hand-over ended, and how it was approached; the person is who stood nearest to its place at first.

    Args:
        task: Of the world.
    """

    group = "people"
    definitions: ClassVar[Definitions] = {
        "hand_over_distance": Definition(
            "m",
            "true distance between the centres of robot and person when the hand-over arrived; none if it never did; "
            "the task's own distance is right [Mateus2019]",
            headline=True,
        ),
        "hand_over_bearing": Definition(
            "rad",
            "absolute direction of the robot from the person, against the person's true yaw, at that moment; 0 is "
            "straight before them; the opening ends at pi / 8 [Mateus2019]",
            "lower",
            headline=True,
        ),
        "hand_over_facing": Definition(
            "rad", "absolute direction of the person from the robot, against its true yaw, at that moment", "lower"
        ),
        "hand_over_early_bearing": Definition(
            "rad",
            f"the same as hand_over_bearing when their centres first came within {EARLY:g} m; none if they never did",
            "lower",
        ),
    }

    def __init__(self, task: HandOverTask) -> None:
        self._place = np.array(task.place)
        self._name: str | None = None
        self._values: dict[str, Value] = dict.fromkeys(self.definitions)
        self._ordered = False

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        self._ordered |= bool(tick.decision.orders)
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
        """Return distance and angles; None where it did not come to that, or orders made it another hand-over."""
        return dict.fromkeys(self._values) if self._ordered else dict(self._values)
