"""Monte Carlo localization: the pose as weighted samples, from anywhere on the map [Thrun2005]."""

from __future__ import annotations

import math

import numpy as np

from han_bullet.geometry import Array, Pose2D, wrap_angle
from han_bullet.localization.beams import Beams
from han_bullet.localization.likelihood_field import LikelihoodField
from han_bullet.localization.occupancy_grid import FREE, OccupancyGrid
from han_bullet.localization.odometry_model import OdometryModel
from han_bullet.localization.particles import drawn, effective_count, sufficient_count, tempered

DENSITY = 200.0  # samples per square metre of free floor at first
LEAST, MOST = 500, 60_000  # samples
MOST_DRAWN = 8_000  # once scans have told where it is worth looking
BEAMS = 36  # of a scan: neighbours tell the same
TEMPER = 0.2  # power of the likelihood: even these are not independent
EFFECTIVE = 300.0  # samples at least that a scan leaves with weight, so that no place is lost by chance
SOFTEST, SOFTENING, HARDEST = 0.25, 0.6, 0.1  # deviation of the beams' ends [m]: at first, by each scan, at last
INJECTED = 0.1  # share of samples that are drawn from everywhere, against having lost the true place


class MonteCarlo:
    """Samples of the pose on a map.

    Attributes:
        poses: x, y, yaw, shape (n, 3).
        weights: Sum to 1, shape (n,).
        scans: How many were taken in.
    """

    def __init__(
        self, grid: OccupancyGrid, field: LikelihoodField, odometry_model: OdometryModel, generator: np.random.Generator
    ) -> None:
        """Scatter samples over the free cells of a map."""
        self._field = field
        self._odometry_model = odometry_model
        self._generator = generator
        rows, columns = np.nonzero(grid.cells == FREE)
        self._corners = grid.origin_in_world + grid.resolution * np.column_stack([columns, rows])
        self._resolution = grid.resolution
        count = round(DENSITY * len(self._corners) * grid.resolution**2)
        self.poses = self._anywhere(min(max(count, LEAST), MOST))
        self.weights: Array = np.full(len(self.poses), 1.0 / len(self.poses))
        self.scans = 0

    def move(self, step: Pose2D) -> None:
        """Let every sample make a step of the odometry, each with a slip of its own."""
        self.poses = self._odometry_model.sampled(self.poses, step, self._generator)

    def weigh(self, beams: Beams) -> None:
        """Take in a scan, and draw anew where few samples have the weight."""
        deviation = max(SOFTEST * SOFTENING**self.scans, HARDEST)
        logs, _, _ = self._field.likelihoods(self.poses, beams.some(BEAMS), deviation)
        self.weights = tempered(self.weights, logs, TEMPER, EFFECTIVE)
        self.scans += 1
        if effective_count(self.weights) < 0.5 * len(self.weights):
            self._draw(deviation)

    def _draw(self, deviation: float) -> None:
        chosen = self.poses[drawn(self.weights, len(self.poses), self._generator)]
        count = sufficient_count(chosen, LEAST, MOST_DRAWN)
        chosen = self.poses[drawn(self.weights, count, self._generator)]
        # Copies of a sample part by as much as the likelihood cannot tell.
        scatter = 0.4 * deviation * np.array([1.0, 1.0, 0.5])
        chosen = chosen + scatter * self._generator.normal(size=chosen.shape)
        fresh = self._anywhere(round(INJECTED * count))
        self.poses = np.concatenate([chosen, fresh])
        self.weights = np.full(len(self.poses), 1.0 / len(self.poses))

    def _anywhere(self, count: int) -> Array:
        corners = self._corners[self._generator.integers(len(self._corners), size=count)]
        places = corners + self._resolution * self._generator.random((count, 2))
        return np.column_stack([places, self._generator.uniform(-math.pi, math.pi, count)])

    def clusters(self, at_most: int) -> Array:
        """Return the mean poses of the heaviest clusters, shape (n, 3), heaviest first."""
        size = np.array([0.5, 0.5, math.radians(30.0)])
        turned = np.column_stack([self.poses[:, :2], np.mod(self.poses[:, 2], 2.0 * math.pi)])
        _, member = np.unique(np.floor(turned / size).astype(np.int64), axis=0, return_inverse=True)
        member = member.ravel()
        mass = np.bincount(member, self.weights)
        order = np.argsort(-mass)[:at_most]
        sums = [np.bincount(member, self.weights * column) for column in turned.T]
        means: Array = np.column_stack([total[order] / mass[order] for total in sums])
        return means

    def covariance(self) -> Array:
        """Return the covariance of all samples, shape (3, 3); of yaw about the mean direction."""
        mean = math.atan2(self.weights @ np.sin(self.poses[:, 2]), self.weights @ np.cos(self.poses[:, 2]))
        off = self.poses - [*(self.weights @ self.poses[:, :2]), mean]
        off[:, 2] = wrap_angle(off[:, 2])
        spread: Array = (off * self.weights[:, None]).T @ off
        return spread
