"""How wrong odometry may be: noise that grows with the movement, of a base that drives in every direction."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from han_bullet.errors import check_not_negative
from han_bullet.geometry import Array, Pose2D


@dataclass(frozen=True)
class OdometryModel:
    """The variances grow in proportion to the way, so that they do not depend on the steps in which it is measured.

    Attributes:
        slip: Deviation of the factors by which all ways forward, and all sideways, are wrong; the same for long.
        position_per_way: Deviation of x and of y after a metre, besides [m / sqrt(m)].
        yaw_per_way: Deviation of the direction after a metre [rad / sqrt(m)].
        yaw_per_turn: Deviation of the direction after a turn by a radian [rad / sqrt(rad)].
    """

    slip: float = 0.02
    position_per_way: float = 0.005
    yaw_per_way: float = math.radians(1.0)
    yaw_per_turn: float = math.radians(1.5)

    def __post_init__(self) -> None:
        """Raise BadInputError for a deviation that is negative or not finite."""
        check_not_negative("odometry model", **vars(self))

    def variances(self, step: Pose2D) -> Array:
        """Return the variances of x, y and yaw that a step in the body frame adds besides the slip, shape (3,)."""
        way = math.hypot(step.x, step.y)
        position = self.position_per_way**2 * way
        return np.array([position, position, self.yaw_per_way**2 * way + self.yaw_per_turn**2 * abs(step.yaw)])

    def sampled(self, poses: Array, step: Pose2D, generator: np.random.Generator) -> Array:
        """Return poses (x, y, yaw), shape (n, 3), after as many draws of what the step may have been.

        The slip is drawn for each step anew, which is enough for the few metres until the robot is found.
        """
        slip = self.slip * np.array([step.x, step.y, 0.0])
        deviations = np.sqrt(self.variances(step) + slip**2)
        x, y, yaw = (np.array([step.x, step.y, step.yaw]) + generator.normal(size=(len(poses), 3)) * deviations).T
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        moved: Array = poses + np.column_stack([c * x - s * y, s * x + c * y, yaw])
        return moved
