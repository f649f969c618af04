"""The port by which the stack learns where the robot is."""

from __future__ import annotations

from abc import ABC, abstractmethod

from han_bullet.messages import LaserScan, Odometry, PoseEstimate


class Localization(ABC):
    """Say where the robot is by what it senses.

    Attributes:
        name: Stands in the results, so that nobody takes one kind of localization for another.
    """

    name: str

    @abstractmethod
    def update(self, odometry: Odometry, scan: LaserScan | None) -> PoseEstimate:
        """Return where the robot is at the time of the odometry.

        Args:
            odometry: Of this control tick.
            scan: The one that arrived since the last tick, if one did; it may be somewhat older than the odometry.
        """

    @abstractmethod
    def relocalize(self) -> None:
        """Look for the robot on the whole map, by the scans to come; until it is found the estimate says `lost`."""
