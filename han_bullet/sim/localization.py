"""The one port by which a pose of the robot reaches the observation."""

from __future__ import annotations

from abc import ABC, abstractmethod

from han_bullet.geometry import Pose2D


class Localization(ABC):
    """Say where the robot is.

    Attributes:
        name: Stands in the results, so that nobody takes one kind of localization for another.
    """

    name: str

    @abstractmethod
    def pose(self, time: float, true_pose_in_world: Pose2D) -> Pose2D:
        """Return the believed pose at a time [s]; the true one is what a simulated sensor measures."""


class TrueLocalization(Localization):
    """Hand over the simulator's own pose."""

    name = "simulator"

    def pose(self, time: float, true_pose_in_world: Pose2D) -> Pose2D:
        """Return the true pose."""
        return true_pose_in_world
