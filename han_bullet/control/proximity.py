"""How fast the robot may go near people: the closing speed is limited, never the speed along with them [Mateus2019]."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numba
import numpy as np

from han_bullet.control.way import Way
from han_bullet.geometry import Array
from han_bullet.messages import Posture, TrackedPerson

NO_WORSE = 1e-3  # a gap that shrinks by less has not shrunk [m]
LEVELS = np.linspace(1.0, 0.0, 11)  # parts of a speed that are tried
MOMENTS = 12  # of a prediction
SMALLEST_GAP = 0.08  # between the surfaces of robot and person [m]


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
        smallest_gap: float = SMALLEST_GAP,
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
        starts = np.array([walker.position_in_world for walker in walkers], float)
        velocities = np.array([_velocity(walker) for walker in walkers], float)
        gaps = _passing_distances(way.points_in_world, way.arc, speed, self.horizon, starts, velocities)
        kept = gaps - self.contact_distance >= self.passing_gap
        return float(speed * LEVELS[np.argmax(kept)]) if kept.any() else speed

    def _is_safe(self, speed: float, direction: Array, position_in_world: Array, person: TrackedPerson) -> bool:
        """Predict the gap while the robot drives on for the reaction time and then brakes to a stand."""
        offset = person.position_in_world - position_in_world
        moving, standing = _braking_distances(
            offset, _velocity(person), speed * direction, self.reaction, self.max_deceleration
        )
        gap = moving - self.contact_distance
        return bool(gap >= self.smallest_gap or gap >= standing - self.contact_distance - NO_WORSE)


@numba.njit(cache=True)
def _passing_distances(way: Array, arc: Array, speed: float, horizon: float, starts: Array, velocities: Array) -> Array:
    """Return how near the centres of robot and walkers come, shape (levels,) [m], for each of the speeds tried.

    Args:
        way: From the robot on, shape (n, 2) [m].
        arc: Arc length of each of its points, shape (n,) [m].
        speed: Of which `LEVELS` are tried [m/s].
        horizon: How far ahead [s].
        starts: Of the walkers, shape (m, 2) [m].
        velocities: Of the walkers, shape (m, 2) [m/s].
    """
    nearest = np.full(LEVELS.size, np.inf)
    for level in range(LEVELS.size):
        for moment in range(MOMENTS):
            time = horizon * moment / (MOMENTS - 1)
            along = min(speed * LEVELS[level] * time, arc[-1])
            end = min(max(np.searchsorted(arc, along), 1), arc.size - 1)
            part = (along - arc[end - 1]) / max(arc[end] - arc[end - 1], 1e-12)
            x = way[end - 1, 0] + part * (way[end, 0] - way[end - 1, 0])
            y = way[end - 1, 1] + part * (way[end, 1] - way[end - 1, 1])
            for walker in range(len(starts)):
                there_x = starts[walker, 0] + time * velocities[walker, 0]
                there_y = starts[walker, 1] + time * velocities[walker, 1]
                nearest[level] = min(nearest[level], math.hypot(there_x - x, there_y - y))
    return nearest


@numba.njit(cache=True)
def _braking_distances(
    offset: Array, velocity_person: Array, velocity_robot: Array, reaction: float, deceleration: float
) -> tuple[float, float]:
    """Return how near the centres come [m] while the robot drives on and brakes, and if it stood meanwhile.

    Args:
        offset: From the robot to the person, shape (2,) [m].
        velocity_person: Shape (2,) [m/s].
        velocity_robot: Shape (2,) [m/s].
        reaction: Time before the brakes hold [s].
        deceleration: Of the brakes [m/s^2].
    """
    speed = math.hypot(velocity_robot[0], velocity_robot[1])
    duration = reaction + speed / deceleration
    moving, standing = np.inf, np.inf
    for moment in range(MOMENTS):
        time = duration * moment / (MOMENTS - 1)
        slowed = 0.5 * deceleration * max(time - reaction, 0.0) ** 2
        part = time - slowed / max(speed, 1e-12)  # of the robot's velocity
        x, y = offset[0] + time * velocity_person[0], offset[1] + time * velocity_person[1]
        standing = min(standing, math.hypot(x, y))
        moving = min(moving, math.hypot(x - part * velocity_robot[0], y - part * velocity_robot[1]))
    return moving, standing


def _velocity(person: TrackedPerson) -> Array:
    """Return the velocity, (2,) [m/s], to count on; that of somebody who does not walk is noise."""
    return person.velocity_in_world if person.posture is Posture.WALKING else np.zeros(2)
