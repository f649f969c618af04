"""Refine a predicted pose by the scan: the most likely pose by both, and how sure it is."""

from __future__ import annotations

import math

import numba
import numpy as np

from han_bullet.errors import check_positive
from han_bullet.geometry import Array, Pose2D, wrap_angle
from han_bullet.localization.beams import Beams
from han_bullet.localization.likelihood_field import LikelihoodField

STEPS = 20
CONVERGED = 1e-5  # [m] and [rad]
# A cell in which the distance bends by more [cells] is at a corner. A beam that ends beyond one draws the pose back;
# where before it a beam ends tells nothing of the corner: its word has one side only, and no deviation.
CURVED = 0.15


class ScanMatcher:
    """Levenberg-Marquardt on -log p(scan | pose) - log p(pose | prediction): an iterated Kalman update, outliers aside.

    A beam's end at a distance d from the nearest surface has p(d) = exp(-d^2 / (2 deviation^2)) + outlier. Each step
    weighs a beam by the share of the first term, so that people and what was put there pull at nothing.
    """

    def __init__(
        self,
        field: LikelihoodField,
        *,
        deviation: float = 0.02,
        outlier: float = 0.05,
        independent: float = 0.5,
    ) -> None:
        """Take the map.

        Args:
            field: Distances from its surfaces.
            deviation: Of a beam's end from the surface that it hit, by sensor and map [m].
            outlier: Weight of beams that hit none.
            independent: Share of the beams that tell something of their own: neighbours share the map's errors, and so
                do scans that follow each other.

        Raises:
            BadInputError: A number is not positive.
        """
        check_positive("scan matcher", deviation=deviation, outlier=outlier, independent=independent)
        self.field = field
        self.deviation = deviation
        self.outlier = outlier
        self.independent = independent

    def match(self, prediction: Pose2D, covariance: Array, beams: Beams) -> tuple[Pose2D, Array]:
        """Return the most likely pose and its covariance, (3, 3), by a prediction with covariance and a scan."""
        information = information_of(covariance)
        pose, of_scan = self._refine(prediction, information, beams)
        matched: Array = np.asarray(np.linalg.inv(of_scan + information), np.float64)
        return pose, matched

    def most_likely(self, prediction: Pose2D, information: Array, beams: Beams) -> Pose2D:
        """Return the pose alone, by the inverse of the prediction's covariance: half the time of a match."""
        return self._refine(prediction, information, beams)[0]

    def _refine(self, prediction: Pose2D, information: Array, beams: Beams) -> tuple[Pose2D, Array]:
        """Return the most likely pose and what the scan alone tells of it, an information matrix, (3, 3)."""
        ends = beams.ends_in_body[beams.returned]
        x, y = self.field.origin_in_world
        start = np.array([prediction.x, prediction.y, prediction.yaw])
        pose = start
        # From afar only a soft likelihood has a slope.
        for deviation in (4.0 * self.deviation, self.deviation):
            pose, of_scan = _most_likely(
                self.field.distance,
                x,
                y,
                self.field.resolution,
                ends,
                start,
                information,
                pose,
                deviation,
                self.outlier,
                self.independent,
            )
        return Pose2D(float(pose[0]), float(pose[1]), wrap_angle(float(pose[2]))), of_scan


def information_of(covariance: Array) -> Array:
    """Return the inverse of a covariance, (3, 3)."""
    inverse: Array = np.asarray(np.linalg.inv(covariance), np.float64)
    return inverse


@numba.njit(cache=True)
def _most_likely(
    distance: Array,
    origin_x: float,
    origin_y: float,
    resolution: float,
    ends: Array,
    prediction: Array,
    information: Array,
    start: Array,
    deviation: float,
    outlier: float,
    independent: float,
) -> tuple[Array, Array]:
    """Return the pose that costs least, shape (3,), and the information of the scan there, (3, 3)."""
    pose, damping = start.copy(), 1e-6
    weight = independent / deviation**2
    hessian, certain, slope, cost = _normal_equations(
        distance, origin_x, origin_y, resolution, ends, pose, deviation, outlier
    )
    off = pose - prediction
    cost = independent * cost + 0.5 * float(off @ information @ off)
    for _ in range(STEPS):
        curvature = weight * hessian + information
        damped = curvature + damping * np.diag(np.diag(curvature))
        step = -np.linalg.solve(damped, weight * slope + information @ (pose - prediction))
        tried = pose + step
        h, k, g, c = _normal_equations(distance, origin_x, origin_y, resolution, ends, tried, deviation, outlier)
        off = tried - prediction
        c = independent * c + 0.5 * float(off @ information @ off)
        if c <= cost:
            pose, hessian, certain, slope, cost = tried, h, k, g, c
            damping = max(0.1 * damping, 1e-9)
            if np.abs(step).max() < CONVERGED:
                break
        else:
            damping = max(10.0 * damping, 1e-3)
            if damping > 1e6:
                break
    return pose, weight * certain


@numba.njit(cache=True)
def _normal_equations(
    distance: Array,
    origin_x: float,
    origin_y: float,
    resolution: float,
    ends: Array,
    pose: Array,
    deviation: float,
    outlier: float,
) -> tuple[Array, Array, Array, float]:
    """Return J^T W J, what of it is of flat surfaces, J^T W d and -log p of ends, shape (n, 2) [m], at distances d."""
    rows, columns = distance.shape
    c, s = math.cos(pose[2]), math.sin(pose[2])
    hessian, certain, slope, cost = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros(3), 0.0
    jacobian = np.zeros(3)
    for i in range(len(ends)):
        arm_x, arm_y = c * ends[i, 0] - s * ends[i, 1], s * ends[i, 0] + c * ends[i, 1]
        u = (pose[0] + arm_x - origin_x) / resolution - 0.5
        v = (pose[1] + arm_y - origin_y) / resolution - 0.5
        column = min(max(math.floor(u), 0), columns - 2)
        row = min(max(math.floor(v), 0), rows - 2)
        # Beyond the border the distance goes on as at it, so that there the slope is none.
        u, v = min(max(u - column, 0.0), 1.0), min(max(v - row, 0.0), 1.0)
        d00, d01 = distance[row, column], distance[row, column + 1]
        d10, d11 = distance[row + 1, column], distance[row + 1, column + 1]
        d = (1.0 - v) * ((1.0 - u) * d00 + u * d01) + v * ((1.0 - u) * d10 + u * d11)
        jacobian[0] = ((1.0 - v) * (d01 - d00) + v * (d11 - d10)) / resolution
        jacobian[1] = ((1.0 - u) * (d10 - d00) + u * (d11 - d01)) / resolution
        jacobian[2] = jacobian[1] * arm_x - jacobian[0] * arm_y
        hit = math.exp(-0.5 * (d / deviation) ** 2)
        weight = hit / (hit + outlier)
        flat = abs(d00 - d01 - d10 + d11) < CURVED * resolution
        cost -= math.log((hit + outlier) / (1.0 + outlier))
        for a in range(3):
            weighed = weight * jacobian[a]
            slope[a] += weighed * d
            for b in range(3):
                hessian[a, b] += weighed * jacobian[b]
                if flat:
                    certain[a, b] += weighed * jacobian[b]
    return hessian, certain, slope, cost
