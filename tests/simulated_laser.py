"""What a laser scanner and the wheels of a robot on a recorded way would have measured, among people's legs."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from han_bullet.geometry import Array, Pose2D, SolidBox, Twist2D, rotation
from han_bullet.messages import LaserScan, Odometry

FIELD_OF_VIEW, INCREMENT = math.radians(270.0), math.radians(0.5)
RANGE_MIN, RANGE_MAX = 0.05, 8.0  # [m]
RANGE_DEVIATION = 0.01  # [m]
SCANNER_IN_BODY = Pose2D(0.2, 0.0, 0.0)
SLIP, TURN_SLIP = 0.02, math.radians(1.0)  # [m / m] and [rad / sqrt(m)]
LEG_RADIUS, LEGS_APART = 0.06, 0.2  # [m]


@dataclass(frozen=True)
class Laser:
    """A scanner in a building.

    Attributes:
        boxes: What it sees of the building.
        range_max: [m].
    """

    boxes: Sequence[SolidBox]
    range_max: float = RANGE_MAX

    def scan(self, time: float, robot_in_world: Pose2D, discs: Array, generator: np.random.Generator) -> LaserScan:
        """Measure boxes and upright cylinders, shape (n, 3): x, y, radius [m]."""
        count = round(FIELD_OF_VIEW / INCREMENT) + 1
        scanner = robot_in_world.compose(SCANNER_IN_BODY)
        angles = -0.5 * FIELD_OF_VIEW + INCREMENT * np.arange(count)
        directions = np.column_stack([np.cos(scanner.yaw + angles), np.sin(scanner.yaw + angles)])
        ranges = np.minimum(
            _to_boxes(scanner.position, directions, self.boxes), _to_discs(scanner.position, directions, discs)
        )
        ranges = ranges + generator.normal(0.0, RANGE_DEVIATION, count)
        ranges = np.where((ranges >= RANGE_MIN) & (ranges <= self.range_max), ranges, math.inf)
        return LaserScan(time, ranges, -0.5 * FIELD_OF_VIEW, INCREMENT, RANGE_MIN, self.range_max, SCANNER_IN_BODY)


def legs(people: Sequence[Pose2D]) -> Array:
    """Return two discs per person."""
    feet = [person.to_world(np.array([[0.0, side * 0.5 * LEGS_APART] for side in (-1, 1)])) for person in people]
    places = np.array(feet).reshape(-1, 2)
    return np.column_stack([places, np.full(len(places), LEG_RADIUS)])


def wheels(times: Sequence[float], poses: Sequence[Pose2D], generator: np.random.Generator) -> Iterator[Odometry]:
    """Measure a way: of each step SLIP of its length is lost or gained, and the direction wanders with it."""
    pose = Pose2D(0.0, 0.0, 0.0)
    scale = 1.0 + generator.normal(0.0, SLIP)
    last_time, last = times[0], poses[0]
    for time, true in zip(times, poses, strict=True):
        step = last.relative(true)
        way = math.hypot(step.x, step.y)
        turn = step.yaw + generator.normal(0.0, TURN_SLIP * math.sqrt(way))
        measured = Pose2D(scale * step.x, scale * step.y, turn)
        pose = pose.compose(measured)
        period = max(time - last_time, 1e-9)
        yield Odometry(time, pose, Twist2D(measured.x / period, measured.y / period, measured.yaw / period))
        last_time, last = time, true


def _to_boxes(origin: Array, directions: Array, boxes: Sequence[SolidBox]) -> Array:
    """Return how far each ray gets before it meets a box [m] (slab test)."""
    nearest = np.full(len(directions), math.inf)
    for box in boxes:
        turn = rotation(box.yaw)
        start = (origin - box.centre_in_world[:2]) @ turn
        along = directions @ turn
        along = np.where(np.abs(along) < 1e-12, 1e-12, along)
        first, second = (-0.5 * box.size[:2] - start) / along, (0.5 * box.size[:2] - start) / along
        enter, leave = np.minimum(first, second).max(axis=1), np.maximum(first, second).min(axis=1)
        met = (enter < leave) & (leave > 0.0)
        nearest = np.where(met, np.minimum(nearest, np.maximum(enter, 0.0)), nearest)
    return nearest


def _to_discs(origin: Array, directions: Array, discs: Array) -> Array:
    """Return how far each ray gets before it meets a disc [m]."""
    nearest = np.full(len(directions), math.inf)
    for x, y, radius in discs:
        to_centre = np.array([x, y]) - origin
        along = directions @ to_centre
        inside = radius**2 - (to_centre @ to_centre - along**2)
        met = (inside > 0.0) & (along > 0.0)
        nearest = np.where(met, np.minimum(nearest, along - np.sqrt(np.maximum(inside, 0.0))), nearest)
    return nearest


def walled(x: tuple[float, float], y: tuple[float, float]) -> list[SolidBox]:
    """Return walls, 0.1 m thick, around a rectangle of floor [m]."""
    (x_from, x_to), (y_from, y_to) = x, y
    middle_x, middle_y = 0.5 * (x_from + x_to), 0.5 * (y_from + y_to)
    long, wide = x_to - x_from + 0.2, y_to - y_from + 0.2
    return [
        block(middle_x, y_from - 0.05, long, 0.1),
        block(middle_x, y_to + 0.05, long, 0.1),
        block(x_from - 0.05, middle_y, 0.1, wide),
        block(x_to + 0.05, middle_y, 0.1, wide),
    ]


def block(x: float, y: float, length: float, width: float, yaw: float = 0.0) -> SolidBox:
    """Return a box that stands on the floor [m]."""
    return SolidBox("block", "object", np.array([x, y, 0.5]), np.array([length, width, 1.0]), yaw)


# A furnished room that has no symmetry, and a corridor from whose middle no end is in sight.
FLOOR = ((0.0, 8.0), (0.0, 6.0))
ROOM = [*walled(*FLOOR), block(6.0, 1.0, 1.9, 0.8), block(1.5, 5.0, 0.6, 1.2, 0.5)]
CORRIDOR_FLOOR = ((0.0, 40.0), (-1.5, 1.5))
CORRIDOR = walled(*CORRIDOR_FLOOR)
NOBODY = np.zeros((0, 3))


def standing(time: float) -> Odometry:
    """Return the odometry of a robot that does not move."""
    return Odometry(time, Pose2D(0.0, 0.0, 0.0), Twist2D())
