"""The way that walkers have before them when the robot gets there."""

from __future__ import annotations

import math

import numba
import numpy as np

from han_bullet.costmap.grid import SOCIAL_MAX, Costmap, Costs
from han_bullet.costmap.layer import Layer, check_amplitude, walking_direction
from han_bullet.costmap.shapes import ENOUGH, REACH
from han_bullet.errors import check_positive
from han_bullet.geometry import Array, wrap_angle
from han_bullet.messages import Posture, Scene, TrackedPerson

OWN_WAY = 0.25 * math.pi  # [rad] to either side of the direction to the goal
AT_GOAL = 0.15  # [m]: nearer, the direction trembles as the robot's place does


class OncomingLayer(Layer):
    """A Gaussian about the way that a walker has before them when the robot could be there; not in the paper.

    Somebody who walks is not met where they are. With their personal space of this moment alone, the robot turns aside
    for who comes towards it when they are two steps away, and drives along before who crosses its way.

    A place that the robot reaches after t, straight on and at full speed, costs if it is on the walker's way from
    p + v t on, as far as they get in `horizon`. What lies behind is free: there the robot cannot come before they have
    passed, and if it comes later they are farther on. So it keeps out of their way or passes behind them.

    Who goes the robot's own way, within 45 degrees of the direction to its goal, is not met but followed or overtaken:
    that is the matter of the paper's layers, which say on which side.
    """

    name = "oncoming"

    def __init__(self, *, robot_speed: float, horizon: float = 4.0, side: float = 0.8, amplitude: float = 1.0) -> None:
        """Configure the shape.

        Args:
            robot_speed: The highest [m/s].
            horizon: How much of the way before them is theirs [s].
            side: Standard deviation across their way and at its ends [m]. With 0.53, that of their personal space, the
                robot more often began to pass before who crosses, and turned back.
            amplitude: What the Gaussian is multiplied with, in [0, 1].
        """
        check_positive(f"layer {self.name}", robot_speed=robot_speed, horizon=horizon, side=side)
        check_amplitude(self.name, amplitude)
        self.robot_speed = robot_speed
        self.horizon = horizon
        self.side = side
        self.amplitude = amplitude

    def apply(self, costmap: Costmap, scene: Scene) -> None:
        """Raise the ways of walkers; without a robot nobody is met."""
        if scene.pose_robot_in_world is None or self.amplitude == 0.0:
            return
        for person in scene.people:
            if person.posture is Posture.WALKING and not _goes_along(person, scene):
                self._raise_way(costmap, person, scene.pose_robot_in_world.position)

    def _raise_way(self, costmap: Costmap, person: TrackedPerson, position_robot_in_world: Array) -> None:
        walker = person.position_in_world
        direction = walking_direction(person)
        _raise_way(
            costmap.cost,
            tuple((costmap.origin_in_world - walker).tolist()),
            costmap.resolution,
            tuple((position_robot_in_world - walker).tolist()),
            (math.cos(direction), math.sin(direction)),
            person.speed / self.robot_speed,
            person.speed * self.horizon,
            self.side,
            self.amplitude,
        )


def _goes_along(person: TrackedPerson, scene: Scene) -> bool:
    """Tell whether a walker goes where the robot's task leads it; at its goal it meets nobody any more."""
    if scene.task is None or scene.pose_robot_in_world is None:
        return False
    x, y = scene.task.goal_in_world - scene.pose_robot_in_world.position
    if math.hypot(x, y) < AT_GOAL:
        return True
    turned = wrap_angle(walking_direction(person) - math.atan2(y, x))
    return abs(turned) < OWN_WAY


@numba.njit(cache=True)
def _raise_way(
    cost: Costs,
    origin: tuple[float, float],
    resolution: float,
    robot: tuple[float, float],
    direction: tuple[float, float],
    pace: float,
    length: float,
    side: float,
    amplitude: float,
) -> None:
    """Raise a map about one walker's way; blocked cells stay. Places are seen from the walker, in the world's axes [m].

    Args:
        cost: The map.
        origin: Its lower left corner.
        resolution: [m].
        robot: Where it is.
        direction: In which the walker walks, a unit vector.
        pace: The walker's speed as a part of the robot's.
        length: Of the way before them [m].
        side: Standard deviation [m].
        amplitude: The peak, in (0, 1].
    """
    c, s = direction
    reach = REACH * side
    nearer = 2.0 * math.log(amplitude)  # by so much less a lower peak reaches
    for i in range(cost.shape[0]):
        y = origin[1] + (i + 0.5) * resolution
        first, last = _strip(cost.shape[1], origin[0], resolution, c * y, s, reach)
        for j in range(first, last):
            x = origin[0] + (j + 0.5) * resolution
            ahead, across = c * x + s * y, c * y - s * x
            if ahead < -reach:
                continue
            ahead -= pace * math.hypot(x - robot[0], y - robot[1])  # of where they are when the robot could be here
            beyond = ahead - min(max(ahead, 0.0), length)
            distance = (across**2 + beyond**2) / side**2
            if distance < ENOUGH[cost[i, j]] + nearer:
                cost[i, j] = max(cost[i, j], np.uint8(SOCIAL_MAX * amplitude * math.exp(-0.5 * distance) + 0.5))


@numba.njit(cache=True)
def _strip(columns: int, left: float, resolution: float, middle: float, s: float, reach: float) -> tuple[int, int]:
    """Return the columns, first and beyond the last, of a row in which |middle - s x| <= reach for some of a cell."""
    if abs(s) < 1e-9:
        return (0, columns) if abs(middle) <= reach else (0, 0)
    ends = (middle - reach) / s, (middle + reach) / s
    first, last = math.floor((min(ends) - left) / resolution), math.floor((max(ends) - left) / resolution) + 1
    return max(first, 0), min(last, columns)
