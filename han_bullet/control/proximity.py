"""How fast the robot may go near people: the closing speed is limited, never the speed along with them [Mateus2019]."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from han_bullet.control.way import Way
from han_bullet.geometry import Array
from han_bullet.messages import Posture, TrackedPerson

NO_WORSE = 1e-3  # a gap that shrinks by less has not shrunk [m]
LEVELS = np.linspace(1.0, 0.0, 11)  # parts of a speed that are tried


class ProximityLimit:
    """Limit the robot's speed so that it never rushes at a person, cuts off a walker or touches anybody.

    - Comfort: the closing speed, the part of the relative velocity towards a person, is at most `gain` *
      (gap - `smallest_gap`); this never brings the robot below the person's own speed in its direction plus
      `overtaking_margin`.
    - Foresight: over `horizon`, the robot on its way and the walkers on their courses keep `passing_gap`; the robot
      slows down as far as that takes, unless not even standing would do.
    - Safety, which nothing overrides: the robot drives straight on for `reaction` and then brakes while the walkers go
      on; during that the gap stays above `smallest_gap`, or is no worse than if it stood.
    """

    def __init__(
        self,
        *,
        robot_radius: float,
        max_deceleration: float,
        body_radius: float = 0.25,
        gain: float = 1.0,
        smallest_gap: float = 0.08,
        passing_gap: float = 0.2,
        overtaking_margin: float = 0.3,
        reaction: float = 0.15,
        horizon: float = 2.5,
    ) -> None:
        """Configure the limit.

        Args:
            robot_radius: [m].
            max_deceleration: [m/s^2].
            body_radius: Of a person [m].
            gain: Closing speed per metre of gap [1/s].
            smallest_gap: Between the surfaces [m]; less than the body layer's margin, or a start at its rim is stuck.
            passing_gap: Between the surfaces where robot and walker pass each other [m]: centres 0.75 m apart.
            overtaking_margin: Speed beyond a person's own that comfort leaves [m/s].
            reaction: Time before the brakes hold: one control period and the age of a track [s].
            horizon: How far ahead people are taken to walk straight on [s].
        """
        self.contact_distance = robot_radius + body_radius
        self.max_deceleration = max_deceleration
        self.gain = gain
        self.smallest_gap = smallest_gap
        self.passing_gap = passing_gap
        self.overtaking_margin = overtaking_margin
        self.reaction = reaction
        self.horizon = horizon

    def limit(self, speed: float, direction: Array, way: Way, people: Sequence[TrackedPerson]) -> float:
        """Return the highest speed [m/s], up to the given one, that all people allow.

        Args:
            speed: Wanted [m/s].
            direction: Of the wanted velocity, a unit vector, (2,).
            way: From the robot on.
            people: All of them.
        """
        for person in people:
            speed = min(speed, self._comfortable(direction, way.start, person))
        speed = self._foresighted(speed, way, [person for person in people if person.posture is Posture.WALKING])
        safe = (
            level * speed
            for level in LEVELS
            if all(self._is_safe(level * speed, direction, way.start, person) for person in people)
        )
        return float(next(safe, 0.0))

    def _comfortable(self, direction: Array, position_in_world: Array, person: TrackedPerson) -> float:
        offset, velocity = person.position_in_world - position_in_world, _velocity(person)
        distance = max(float(np.hypot(*offset)), 1e-6)
        towards = float(direction @ offset) / distance
        if towards <= 0.0:
            return np.inf
        leaving = float(velocity @ offset) / distance
        closing = self.gain * max(distance - self.contact_distance - self.smallest_gap, 0.0)
        alongside = float(velocity @ direction)
        floor = alongside + self.overtaking_margin if alongside > 0.0 else 0.0
        return max((closing + leaving) / towards, floor, 0.0)

    def _foresighted(self, speed: float, way: Way, walkers: Sequence[TrackedPerson]) -> float:
        """Return the highest speed that keeps the passing gap from all walkers; the given one where none does."""
        if not walkers:
            return speed
        time = np.linspace(0.0, self.horizon, 11)
        courses = np.stack([w.position_in_world + time[:, None] * _velocity(w) for w in walkers])
        robot = way.at(speed * LEVELS[:, None] * time)
        gaps = np.hypot(*np.moveaxis(courses[:, None] - robot, -1, 0)).min(axis=(0, 2)) - self.contact_distance
        kept = gaps >= self.passing_gap
        return float(speed * LEVELS[np.argmax(kept)]) if kept.any() else speed

    def _is_safe(self, speed: float, direction: Array, position_in_world: Array, person: TrackedPerson) -> bool:
        """Predict the gap while the robot drives on for the reaction time and then brakes to a stand."""
        braking = speed / self.max_deceleration
        time = np.linspace(0.0, self.reaction + braking, 12)
        slowed = np.maximum(time - self.reaction, 0.0)
        travelled = speed * time - 0.5 * self.max_deceleration * slowed**2
        robot = position_in_world + travelled[:, None] * direction
        walker = person.position_in_world + time[:, None] * _velocity(person)
        gap = np.hypot(*(walker - robot).T).min() - self.contact_distance
        if gap >= self.smallest_gap:
            return True
        standing = np.hypot(*(walker - position_in_world).T).min() - self.contact_distance
        return bool(gap >= standing - NO_WORSE)


def _velocity(person: TrackedPerson) -> Array:
    """Return the velocity, (2,) [m/s], to count on; that of somebody who does not walk is noise."""
    return person.velocity_in_world if person.posture is Posture.WALKING else np.zeros(2)
