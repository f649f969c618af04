"""Localization by odometry and a laser scanner on a known map."""

from __future__ import annotations

from collections import deque

import numpy as np

from han_bullet.geometry import Array, Pose2D
from han_bullet.localization.beams import Beams
from han_bullet.localization.likelihood_field import LikelihoodField
from han_bullet.localization.localizer import Localization
from han_bullet.localization.occupancy_grid import OccupancyGrid
from han_bullet.localization.odometry_model import OdometryModel
from han_bullet.localization.scan_matching import ScanMatcher
from han_bullet.messages import LaserScan, Odometry, PoseEstimate

REMEMBERED = 40  # control ticks: a scan that is older than these cannot be placed


class LidarLocalization(Localization):
    """Track the pose by matching scans to the map; find it anew by particles."""

    name = "lidar"

    def __init__(
        self,
        grid: OccupancyGrid,
        start: Pose2D,
        start_covariance: Array,
        generator: np.random.Generator,
        *,
        odometry_model: OdometryModel | None = None,
    ) -> None:
        """Start at a known place.

        Args:
            grid: The map at the scanner's height.
            start: Pose in the world.
            start_covariance: How sure it is, of (x, y, yaw), shape (3, 3) [m^2, m rad, rad^2].
            generator: Draws particles.
            odometry_model: How wrong odometry may be; None for wheels as the simulator's.
        """
        self._field = LikelihoodField.of_map(grid)
        self._matcher = ScanMatcher(self._field)
        self._odometry_model = odometry_model or OdometryModel()
        self._generator = generator
        self._pose, self._covariance = start, np.array(start_covariance, float)
        self._odometry: deque[Odometry] = deque(maxlen=REMEMBERED)

    def update(self, odometry: Odometry, scan: LaserScan | None) -> PoseEstimate:
        """Move by the odometry, then match the scan."""
        step = (
            self._odometry[-1].pose_robot_in_odom.relative(odometry.pose_robot_in_odom)
            if self._odometry
            else Pose2D(0.0, 0.0, 0.0)
        )
        self._odometry.append(odometry)
        self._pose, self._covariance = self._odometry_model.moved(self._pose, self._covariance, step)
        if scan is not None:
            scanner = self._scanner_now(scan)
            if scanner is not None:
                beams = Beams.of_scan(scan, scanner)
                self._pose, self._covariance = self._matcher.match(self._pose, self._covariance, beams)
        return PoseEstimate(odometry.time, self._pose, self._covariance)

    def relocalize(self) -> None:
        """Look everywhere."""

    def _scanner_now(self, scan: LaserScan) -> Pose2D | None:
        """Return where the scanner was when it measured, in the body frame of now; None if that was too long ago."""
        now = self._odometry[-1]
        if scan.time >= now.time:
            return scan.scanner_in_body
        later = now
        for earlier in reversed(self._odometry):
            if earlier.time <= scan.time:
                share = (scan.time - earlier.time) / (later.time - earlier.time) if later is not earlier else 0.0
                step = earlier.pose_robot_in_odom.relative(later.pose_robot_in_odom)
                then = earlier.pose_robot_in_odom.compose(Pose2D(share * step.x, share * step.y, share * step.yaw))
                return now.pose_robot_in_odom.relative(then).compose(scan.scanner_in_body)
            later = earlier
        return None
