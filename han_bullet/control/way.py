"""A way by arc length."""

from __future__ import annotations

import math

import numpy as np

from han_bullet.geometry import Array, arc_lengths, points_at

SPREAD = 0.25  # a mean point of the way takes in this much to either side [m]; rounds the 45 degree corners of the grid


class Way:
    """A polyline from the robot on.

    Attributes:
        points_in_world: Shape (n, 2) [m].
        arc: Arc length of each point, shape (n,) [m].
    """

    def __init__(self, points_in_world: Array) -> None:
        self.points_in_world = points_in_world
        self.arc = arc_lengths(points_in_world)

    @property
    def start(self) -> Array:
        """Return the first point, (2,) [m]: the robot."""
        start: Array = self.points_in_world[0]
        return start

    @property
    def end(self) -> Array:
        """Return the last point, (2,) [m]."""
        end: Array = self.points_in_world[-1]
        return end

    @property
    def length(self) -> float:
        """Return the arc length [m]."""
        return float(self.arc[-1])

    def at(self, arc: float | Array) -> Array:
        """Return the points, (..., 2) [m], at arc lengths [m]; the end beyond it."""
        return points_at(arc, self.points_in_world, self.arc)

    def mean_about(self, arc: float) -> Array:
        """Return the mean point, (2,) [m], of a stretch of the way."""
        mean: Array = self.at(arc + np.linspace(-SPREAD, SPREAD, 9, dtype=np.float64)).mean(axis=0)
        return mean

    def direction_to(self, arc: float, default: float) -> float:
        """Return the direction [rad] from the robot to the way about an arc length; the default where that is here."""
        x, y = self.mean_about(arc) - self.start
        return math.atan2(y, x) if math.hypot(x, y) > 0.1 else default
