"""People's legs in the robot's laser scans: a second measurement of whom the cameras have found, near the robot."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from han_bullet.geometry import Array, Pose2D, SolidBox, largest_deviation, wrap_angle
from han_bullet.messages import LaserScan, LegScan, PoseEstimate, Posture, Seat, TrackedPerson
from han_bullet.tracking.leg_clusters import find_legs
from han_bullet.tracking.seats import in_sitting_area

# From the scanner [m]: farther away a leg is three rays wide.
REACH = 4.0
# Between the middles of one person's legs [m].
STRIDE = 0.6
# Of a pair's middle from its person's, along and across the ray [m].
PAIR_DEVIATIONS = (0.05, 0.05)
# How far a person is behind the middle of their only visible leg [m]: the other is beside it or behind it.
BEHIND_LEG = 0.12
# Of that place from the person's, along and across the ray [m].
SINGLE_DEVIATIONS = (0.1, 0.1)
# Nearer than this to the scanner somebody's legs cannot be between two rays, or too narrow [m].
SURE_REACH = 2.0
# Nobody stands where rays pass everywhere within this of a place [m], and twice its deviation.
BODY_RADIUS = 0.3


class LegFinder(ABC):
    """Something that finds people's legs."""

    @abstractmethod
    def find(self, scan: LaserScan | None, estimate: PoseEstimate, people: Sequence[TrackedPerson]) -> LegScan | None:
        """Return the legs of a tick; None where there is nothing to tell.

        Args:
            scan: Of the laser, None between two.
            estimate: Of where the robot was when it was taken.
            people: The people as known before.
        """


class LaserLegs(LegFinder):
    """Find the legs that are no part of the map, and the people whose place is empty.

    In sitting areas no legs are looked for: the shins of who sits are half a metre before them, and seated people stay
    the cameras' business.

    Args:
        obstacles: Walls and furniture of the map.
        seats: Sitting areas of the map.
    """

    def __init__(self, *, obstacles: Sequence[SolidBox] = (), seats: Sequence[Seat] = ()) -> None:
        self._obstacles = tuple(obstacles)
        self._seats = tuple(seats)

    def find(self, scan: LaserScan | None, estimate: PoseEstimate, people: Sequence[TrackedPerson]) -> LegScan | None:
        """Return the legs of a sweep; see `LegFinder.find`. From a pose that is lost nothing can be placed."""
        if scan is None or estimate.lost:
            return None
        scanner = estimate.pose_robot_in_world.compose(scan.scanner_in_body)
        legs = find_legs(scan, scanner, estimate.covariance, self._obstacles, REACH)
        on_floor = ~np.array([self._in_seat(leg) for leg in legs.positions], bool)
        positions, deviations = _people_of(legs.positions[on_floor], scanner)
        vacant = tuple(p.id for p in people if self._is_vacant(p, scan, scanner))
        if not len(positions) and not vacant:
            return None
        return LegScan(scan.time, positions, _covariances(positions, deviations, scanner, estimate.covariance), vacant)

    def _in_seat(self, position: Array) -> bool:
        return any(in_sitting_area(seat, position) for seat in self._seats)

    def _is_vacant(self, person: TrackedPerson, scan: LaserScan, scanner: Pose2D) -> bool:
        """Tell whether rays pass wherever a person might stand."""
        place = person.position_in_world + (scan.time - person.time) * person.velocity_in_world
        radius = BODY_RADIUS + 2.0 * largest_deviation(person.covariance[:2, :2])
        distance = scanner.distance_to(place)
        if person.posture is Posture.SEATED or self._in_seat(place) or not radius < distance <= SURE_REACH:
            return False
        x, y = place - scanner.position
        bearing, half = wrap_angle(math.atan2(y, x) - scanner.yaw), math.asin(radius / distance)
        angles = scan.angles
        if bearing - half < angles[0] or bearing + half > angles[-1]:
            return False
        return bool((scan.ranges[np.abs(angles - bearing) <= half] > distance + radius).all())


def _people_of(legs: Array, scanner: Pose2D) -> tuple[Array, Array]:
    """Return whom legs, (n, 2) [m], belong to: places (m, 2) and deviations along and across the ray, (m, 2) [m].

    The two that are nearest to one another are a pair, then the nearest of what is left.
    """
    single = list(range(len(legs)))
    distances = np.linalg.norm(legs[:, None] - legs[None, :], axis=2)
    places, deviations = [], []
    rows, columns = np.nonzero(np.triu(distances <= STRIDE, 1))
    for k in np.argsort(distances[rows, columns], kind="stable"):
        i, j = int(rows[k]), int(columns[k])
        if i in single and j in single:
            single.remove(i)
            single.remove(j)
            places.append(0.5 * (legs[i] + legs[j]))
            deviations.append(PAIR_DEVIATIONS)
    for i in single:
        ray = legs[i] - scanner.position
        places.append(legs[i] + BEHIND_LEG * ray / np.hypot(*ray))
        deviations.append(SINGLE_DEVIATIONS)
    return np.array(places).reshape(-1, 2), np.array(deviations).reshape(-1, 2)


def _covariances(positions: Array, deviations: Array, scanner: Pose2D, of_pose: Array) -> Array:
    """Return covariances in the world, shape (n, 2, 2) [m^2], the robot's pose being as uncertain as it is.

    Args:
        positions: Shape (n, 2) [m].
        deviations: Along and across the ray, shape (n, 2) [m].
        scanner: Where the rays begin.
        of_pose: Covariance of the robot's pose, shape (3, 3) [m^2, m rad, rad^2].
    """
    rays = positions - scanner.position
    along = rays / np.maximum(np.linalg.norm(rays, axis=1, keepdims=True), 1e-9)
    across = along[:, ::-1] * [-1.0, 1.0]
    axes = np.stack([along, across], axis=2) * deviations[:, None, :]
    moved = np.concatenate([np.tile(np.eye(2), (len(rays), 1, 1)), (rays[:, ::-1] * [-1.0, 1.0])[:, :, None]], axis=2)
    covariances: Array = axes @ axes.transpose(0, 2, 1) + moved @ of_pose @ moved.transpose(0, 2, 1)
    return covariances
