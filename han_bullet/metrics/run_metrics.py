"""All figures of a run: the tallies, the hook that feeds them, and every metric's definition by name."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from han_bullet.assembly import field_of_view
from han_bullet.episode import Hook, Tick
from han_bullet.metrics.collision_course import CollisionCourseTally
from han_bullet.metrics.contacts import ContactTally
from han_bullet.metrics.distances import DistanceTally
from han_bullet.metrics.hand_over import HandOverTally
from han_bullet.metrics.intrusion import IntrusionTally
from han_bullet.metrics.localization import LocalizationTally
from han_bullet.metrics.motion import MotionTally
from han_bullet.metrics.passing import OvertakingTally, PassingTally
from han_bullet.metrics.perception import PerceptionTally
from han_bullet.metrics.plans import PlanTally
from han_bullet.metrics.seated import SeatedTally, TransitTally
from han_bullet.metrics.tally import Definition, Tally, Value
from han_bullet.metrics.task import TaskTally
from han_bullet.world_schema import HandOverTask, Sit, World

TALLIES: tuple[type[Tally], ...] = (
    TaskTally,
    ContactTally,
    MotionTally,
    PlanTally,
    DistanceTally,
    IntrusionTally,
    CollisionCourseTally,
    OvertakingTally,
    PassingTally,
    SeatedTally,
    TransitTally,
    HandOverTally,
    PerceptionTally,
    LocalizationTally,
)
# Metrics of one person or device carry its name behind a dot: minimum_distance.walker.
DEFINITIONS: dict[str, Definition] = {
    name: definition for tally in TALLIES for name, definition in tally.definitions.items()
}
GROUPS: dict[str, str] = {name: tally.group for tally in TALLIES for name in tally.definitions}


@dataclass(frozen=True)
class Metric:
    """One figure of a run.

    Attributes:
        name: One of `DEFINITIONS`, for a metric of one person followed by a dot and the name.
        value: None where the run gives no such figure.
        unit: SI, "1" for counts and shares, empty for words.
        definition: What is measured: threshold, from where to where, which way is better.
    """

    name: str
    value: Value
    unit: str
    definition: str


class Metrics(Hook):
    """Count the figures of a run.

    Args:
        world: For the names of the people, the robot's radius, the static map and what hides people from cameras.
    """

    def __init__(self, world: World) -> None:
        people = [person.name for person in world.people]
        on_seats = {p.name: p.behaviour.on for p in world.people if isinstance(p.behaviour, Sit)}
        contacts = ContactTally()
        self._tallies: tuple[Tally, ...] = (
            TaskTally(world, contacts),
            contacts,
            MotionTally(),
            PlanTally(),
            DistanceTally(people, world.robot.radius),
            IntrusionTally(people),
            CollisionCourseTally(world.robot.radius),
            OvertakingTally(people),
            PassingTally(people),
            SeatedTally(list(on_seats)),
            TransitTally(world.seats(), {tv.name: np.array(tv.position) for tv in world.devices}, on_seats),
            *([HandOverTally(world.task)] if isinstance(world.task, HandOverTask) else []),
            PerceptionTally(people, field_of_view(world)),
            LocalizationTally(),
        )

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        for tally in self._tallies:
            tally.record(tick)

    def results(self) -> list[Metric]:
        """Return all metrics so far, in a fixed order; values that are no finite number are None."""
        return [_metric(name, value) for tally in self._tallies for name, value in tally.values().items()]


def _metric(name: str, value: Value) -> Metric:
    finite = None if isinstance(value, float) and not math.isfinite(value) else value
    definition = DEFINITIONS[name.partition(".")[0]]
    return Metric(name, finite, definition.unit, definition.statement)


def written(value: Value) -> Value:
    """Return a value as it is written and judged, to a micro-unit: six periods of 0.05 s are 0.3 s, no float above."""
    if isinstance(value, float):
        return round(value, 6) if math.isfinite(value) else None
    return value
