"""Who made which measurement: gates, the contract of an association, and the two simple ones."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from han_bullet.errors import BadInputError, check_positive
from han_bullet.geometry import Array

# Squared; 99 % of the true measurements of a two-dimensional Gaussian lie inside.
MAHALANOBIS_GATE = 9.21
# [m]: nobody is measured farther from their prediction than this, however uncertain the track.
DISTANCE_GATE = 1.0
# Of a true measurement inside `MAHALANOBIS_GATE`.
GATE_PROBABILITY = 0.99
# Of a person in view, per frame: the detector's recall. Assumed, not fitted. 20 runs of real2 and sim1 (one walker,
# 14 550 frames) had a foot point within 1 m of the person in 0.998 of the ceiling frames with the person in view and in
# 0.92 of the onboard ones; rooms with more people, and photographs, are harder.
DETECTION_PROBABILITY = 0.9
# False measurements per frame and square metre of visible floor. Assumed, not fitted: those runs had 8 in all, 3e-5.
# With either value a lone pair inside the gates outweighs a miss.
CLUTTER_DENSITY = 0.005

Pairs = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Gating:
    """Which of m measurements may belong to which of n tracks, and how well they fit.

    Attributes:
        squared_mahalanobis: Shape (n, m).
        density: Of each measurement under each track's prediction, N(z; H x, S), shape (n, m) [1/m^2].
        inside: Whether a pair is inside both gates, shape (n, m).
    """

    squared_mahalanobis: Array
    density: Array
    inside: NDArray[np.bool_]


def gate(tracks: Array, track_covariances: Array, measurements: Array, covariances: Array) -> Gating:
    """Compare predicted positions with measured ones.

    Args:
        tracks: Predicted positions, shape (n, 2) [m].
        track_covariances: Shape (n, 2, 2) [m^2].
        measurements: Shape (m, 2) [m].
        covariances: Of the measurements, shape (m, 2, 2) [m^2].
    """
    difference = measurements[None, :, :] - tracks[:, None, :]
    innovation = track_covariances[:, None] + covariances[None, :]
    squared = np.einsum("nmi,nmij,nmj->nm", difference, np.linalg.inv(innovation), difference)
    density = np.exp(-0.5 * squared) / (2.0 * np.pi * np.sqrt(np.linalg.det(innovation)))
    inside = (squared <= MAHALANOBIS_GATE) & (np.hypot(difference[..., 0], difference[..., 1]) <= DISTANCE_GATE)
    return Gating(squared, density, inside)


class Association(ABC):
    """Decide which track takes which measurement.

    Args:
        detection_probability: Of a person in view, per frame.
        clutter_density: [1/m^2] per frame.

    Raises:
        BadInputError: One of them is not positive, or the probability is above 1.
    """

    def __init__(
        self, *, detection_probability: float = DETECTION_PROBABILITY, clutter_density: float = CLUTTER_DENSITY
    ) -> None:
        check_positive("association", detection_probability=detection_probability, clutter_density=clutter_density)
        if detection_probability > 1.0:
            raise BadInputError(f"association: detection_probability is {detection_probability}; it must be at most 1")
        self.detection_probability = detection_probability
        self.clutter_density = clutter_density

    @property
    def miss_weight(self) -> float:
        """Return the weight of "this track has no measurement", 1 - Pd Pg."""
        return 1.0 - self.detection_probability * GATE_PROBABILITY

    def log_weights(self, gating: Gating) -> Array:
        """Return the logarithm of each pair's weight against clutter, Pd N(z) / density, shape (n, m).

        Outside the gates, and where the density is 0, it is -inf. Weights themselves may be too large for a float.
        """
        density = np.log(gating.density, out=np.full(gating.density.shape, -np.inf), where=gating.density > 0.0)
        weighted = density + math.log(self.detection_probability) - math.log(self.clutter_density)
        return np.where(gating.inside, weighted, -np.inf)

    @abstractmethod
    def assign(self, gating: Gating) -> Pairs:
        """Return pairs (row of the track, row of the measurement), each at most once, in the order of the tracks."""


class NearestNeighbour(Association):
    """Let the closest pair, by Mahalanobis distance, take each other; then the closest of what is left."""

    def assign(self, gating: Gating) -> Pairs:
        """Return the pairs; see `Association.assign`."""
        return take_best_first(-gating.squared_mahalanobis, gating.inside)


class GlobalNearestNeighbour(Association):
    """Take the single most likely joint event: each track its measurement or none."""

    def assign(self, gating: Gating) -> Pairs:
        """Return the pairs; see `Association.assign`."""
        n, m = gating.inside.shape
        # One private "no measurement" column per track; a pair outside the gate costs more than any number of misses.
        costs = np.full((n, m + n), 1e9)
        log_weights = self.log_weights(gating)
        possible = log_weights > -np.inf
        costs[:, :m][possible] = -log_weights[possible]
        costs[np.arange(n), m + np.arange(n)] = -np.log(self.miss_weight)
        rows, columns = linear_sum_assignment(costs)
        return tuple((int(i), int(j)) for i, j in zip(rows, columns, strict=True) if j < m)


def take_best_first(values: Array, allowed: NDArray[np.bool_]) -> Pairs:
    """Pair rows with columns greedily, the largest allowed value (n, m) first; equal values in row-major order."""
    rows, columns = np.nonzero(allowed)
    order = np.argsort(-values[rows, columns], kind="stable")
    taken_by: dict[int, int] = {}
    used: set[int] = set()
    for k in order:
        i, j = int(rows[k]), int(columns[k])
        if i not in taken_by and j not in used:
            taken_by[i] = j
            used.add(j)
    return tuple(sorted(taken_by.items()))
