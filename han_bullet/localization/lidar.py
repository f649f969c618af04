"""Localization by odometry and a laser scanner on a known map."""

from __future__ import annotations

from collections import deque

import numpy as np

from han_bullet.geometry import Array, Pose2D, largest_deviation
from han_bullet.localization.beams import Beams
from han_bullet.localization.global_search import GlobalSearch
from han_bullet.localization.health import Health
from han_bullet.localization.likelihood_field import LikelihoodField
from han_bullet.localization.localizer import Localization
from han_bullet.localization.monte_carlo import MonteCarlo
from han_bullet.localization.occupancy_grid import OccupancyGrid
from han_bullet.localization.odometry_model import OdometryModel
from han_bullet.localization.pose_filter import PoseFilter
from han_bullet.localization.scan_matching import ScanMatcher
from han_bullet.messages import LaserScan, Odometry, PoseEstimate

# Of what every scan shares, and no number of them averages away: edges lie anywhere in the map's cells. Of x, y, yaw.
MAP_ERROR = np.diag([0.007**2, 0.007**2, 0.003**2])  # [m^2], [rad^2]
UNSURE = 0.5  # standard deviation [m]: half a corridor, after 12 m without a scan
REMEMBERED = 40  # control ticks: a scan that is older than these cannot be placed


class LidarLocalization(Localization):
    """Track the pose by matching scans to the map; find it anew, on request, by particles."""

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
        self._grid = grid
        self._field = LikelihoodField.of_map(grid)
        self._matcher = ScanMatcher(self._field)
        self._odometry_model = odometry_model or OdometryModel()
        self._generator = generator
        self._health = Health(self._field, self._matcher, generator)
        self._search: GlobalSearch | None = None
        self._odometry: deque[Odometry] = deque(maxlen=REMEMBERED)
        self._tracked = PoseFilter(start, start_covariance, self._odometry_model)
        self._lost = False

    def update(self, odometry: Odometry, scan: LaserScan | None) -> PoseEstimate:
        """Move by the odometry, then look at the scan; once lost, stay so until a search has found the robot."""
        last = self._odometry[-1] if self._odometry else odometry
        self._odometry.append(odometry)
        (self._search or self._tracked).move(last.pose_robot_in_odom.relative(odometry.pose_robot_in_odom))
        scanner = None if scan is None else self._scanner_now(scan)
        if scan is not None and scanner is not None:
            self._look(scan.time, Beams.of_scan(scan, scanner))
        believed = self._search or self._tracked
        unsure = largest_deviation(believed.covariance[:2, :2]) > UNSURE
        return PoseEstimate(odometry.time, believed.pose, believed.covariance + MAP_ERROR, self._lost or unsure)

    def relocalize(self) -> None:
        """Scatter particles over the map; the scans to come decide."""
        particles = MonteCarlo(self._grid, self._field, self._odometry_model, self._generator)
        believed = (self._search or self._tracked).pose
        self._search, self._lost = GlobalSearch(particles, self._field, self._matcher, believed), True

    def _look(self, time: float, beams: Beams) -> None:
        if self._search is None:
            self._tracked.take_in(*self._matcher.match(self._tracked.pose, self._tracked.covariance, beams))
            self._lost = self._health.lost(time, self._tracked.pose, beams) or self._lost
            return
        self._search.look(beams)
        if self._search.found:
            self._tracked = PoseFilter(self._search.pose, self._search.covariance, self._odometry_model)
            self._health = Health(self._field, self._matcher, self._generator)
            self._search, self._lost = None, False

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
