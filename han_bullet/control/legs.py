"""Legs in a scan, and how fast they go: small things that stand before their surroundings, in pairs or alone.

The tracker looks for legs of its own (`tracking/leg_clusters.py`), to place people whom cameras know: only where the
map has nothing, and no wider than legs are. Braking must depend on neither map nor tracks, and rather takes a post for
a leg.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array, Pose2D
from han_bullet.messages import LaserScan

BREAK = 0.12  # neighbouring points farther apart lie on two things [m]; rays are 0.035 m apart at 4 m
WIDEST = 0.3  # that a leg in trousers shows [m]
FEWEST = 3  # points of a leg; fewer are noise
FARTHEST = 4.0  # from the scanner [m]
BEFORE = 0.1  # what stands before its surroundings does so by this much [m]
STRIDE = 0.5  # legs nearer to each other than this are one person's [m]
FASTEST = 2.5  # that somebody goes [m/s]
SCANS = 3  # over which a velocity is taken: 0.3 s, about half a step, which evens out the swing of the legs
FADING = 0.2  # part by which a velocity follows a lower one with each scan; a higher one it takes at once
STILL = 0.3  # slower is noise [m/s]


class LegMotion:
    """Follow legs from scan to scan, just long enough to tell how fast they go; nobody gets a name."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, Array]] = deque(maxlen=SCANS)
        self._velocities: Array = np.zeros((0, 2))  # of the last scan's

    def update(self, scan: LaserScan, pose_in_odom: Pose2D) -> tuple[NDArray[np.bool_], Array]:
        """Take in a scan.

        Args:
            scan: The next one.
            pose_in_odom: Of the robot, in any frame that does not move.

        Returns:
            Which of the scan's points are legs', (n,), and the points' velocities in that frame, (n, 2) [m/s]; zero
            for all that is no leg, stands, or has not been seen for three scans.
        """
        points = pose_in_odom.to_world(scan.points_in_body)
        people = _people(scan, points)
        # The middle between both legs, however many points each has.
        middles = [np.mean([points[leg].mean(axis=0) for leg in legs], axis=0) for legs in people]
        found = np.array([self._velocity(scan.time, middle) for middle in middles]).reshape(-1, 2)
        is_leg, velocities = np.zeros(len(points), bool), np.zeros((len(points), 2))
        for legs, velocity in zip(people, found, strict=True):
            is_leg[np.concatenate(legs)] = True
            velocities[np.concatenate(legs)] = velocity if np.hypot(*velocity) > STILL else 0.0
        self._seen.append((scan.time, np.array(middles).reshape(-1, 2)))
        self._velocities = found
        return is_leg, velocities

    def _velocity(self, time: float, middle: Array) -> Array:
        """Return the velocity, (2,) [m/s]: the mean over the scans that are kept, or what is left of a higher one.

        People do not stop between two scans, but their legs seem to when one hides the other.
        """
        mean, before = self._mean_velocity(time, middle), self._velocity_before(middle)
        return mean if np.hypot(*mean) > np.hypot(*before) else before + FADING * (mean - before)

    def _mean_velocity(self, time: float, middle: Array) -> Array:
        """Return the mean velocity, (2,) [m/s], since the oldest scan; zero where it cannot be followed so far back."""
        if len(self._seen) < SCANS:
            return np.zeros(2)
        there, then = middle, time
        for seen_at, middles in reversed(self._seen):
            distances = np.hypot(*(middles - there).T)
            if not len(distances) or distances.min() > FASTEST * (then - seen_at):
                return np.zeros(2)
            there, then = middles[distances.argmin()], seen_at
        velocity: Array = (middle - there) / (time - then)
        return velocity

    def _velocity_before(self, middle: Array) -> Array:
        """Return the velocity, (2,) [m/s], of the nearest legs of the last scan."""
        if not len(self._velocities):
            return np.zeros(2)
        distances = np.hypot(*(self._seen[-1][1] - middle).T)
        velocity: Array = self._velocities[distances.argmin()]
        return velocity if distances.min() <= STRIDE else np.zeros(2)


def _people(scan: LaserScan, points: Array) -> list[list[NDArray[np.int64]]]:
    """Return each person's legs as rows of the scan's points, (n, 2) [m]."""
    met = np.flatnonzero(np.isfinite(scan.ranges))
    if not len(met):
        return []
    apart = np.flatnonzero((np.diff(met) > 1) | (np.hypot(*np.diff(points, axis=0).T) > BREAK)) + 1
    starts, stops = np.concatenate([[0], apart]), np.concatenate([apart, [len(met)]])
    slim = (stops - starts >= FEWEST) & (np.hypot(*(points[stops - 1] - points[starts]).T) <= WIDEST)
    slim &= np.maximum.reduceat(scan.ranges[met], starts) <= FARTHEST
    pieces = [np.arange(start, stop) for start, stop in zip(starts[slim], stops[slim], strict=True)]
    before = [_stands_before(scan.ranges, met[piece]) for piece in pieces]
    middles = [points[piece].mean(axis=0) for piece in pieces]
    people, taken = [], [False] * len(pieces)
    for first in (index for index, free in enumerate(before) if free):
        if taken[first]:
            continue
        own = [k for k, middle in enumerate(middles) if not taken[k] and np.hypot(*(middle - middles[first])) <= STRIDE]
        for k in own:
            taken[k] = True
        people.append([pieces[k] for k in own])
    return people


def _stands_before(ranges: Array, rays: NDArray[np.int64]) -> bool:
    """Tell whether the rays beside neighbouring ones reach farther; a piece of wall between two things does not."""
    first, last = int(rays[0]), int(rays[-1])
    if first == 0 or last == len(ranges) - 1:
        return False  # how much more there is, nobody sees
    return bool(ranges[first - 1] > ranges[first] + BEFORE and ranges[last + 1] > ranges[last] + BEFORE)
