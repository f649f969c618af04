"""The way of people who come towards the robot."""

from __future__ import annotations

import math

import numpy as np

from han_bullet.costmap.grid import Costmap
from han_bullet.costmap.layer import Layer, check_amplitude, check_positive, walking_direction
from han_bullet.costmap.shapes import raise_asym_gauss
from han_bullet.geometry import Array
from han_bullet.messages import GoTo, Posture, Scene, Task, TrackedPerson

STRIDE = 0.5  # part of the deviation between two samples of a way: the ridge of their Gaussians is level to 1 %


class OncomingLayer(Layer):
    """A Gaussian swept along the way that an oncoming walker has before them; not in the paper.

    Somebody who comes towards the robot is not met where they are but half-way. With their personal space of this
    moment alone, the robot turns aside when they are two steps away, has no room left to, and stops in their way.

    Oncoming is who has the robot before them and its goal behind them.
    """

    name = "oncoming"

    def __init__(self, *, horizon: float = 4.0, side: float = 0.53, amplitude: float = 1.0) -> None:
        """Configure the sweep.

        Args:
            horizon: How far ahead people are taken to walk straight on [s].
            side: Standard deviation across their way [m]; that of the least personal space of a walker.
            amplitude: What the Gaussian is multiplied with, in [0, 1].
        """
        check_positive(self.name, horizon=horizon, side=side)
        check_amplitude(self.name, amplitude)
        self.horizon = horizon
        self.side = side
        self.amplitude = amplitude

    def apply(self, costmap: Costmap, scene: Scene) -> None:
        """Raise the ways of walkers who come towards the robot."""
        if scene.pose_robot_in_world is None or scene.task is None:
            return
        goal = _goal(scene.task)
        for person in scene.people:
            if person.posture is Posture.WALKING and _comes(person, scene.pose_robot_in_world.position, goal):
                self._raise_way(costmap, person)

    def _raise_way(self, costmap: Costmap, person: TrackedPerson) -> None:
        length, direction = person.speed * self.horizon, _direction(person)
        for along in np.arange(0.0, length, STRIDE * self.side):
            place = person.position_in_world + along * direction
            raise_asym_gauss(costmap, place, 0.0, self.side, self.side, self.side, self.amplitude)


def _direction(person: TrackedPerson) -> Array:
    """Return the unit vector, (2,), along which a person walks."""
    direction = walking_direction(person)
    return np.array([math.cos(direction), math.sin(direction)])


def _comes(person: TrackedPerson, position_robot_in_world: Array, goal_in_world: Array) -> bool:
    robot, goal = (place - person.position_in_world for place in (position_robot_in_world, goal_in_world))
    direction = _direction(person)
    return bool(direction @ robot > 0.0 > direction @ goal)


def _goal(task: Task) -> Array:
    """Return where the task leads, (2,) [m]."""
    if isinstance(task, GoTo):
        return task.pose_in_world.position
    return task.place_in_world if task.position_in_world is None else task.position_in_world
