"""Going slowly where somebody may be, whom no camera that works has seen for a while."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from han_bullet.control.way import Way
from han_bullet.geometry import Array, largest_deviation
from han_bullet.messages import Path, TrackedPerson

WELL_KNOWN = 0.4  # standard deviation of a place up to which it is known well [m]: an arm's length
AHEAD = 3.0  # of the way that is looked at [m]: what braking and thinking take at full speed, twice
NEAR = 1.2  # between the way and whom it passes near [m]: Hall's personal zone
SLOWLY = 0.4  # part of the speed


def speed_factor_among(people: Sequence[TrackedPerson], path: Path | None) -> float:
    """Return how fast to go, as a part of the usual speed: slowly where somebody may be near the way.

    Args:
        people: Confirmed tracks.
        path: The way from the robot on.
    """
    if path is None:
        return 1.0
    way = Way(path.points_in_world)
    points = way.at(np.linspace(0.0, min(AHEAD, way.length), 31, dtype=np.float64))
    return SLOWLY if any(_may_be_near(person, points) for person in people) else 1.0


def _may_be_near(person: TrackedPerson, points: Array) -> bool:
    """Tell whether somebody is not known well, and within a standard deviation of being near points, (n, 2) [m]."""
    spread = largest_deviation(person.covariance[:2, :2])
    distance = np.linalg.norm(points - person.position_in_world, axis=1).min()
    return spread > WELL_KNOWN and bool(distance < NEAR + spread)
