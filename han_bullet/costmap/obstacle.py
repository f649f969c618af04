"""What the laser scanner sees and the map does not have, after costmap_2d's ObstacleLayer [MarderEppstein2010]."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.costmap.grid import FREE, LETHAL, Costmap, Costs
from han_bullet.costmap.inflation import distance_to_obstacles
from han_bullet.costmap.layer import Layer, seat_of
from han_bullet.errors import check_positive
from han_bullet.geometry import Array, Pose2D
from han_bullet.messages import LaserScan, Scene, TrackedPerson

# Evidence of a cell: a scan that ends in it adds HIT, one that only passes through takes PASS away. It is marked from
# MARKED on, after three hits, and stays so until nothing is left of at most MOST: seven scans, 0.7 s at 10 Hz.
HIT, PASS, MARKED, MOST = 2, 1, 5, 7
POSE_ERROR = (0.05, math.radians(1.0))  # of localization [m], [rad]: so far off a hit still belongs to what the map has
NOISE = 0.03  # three deviations of a range [m]
SHORT = 0.1  # a ray clears up to so far before its end [m], lest noise and grazing rays eat the obstacle's face
LEAD = 0.3  # a walker's legs are looked for where they are within this time, before and after [s]
LARGEST_MARGIN = 0.2  # that a vague track adds to a person's radius [m]
SEATED_LEGS = 0.5  # before the body of who sits [m]

PASSED, ENDED = 1, 2


class ObstacleLayer(Layer):
    """Mark where scans end, clear where they pass: LETHAL, and inflated with the building.

    Unlike costmap_2d's, it wants several consistent hits, leaves out what the map has within the error of the pose, and
    leaves people to their own layers: what a scan meets near a confirmed track is not marked, and marks in a person's
    way are forgotten. As there, cells that cannot be seen stay as they were seen last.
    """

    name = "obstacle"

    def __init__(
        self,
        *,
        robot_radius: float,
        obstacle_range: float = 4.0,
        raytrace_range: float = 6.0,
        person_radius: float = 0.45,
    ) -> None:
        """Configure the ranges.

        Args:
            robot_radius: Of the footprint [m]; where the robot stands is nothing else.
            obstacle_range: Farther hits are not marked [m].
            raytrace_range: Up to which rays clear [m].
            person_radius: What is nearer to a track belongs to the person [m]: body, legs and the track's error.
        """
        check_positive(f"layer {self.name}", robot_radius=robot_radius, obstacle_range=obstacle_range)
        check_positive(f"layer {self.name}", raytrace_range=raytrace_range, person_radius=person_radius)
        self.robot_radius = robot_radius
        self.obstacle_range = obstacle_range
        self.raytrace_range = raytrace_range
        self.person_radius = person_radius
        self._scanned_at = -math.inf
        self._grid: tuple[float, ...] = ()
        self._building: Costs = np.zeros((0, 0), np.uint8)
        self._to_building: Array = np.zeros((0, 0))
        self._evidence: NDArray[np.uint8] = np.zeros((0, 0), np.uint8)
        self._marks: Costs = np.zeros((0, 0), np.uint8)

    def apply(self, costmap: Costmap, scene: Scene) -> None:
        """Take in the scene's scan, if it is a new one, and raise the marked cells as part of the building."""
        grid = (*costmap.shape, *costmap.origin_in_world, costmap.resolution)
        if grid != self._grid:
            self._grid = grid
            self._evidence, self._marks = np.zeros(costmap.shape, np.uint8), np.full(costmap.shape, FREE, np.uint8)
        scan, pose = scene.laser, scene.pose_robot_at_scan or scene.pose_robot_in_world
        if scan is not None and pose is not None and scan.time > self._scanned_at:
            self._scanned_at = scan.time
            self._take_in(costmap, scan, pose, scene)
        costmap.raise_building_to(self._marks)

    def clear(self) -> None:
        """Forget all marks; what is still there is marked anew by the scans to come."""
        self._grid = ()

    def _take_in(self, costmap: Costmap, scan: LaserScan, pose: Pose2D, scene: Scene) -> None:
        scanner = pose.to_world(scan.scanner_in_body.position)
        angles = scan.angles + scan.scanner_in_body.yaw + pose.yaw
        rays = np.column_stack([np.cos(angles), np.sin(angles)])
        met = np.isfinite(scan.ranges)
        ends = scanner + np.where(met, scan.ranges, 0.0)[:, None] * rays
        near = met & (scan.ranges <= self.obstacle_range)
        new = near & ~self._is_known(costmap, ends, scan.ranges) & ~self._is_person(ends, scene)
        free = np.where(met, scan.ranges - SHORT, np.minimum(self.raytrace_range, scan.range_max))
        free = np.minimum(free, self.raytrace_range)
        corner = (scanner - costmap.origin_in_world) / costmap.resolution
        swept = _swept(costmap.shape, corner, rays, free / costmap.resolution)
        rows, columns = costmap.world_to_cell(ends[new]).T
        swept[rows, columns] = ENDED
        _weigh(swept, self._evidence, self._marks)
        self._forget_around(costmap, pose.position, pose.position, self.robot_radius)
        for person in scene.people:
            self._forget_around(costmap, *_reach(person, scene), self._radius(person))

    def _is_known(self, costmap: Costmap, ends_in_world: Array, ranges: Array) -> NDArray[np.bool_]:
        """Tell which hits, (n, 2) [m] at some ranges [m], what the map has explains."""
        if not np.array_equal(costmap.building, self._building):
            self._building = costmap.building.copy()
            self._to_building = distance_to_obstacles(self._building >= LETHAL, costmap.resolution)
        rows, columns = costmap.world_to_cell(ends_in_world).T
        inside = (rows >= 0) & (rows < costmap.shape[0]) & (columns >= 0) & (columns < costmap.shape[1])
        gap = np.zeros(len(ends_in_world))  # what lies beyond the map is none of ours
        gap[inside] = self._to_building[rows[inside], columns[inside]]
        tolerance = POSE_ERROR[0] + POSE_ERROR[1] * ranges + NOISE + math.sqrt(0.5) * costmap.resolution
        known: NDArray[np.bool_] = gap <= tolerance
        return known

    def _is_person(self, ends_in_world: Array, scene: Scene) -> NDArray[np.bool_]:
        """Tell which hits, (n, 2) [m], belong to a tracked person."""
        found = np.zeros(len(ends_in_world), bool)
        for person in scene.people:
            start, end = _reach(person, scene)
            x, y = ends_in_world.T
            found |= _distance_to_line(x, y, start, end) <= self._radius(person)
        return found

    def _radius(self, person: TrackedPerson) -> float:
        deviation = math.sqrt(max(float(np.trace(person.covariance[:2, :2])), 0.0))
        return self.person_radius + min(deviation, LARGEST_MARGIN)

    def _forget_around(self, costmap: Costmap, start: Array, end: Array, radius: float) -> None:
        """Forget what was seen near a stretch of floor, two points (2,) [m]."""
        middle, half = 0.5 * (start + end), 0.5 * math.dist(start, end)
        window, x, y = costmap.centres_in_window(middle, half + radius)
        near = _distance_to_line(x, y, start, end) <= radius
        self._evidence[window][near] = 0
        self._marks[window][near] = FREE


def _reach(person: TrackedPerson, scene: Scene) -> tuple[Array, Array]:
    """Return the two ends, (2,) [m], of the stretch of floor about which a person's legs are."""
    here, seat = person.position_in_world, seat_of(person, scene)
    if seat is not None:
        return here, here + SEATED_LEGS * np.array([math.cos(seat.facing), math.sin(seat.facing)])
    return here - LEAD * person.velocity_in_world, here + LEAD * person.velocity_in_world


def _distance_to_line(x: Array, y: Array, start: Array, end: Array) -> Array:
    """Return the distances [m] of points, x and y [m] that broadcast, from the line between two points, (2,) [m]."""
    along = end - start
    dx, dy = x - start[0], y - start[1]
    part = np.clip((dx * along[0] + dy * along[1]) / max(float(along @ along), 1e-12), 0.0, 1.0)
    distance: Array = np.hypot(dx - part * along[0], dy - part * along[1])
    return distance


@numba.njit(cache=True)
def _swept(shape: tuple[int, int], start: Array, rays: Array, lengths: Array) -> NDArray[np.uint8]:
    """Return a grid with PASSED in the cells that rays cross, from cell to cell.

    Args:
        shape: Rows and columns.
        start: Of the rays, x and y in cells from the grid's corner, (2,).
        rays: Unit vectors, (n, 2).
        lengths: Up to which they count [cells]; none for less than zero, (n,).
    """
    swept = np.zeros(shape, np.uint8)
    for ray in range(len(rays)):
        dx, dy = rays[ray]
        column, row = math.floor(start[0]), math.floor(start[1])
        step_x, step_y = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
        # Lengths along the ray to its next crossing of a column's and of a row's border, and from one to the next.
        width = abs(1.0 / dx) if dx != 0.0 else math.inf
        height = abs(1.0 / dy) if dy != 0.0 else math.inf
        next_x = ((column + 1 - start[0]) if dx > 0.0 else (start[0] - column)) * width if dx != 0.0 else math.inf
        next_y = ((row + 1 - start[1]) if dy > 0.0 else (start[1] - row)) * height if dy != 0.0 else math.inf
        reached = 0.0
        while reached <= lengths[ray] and 0 <= row < shape[0] and 0 <= column < shape[1]:
            swept[row, column] = PASSED
            if next_x < next_y:
                column, reached, next_x = column + step_x, next_x, next_x + width
            else:
                row, reached, next_y = row + step_y, next_y, next_y + height
    return swept


@numba.njit(cache=True)
def _weigh(swept: NDArray[np.uint8], evidence: NDArray[np.uint8], marks: Costs) -> None:
    """Add one scan to the evidence, and mark and clear by it; a cell in which one ray ended was not passed."""
    rows, columns = swept.shape
    for i in range(rows):
        for j in range(columns):
            if swept[i, j] == ENDED:
                evidence[i, j] = min(evidence[i, j] + HIT, MOST)
                if evidence[i, j] >= MARKED:
                    marks[i, j] = LETHAL
            elif swept[i, j] == PASSED and evidence[i, j] > 0:
                evidence[i, j] -= PASS
                if evidence[i, j] == 0:
                    marks[i, j] = FREE
