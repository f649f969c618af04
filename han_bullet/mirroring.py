"""The mirror image of a world at the world's x axis: y -> -y, yaw -> -yaw, left <-> right.

What holds for a world holds for its image as well; where the program does better on one side, it shows here.
"""

from __future__ import annotations

import re
from typing import TypeVar

from han_bullet.world_schema import (
    TV,
    Camera,
    CeilingCamera,
    Expectation,
    FloorArea,
    Furniture,
    GoToTask,
    HandOverTask,
    InjectedFault,
    Knocked,
    Part,
    Person,
    SittingArea,
    Walk,
    Wall,
    World,
)

AnyPart = TypeVar("AnyPart", bound=Part)
OTHER_SIDE = {"left": "right", "right": "left"}
_SIDE = re.compile(r"\b(?:left|right)\b")


def mirrored(world: World) -> World:
    """Return the mirror image of a concrete world; twice gives the world again."""
    return world.model_copy(
        update={
            "description": _SIDE.sub(lambda side: OTHER_SIDE[side[0]], world.description),
            "floor": tuple(map(_floor, world.floor)),
            "walls": tuple(map(_wall, world.walls)),
            "furniture": tuple(map(_furniture, world.furniture)),
            "sitting_areas": tuple(map(_sitting_area, world.sitting_areas)),
            "devices": tuple(map(_device, world.devices)),
            "cameras": tuple(map(_camera, world.cameras)),
            "people": tuple(map(_person, world.people)),
            "robot": _with(world.robot, start=_pose(world.robot.start)),
            "task": _task(world.task),
            "faults": tuple(map(_fault, world.faults)),
            "light": _with(world.light, direction=_point3(world.light.direction)),
            "expectations": tuple(map(_expectation, world.expectations)),
        }
    )


def _opposite(value: float) -> float:
    return 0.0 - value  # never -0.0, which would show in files


def _point(point: tuple[float, float]) -> tuple[float, float]:
    return point[0], _opposite(point[1])


def _point3(point: tuple[float, float, float]) -> tuple[float, float, float]:
    return point[0], _opposite(point[1]), point[2]


def _pose(pose: tuple[float, float, float]) -> tuple[float, float, float]:
    return pose[0], _opposite(pose[1]), _opposite(pose[2])


def _with(part: AnyPart, **changes: object) -> AnyPart:
    return part.model_copy(update=changes)


def _floor(area: FloorArea) -> FloorArea:
    return _with(area, y=(_opposite(area.y[1]), _opposite(area.y[0])))


def _wall(wall: Wall) -> Wall:
    return _with(wall, start=_point(wall.start), end=_point(wall.end))


def _furniture(piece: Furniture) -> Furniture:
    """Mirror place and yaw; the piece itself is taken to be symmetric about its own x axis."""
    return _with(piece, position=_point(piece.position), yaw=_opposite(piece.yaw))


def _sitting_area(area: SittingArea) -> SittingArea:
    return _with(area, seat=_point(area.seat), facing=_opposite(area.facing))


def _device(device: TV) -> TV:
    return _with(device, position=_point(device.position), facing=_opposite(device.facing))


def _camera(camera: Camera) -> Camera:
    if not isinstance(camera, CeilingCamera):
        return camera  # it sits on the robot's middle line
    return _with(camera, position=_point3(camera.position), look_at=_point3(camera.look_at))


def _person(person: Person) -> Person:
    behaviour = person.behaviour
    if isinstance(behaviour, Walk):
        behaviour = _with(behaviour, waypoints=tuple(map(_point, behaviour.waypoints)))
    return _with(person, start=_pose(person.start), behaviour=behaviour)


def _fault(fault: InjectedFault) -> InjectedFault:
    return _with(fault, degrees=_opposite(fault.degrees)) if isinstance(fault, Knocked) else fault


def _task(task: GoToTask | HandOverTask) -> GoToTask | HandOverTask:
    if isinstance(task, GoToTask):
        return _with(task, pose=_pose(task.pose))
    return _with(task, place=_point(task.place))


def _expectation(expectation: Expectation) -> Expectation:
    equals = expectation.equals
    return _with(expectation, equals=OTHER_SIDE.get(equals, equals)) if isinstance(equals, str) else expectation
