"""The robot's URDF as ROS wants it: its root is base_link, its meshes are found from anywhere; and its joints."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from xml.etree import ElementTree

import numpy as np

from han_bullet import assets
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, rotation
from han_bullet.mecanum import WHEELS, MecanumWheels
from han_bullet.ros.frames import BASE


@dataclass(frozen=True, eq=False)
class Joint:
    """How a link hangs on another.

    Attributes:
        name: Of the joint.
        parent: Frame of the link on which it hangs.
        child: Frame of the link that hangs.
        child_in_parent: Where, the joint being at 0, shape (4, 4).
        axis: About which it turns, in the child's frame, shape (3,); None: it is fixed.
    """

    name: str
    parent: str
    child: str
    child_in_parent: Array
    axis: Array | None


class RobotDescription:
    """A robot's URDF.

    Args:
        urdf: File in urdf/, such as "mbot.urdf"; its root is on the floor, in the middle of the base.

    Raises:
        BadInputError: There is no such file, it is no URDF, or it lacks a wheel that turns on its root.
    """

    def __init__(self, urdf: str) -> None:
        folder = assets.urdf_folder().resolve()
        try:
            self._robot = ElementTree.parse(folder / urdf).getroot()
        except (OSError, ElementTree.ParseError) as error:
            raise BadInputError(f"robot {urdf!r} cannot be read as a URDF of {str(folder)!r}: {error}") from error
        for mesh in self._robot.iter("mesh"):
            mesh.set("filename", (folder / mesh.attrib["filename"]).as_uri())
        self._rename_root()
        missing = sorted({*WHEELS} - {joint.name for joint in self.joints})
        if missing:
            raise BadInputError(f"URDF {urdf!r} lacks the joint {missing[0]!r}; it needs {', '.join(WHEELS)}")
        for wheel in self.wheels:
            if wheel.parent != BASE or wheel.axis is None:
                raise BadInputError(f"URDF {urdf!r}: {wheel.name} does not turn on the root link; that would be right")

    @property
    def text(self) -> str:
        """Return the URDF for the parameter robot_description, with file:// addresses of the meshes."""
        return ElementTree.tostring(self._robot, encoding="unicode")

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """Return all joints."""
        return tuple(map(_joint, self._robot.iter("joint")))

    @property
    def wheels(self) -> tuple[Joint, ...]:
        """Return the joints of the wheels, in the order of WHEELS."""
        named = {joint.name: joint for joint in self.joints}
        return tuple(named[name] for name in WHEELS)

    @property
    def wheel_geometry(self) -> MecanumWheels:
        """Return the wheels' geometry: they stand on the floor, so an axle is as high as its wheel's radius."""
        half_length, half_width, radius = self.wheels[0].child_in_parent[:3, 3].tolist()
        return MecanumWheels(radius, half_length, half_width)

    def _rename_root(self) -> None:
        children = {child.attrib["link"] for child in self._robot.iter("child")}
        root = next(link for link in self._robot.iter("link") if link.attrib["name"] not in children)
        for parent in self._robot.iter("parent"):
            if parent.attrib["link"] == root.attrib["name"]:
                parent.set("link", BASE)
        root.set("name", BASE)


def _joint(element: ElementTree.Element) -> Joint:
    parent, child, axis = element.find("parent"), element.find("child"), element.find("axis")
    assert parent is not None and child is not None
    turns = element.attrib["type"] != "fixed"
    direction = np.array([1.0, 0.0, 0.0]) if axis is None else _numbers(axis.attrib["xyz"])
    placed = _placed(element.find("origin"))
    return Joint(
        element.attrib["name"], parent.attrib["link"], child.attrib["link"], placed, direction if turns else None
    )


def _placed(origin: ElementTree.Element | None) -> Array:
    """Return the rigid transform, shape (4, 4), of an origin: turned by roll, pitch and yaw about the fixed axes."""
    pose = np.eye(4)
    if origin is not None:
        roll, pitch, yaw = _numbers(origin.get("rpy", "0 0 0"))
        pose[:3, :3] = _turn(yaw, 0, 1) @ _turn(pitch, 2, 0) @ _turn(roll, 1, 2)
        pose[:3, 3] = _numbers(origin.get("xyz", "0 0 0"))
    return pose


def _turn(angle: float, first: int, second: int) -> Array:
    """Return the turn, shape (3, 3), that takes one axis towards another [rad]."""
    turn = np.eye(3)
    turn[np.ix_((first, second), (first, second))] = rotation(angle)
    return turn


def _numbers(text: str) -> Array:
    return np.array([float(number) for number in text.split()])
