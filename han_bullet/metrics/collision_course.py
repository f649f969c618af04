"""How soon robot and people would have touched, had both gone straight on."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from han_bullet.episode import Tick
from han_bullet.geometry import Array
from han_bullet.metrics.tally import PERSON_RADIUS, Definition, Definitions, Tally, Value

AT_REST = 0.001  # [m/s] between robot and person; slower than that, neither goes anywhere


def time_to_collision(offset: Array, relative_velocity: Array, reach: float) -> float:
    """Return when two discs touch that keep their velocities [s]; inf where they never do, 0 where they overlap.

    The smaller root t of |offset + relative_velocity t| = reach, while the gap closes. At rest, where a simulator's
    velocities are noise, they never touch.

    Args:
        offset: From the centre of the one to the other's, shape (2,) [m].
        relative_velocity: Of the other less that of the one, shape (2,) [m/s].
        reach: Sum of the radii [m].
    """
    (x, y), (vx, vy) = offset, relative_velocity
    c = x * x + y * y - reach * reach
    if c <= 0.0:
        return 0.0
    half_b, a = x * vx + y * vy, vx * vx + vy * vy
    discriminant = half_b * half_b - a * c
    if half_b >= 0.0 or discriminant < 0.0 or a < AT_REST**2:
        return math.inf
    return float(c / (math.sqrt(discriminant) - half_b))


class CollisionCourseTally(Tally):
    """The least time to collision.

    Args:
        robot_radius: Of the footprint [m].
    """

    group = "people"
    definitions: ClassVar[Definitions] = {
        "minimum_time_to_collision": Definition(
            "s",
            "smallest time over ticks and people until the discs of robot and person, its radius and "
            f"{PERSON_RADIUS:g} m, would touch if both kept their true velocities: the smaller root of the quadratic "
            "of the centres' distance; only while the gap closes, not where they would miss each other, and not where "
            f"they move against each other by less than {AT_REST:g} m/s; 0 where the discs overlap; none if there "
            "never was such a tick",
            "higher",
            "Francis2023: TTC; robot_sf: of the centres, without miss distance",
            headline=True,
        )
    }

    def __init__(self, robot_radius: float) -> None:
        self._reach = robot_radius + PERSON_RADIUS
        self._least = math.inf

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        pose = tick.truth.pose_robot_in_world
        place, velocity = pose.position, np.asarray(tick.truth.twist_robot_in_body.linear_in_world(pose.yaw))
        for person in tick.truth.people:
            offset, relative = person.pose_in_world.position - place, person.velocity_in_world - velocity
            self._least = min(self._least, time_to_collision(offset, relative, self._reach))

    def values(self) -> dict[str, Value]:
        """Return the least time."""
        return {"minimum_time_to_collision": self._least}
