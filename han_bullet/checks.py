"""Checks of a world that need its map, made before the first step, and of its expectations, made after the last.

Schema checks live in world_schema.py. Here: nobody stands in a wall, the goal can be reached; then, which metrics of a
run ended outside the range that the world asks for. And what an order asks for, before it is taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from han_bullet.costmap.grid import INSCRIBED
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array
from han_bullet.messages import HandOver, Task
from han_bullet.metrics import Metric, Metrics, Value, written
from han_bullet.metrics.tally import PERSON_RADIUS
from han_bullet.planning.astar import AStar
from han_bullet.static_map import static_costmap
from han_bullet.world_schema import Expectation, GoToTask, Sit, Walk, World


def check_world(world: World, source: str) -> None:
    """Check what needs the map.

    Args:
        world: A checked model.
        source: File to name in a message.

    Raises:
        BadInputError: The first fault: file, field, value, what would be right.
    """
    for index, person in enumerate(world.people):
        if isinstance(person.behaviour, Sit):
            continue
        places = [(f"people[{index}].start", person.start[:2])]
        if isinstance(person.behaviour, Walk):
            waypoints = enumerate(person.behaviour.waypoints)
            places += [(f"people[{index}].behaviour.waypoints[{i}]", point) for i, point in waypoints]
        for field, place in places:
            _check_free(world, source, field, np.array(place), PERSON_RADIUS)
        gap = float(np.hypot(*np.subtract(person.start[:2], world.robot.start[:2])))
        if gap < world.robot.radius + PERSON_RADIUS:
            raise BadInputError(
                f"{source}: people[{index}].start: {person.name} stands {gap:.2f} m from the robot's start; at least "
                f"{world.robot.radius + PERSON_RADIUS:.2f} m would be right"
            )
    start, goal = np.array(world.robot.start[:2]), np.array(world.task.place)
    _check_free(world, source, "robot.start", start, world.robot.radius)
    field = "task.pose" if isinstance(world.task, GoToTask) else "task.place"
    _check_free(world, source, field, goal, world.robot.radius if isinstance(world.task, GoToTask) else PERSON_RADIUS)
    check_expectations(world.expectations, Metrics(world).results(), source)
    costmap = static_costmap(world)
    if AStar(weight=world.costmap.astar_weight).search(costmap, start, goal) is None:
        raise BadInputError(
            f"{source}: {field}: no free way for a robot of radius {world.robot.radius} m leads from robot.start "
            f"{start.tolist()} to {goal.tolist()}; open a way or move one of them"
        )


def check_goal(world: World, task: Task) -> None:
    """Check what is asked of a robot on a world's map before it is taken: it knows no more than that.

    Args:
        world: Its known furniture, walls and floor are the map.
        task: A hand-over to a person by id is to them, wherever they are; its place is not looked at.

    Raises:
        BadInputError: The goal, what is wrong with it, what would be right.
    """
    if isinstance(task, HandOver):
        _check_finite("distance", [task.distance])
        if task.distance <= 0.0:
            raise BadInputError(f"goal: distance is {task.distance!r} m; a positive one, such as 0.9, would be right")
        if task.person is None:
            _check_finite("place", task.place_in_world.tolist())
            _check_free(_known(world), "goal", "place", task.place_in_world, PERSON_RADIUS)
        return
    pose, radius = task.pose_in_world, world.robot.radius
    _check_finite("pose", [pose.x, pose.y, pose.yaw])
    _check_free(_known(world), "goal", "pose", pose.position, radius)
    if static_costmap(_known(world)).cost_at(pose.position) >= INSCRIBED:
        raise BadInputError(
            f"goal: pose: {pose.position.tolist()} is too near to a wall, to furniture or to the floor's end for the "
            f"body's radius {radius} m, on a map with cells of {world.costmap.resolution} m; move it away"
        )


def _known(world: World) -> World:
    """Return a world without the furniture that the robot's map does not have."""
    return world.model_copy(update={"furniture": tuple(piece for piece in world.furniture if piece.known)})


def _check_finite(field: str, numbers: Sequence[float]) -> None:
    if not np.isfinite(numbers).all():
        raise BadInputError(f"goal: {field} is {list(numbers)}; finite numbers would be right")


def _check_free(world: World, source: str, field: str, place: Array, radius: float) -> None:
    """Raise where a disc at a place leaves the floor or cuts a wall or a piece of furniture."""
    if not any(area.contains(place) for area in world.floor):
        raise BadInputError(f"{source}: {field}: {place.tolist()} lies on no floor area; move it onto one")
    for box in world.all_boxes():
        if box.contains(place, margin=radius):
            raise BadInputError(
                f"{source}: {field}: {place.tolist()} lies inside {box.kind} {box.name!r} or nearer to it than the "
                f"body's radius {radius} m; move it away"
            )


@dataclass(frozen=True)
class Check:
    """One expectation of a world, held against a run.

    Attributes:
        metric: Name of the metric.
        expected: The range or value, as text.
        value: What the run gave; None where it gave nothing.
        passed: Whether the value lies in the range.
    """

    metric: str
    expected: str
    value: Value
    passed: bool


def check_expectations(
    expectations: Sequence[Expectation], metrics: Sequence[Metric], source: str = "world"
) -> list[Check]:
    """Hold each expectation against the metric that it names, as it is written.

    Raises:
        BadInputError: An expectation names a metric that the run does not have.
    """
    values = {metric.name: written(metric.value) for metric in metrics}
    for index, expectation in enumerate(expectations):
        if expectation.metric not in values:
            raise BadInputError(
                f"{source}: expectations[{index}].metric: {expectation.metric!r} is no metric of this world; there are "
                f"{', '.join(sorted(values))}"
            )
    return [_check(expectation, values[expectation.metric]) for expectation in expectations]


def _check(expectation: Expectation, value: Value) -> Check:
    bounds = {">=": expectation.at_least, "<=": expectation.at_most, "==": expectation.equals}
    expected = " and ".join(f"{sign} {_plain(bound)}" for sign, bound in bounds.items() if bound is not None)
    passed = value is not None
    if expectation.equals is not None:
        passed = passed and value == expectation.equals
    if expectation.at_least is not None:
        passed = passed and isinstance(value, int | float) and value >= expectation.at_least
    if expectation.at_most is not None:
        passed = passed and isinstance(value, int | float) and value <= expectation.at_most
    return Check(expectation.metric, expected, value, passed)


def _plain(bound: Value) -> str:
    """Return a bound as people write it, 0 rather than 0.0."""
    return f"{bound:g}" if isinstance(bound, float) else str(bound)
