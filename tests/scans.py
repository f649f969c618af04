"""Made laser scans: the ranges from a pose to boxes and discs, exact or with noise."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from han_bullet.geometry import Pose2D, SolidBox, rotation
from han_bullet.messages import LaserScan

SCANNER = Pose2D(0.2, 0.0, 0.0)
RANGE_MAX = 8.0

Disc = tuple[float, float, float]  # x, y, radius [m]


def scan_of(
    pose: Pose2D,
    boxes: Sequence[SolidBox] = (),
    discs: Sequence[Disc] = (),
    *,
    time: float = 0.0,
    rng: np.random.Generator | None = None,
    range_max: float = RANGE_MAX,
) -> LaserScan:
    """Return what a scanner of 270 degrees in steps of half a degree sees from a robot's pose in the world."""
    angles = np.radians(np.arange(-135.0, 135.25, 0.5))
    start = pose.to_world(SCANNER.position)
    rays = np.column_stack([np.cos(angles + pose.yaw), np.sin(angles + pose.yaw)])
    ranges = np.full(len(angles), np.inf)
    for box in boxes:
        ranges = np.minimum(ranges, _to_box(start, rays, box))
    for x, y, radius in discs:
        ranges = np.minimum(ranges, _to_disc(start, rays, x, y, radius))
    if rng is not None:
        ranges = ranges + rng.normal(0.0, 0.01, len(ranges))
    ranges = np.where(ranges > range_max, np.inf, ranges)
    return LaserScan(time, ranges, float(angles[0]), math.radians(0.5), 0.05, range_max, SCANNER)


def scan_at(*points_in_body: tuple[float, float], time: float = 0.0) -> LaserScan:
    """Return a scan with one ray per point, from a scanner in the middle of the robot; its rays lie unevenly."""
    points = sorted(points_in_body, key=lambda point: math.atan2(point[1], point[0]))
    angles = [math.atan2(y, x) for x, y in points]
    step = math.radians(0.01)
    first = math.floor(min(angles, default=0.0) / step)
    ranges = np.full(1 + (round(max(angles, default=0.0) / step) - first), np.inf)
    for (x, y), angle in zip(points, angles, strict=True):
        ray = round(angle / step) - first
        ranges[ray] = min(ranges[ray], math.hypot(x, y))
    return LaserScan(time, ranges, first * step, step, 0.05, RANGE_MAX, Pose2D(0.0, 0.0, 0.0))


def _to_box(start: np.ndarray, rays: np.ndarray, box: SolidBox) -> np.ndarray:
    turn = rotation(box.yaw)
    here, along = (start - box.centre_in_world[:2]) @ turn, rays @ turn
    along = np.where(np.abs(along) < 1e-12, 1e-12, along)
    half = 0.5 * box.size[:2]
    first, second = (-half - here) / along, (half - here) / along
    enter, leave = np.minimum(first, second).max(axis=1), np.maximum(first, second).min(axis=1)
    return np.where((enter <= leave) & (enter > 0.0), enter, np.inf)


def _to_disc(start: np.ndarray, rays: np.ndarray, x: float, y: float, radius: float) -> np.ndarray:
    offset = np.array([x, y]) - start
    along = rays @ offset
    beside = offset @ offset - along**2
    inside = np.maximum(radius**2 - beside, 0.0)
    return np.where((beside < radius**2) & (along > 0.0), along - np.sqrt(inside), np.inf)
