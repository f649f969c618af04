"""Localization by odometry alone: for a robot without a laser, whose error grows with its way and is never mended."""

from __future__ import annotations

import numpy as np

from han_bullet.geometry import Array, Pose2D
from han_bullet.localization.localizer import Localization
from han_bullet.localization.odometry_model import OdometryModel
from han_bullet.localization.pose_filter import PoseFilter
from han_bullet.messages import LaserScan, Odometry, PoseEstimate

AT_START = np.diag([0.05**2, 0.05**2, 0.05**2])  # how well somebody puts a robot down [m^2], [rad^2]


class DeadReckoning(Localization):
    """Add up the odometry from a known start.

    It is never lost, since nothing tells it so; its covariance grows.

    Args:
        start: Pose in the world.
        odometry_model: How wrong odometry may be.
        start_covariance: How sure the start is, of (x, y, yaw), shape (3, 3) [m^2, m rad, rad^2].
    """

    name = "odometry"

    def __init__(self, start: Pose2D, odometry_model: OdometryModel, start_covariance: Array = AT_START) -> None:
        self._tracked = PoseFilter(start, start_covariance, odometry_model)
        self._last: Odometry | None = None

    def update(self, odometry: Odometry, scan: LaserScan | None) -> PoseEstimate:
        """Move by the odometry; a scan tells nothing here."""
        last = self._last or odometry
        self._tracked.move(last.pose_robot_in_odom.relative(odometry.pose_robot_in_odom))
        self._last = odometry
        return PoseEstimate(odometry.time, self._tracked.pose, self._tracked.covariance)

    def relocalize(self) -> None:
        """Do nothing: there is no map to look for the robot on."""
