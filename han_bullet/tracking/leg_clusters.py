"""Leg-sized things in a laser scan that the map does not know."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array, Pose2D, SolidBox, rotation
from han_bullet.messages import LaserScan

# Farther apart than this the ends of neighbouring rays lie on two things [m]; legs that stand side by side have 0.07 m
# between them, and a ray that passes there ends farther away.
JUMP = 0.1
# Of a leg, or of what is seen of one, and of two legs side by side with no ray between them [m].
LEG_WIDTHS = (0.05, 0.25)
# Of a clothed shin [m].
LEG_RADIUS = 0.06
# How far the middle of a leg is behind the mean of its visible half, in radii: that of sqrt(1 - x^2) over [-1, 1].
BEHIND_SURFACE = 0.25 * math.pi
# Nearer to a wall or to furniture of the map than this is the map [m]: a door's leaf is 0.05 m behind its wall's face.
MAP_TOLERANCE = 0.1
# Added to it, in deviations of where the map is as seen from the robot.
MAP_SIGMAS = 2.0


@dataclass(frozen=True)
class Legs:
    """Leg-sized things.

    Attributes:
        positions: Of their middles in the world, shape (n, 2) [m].
        ranges: From the scanner to the middles, shape (n,) [m].
    """

    positions: Array
    ranges: Array


def find_legs(
    scan: LaserScan, scanner_in_world: Pose2D, covariance: Array, obstacles: Sequence[SolidBox], reach: float
) -> Legs:
    """Return what is as wide as a leg and no part of the map, counter-clockwise.

    Args:
        scan: The sweep.
        scanner_in_world: Where it was taken.
        covariance: Of the robot's pose, shape (3, 3) [m^2, m rad, rad^2].
        obstacles: Walls and furniture of the map.
        reach: Legs farther from the scanner are not looked for [m].
    """
    angles = scan.angles
    rays = np.column_stack([np.cos(angles), np.sin(angles)])
    seen = (scan.ranges > scan.range_min) & (scan.ranges <= reach)
    ends = np.where(seen, scan.ranges, 0.0)[:, None] * rays
    found = []
    for start, stop, chord in _segments(ends, seen):
        distance = float(scan.ranges[start:stop].mean())
        # The edges of a leg lie up to a ray outside its outermost hits, half of one on either side on average.
        if not LEG_WIDTHS[0] <= chord + distance * scan.angle_increment <= LEG_WIDTHS[1]:
            continue
        spread = MAP_SIGMAS * _deviation(covariance, distance)
        if not _on_map(scanner_in_world.to_world(ends[start:stop]), obstacles, MAP_TOLERANCE + spread):
            middle = 0.5 * (angles[start] + angles[stop - 1])
            found.append((middle, distance + BEHIND_SURFACE * LEG_RADIUS))
    middles, ranges = np.array(found).reshape(-1, 2).T
    positions = ranges[:, None] * np.column_stack([np.cos(middles), np.sin(middles)])
    return Legs(scanner_in_world.to_world(positions), ranges)


def _segments(ends: Array, seen: NDArray[np.bool_]) -> list[tuple[int, int, float]]:
    """Return the runs of two or more neighbouring rays that end near to one another, unless they are wider than legs.

    First row, row after the last, and between their ends [m].
    """
    gaps = np.hypot(*np.diff(ends, axis=0).T)
    joined = seen[1:] & seen[:-1] & (gaps <= JUMP)
    starts = np.flatnonzero(seen & ~np.concatenate([[False], joined]))
    stops = np.flatnonzero(seen & ~np.concatenate([joined, [False]])) + 1
    chords = np.hypot(*(ends[stops - 1] - ends[starts]).T)
    kept = (stops - starts >= 2) & (chords <= LEG_WIDTHS[1])
    return list(zip(starts[kept].tolist(), stops[kept].tolist(), chords[kept].tolist(), strict=True))


def _deviation(covariance: Array, distance: float) -> float:
    """Return how far off a thing at a distance [m] may be because of the robot's pose [m], as a standard deviation."""
    return math.sqrt(float(np.trace(covariance[:2, :2]) + distance**2 * covariance[2, 2]))


def _on_map(points: Array, obstacles: Sequence[SolidBox], tolerance: float) -> bool:
    """Tell whether at least half of some points, shape (n, 2) [m], lie on the map's walls and furniture."""
    near = np.zeros(len(points), bool)
    reach = tolerance + float(np.hypot(*(points - points[0]).T).max())
    for box in obstacles:
        if math.dist(points[0], box.centre_in_world[:2]) > 0.5 * math.hypot(*box.size[:2]) + reach:
            continue  # too far away for all of them
        in_box = (points - box.centre_in_world[:2]) @ rotation(box.yaw)
        outside = np.maximum(np.abs(in_box) - 0.5 * box.size[:2], 0.0)
        near |= np.hypot(outside[:, 0], outside[:, 1]) <= tolerance
    return 2 * int(near.sum()) >= len(points)
