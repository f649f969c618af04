"""The things that a picture shows, each in a PyBullet client of its own; none of these clients is ever stepped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import pybullet

from han_bullet.geometry import Array, Pose2D
from han_bullet.sim.avatar import Avatar
from han_bullet.sim.gait import BodyPose
from han_bullet.sim.outline import BodyOutline
from han_bullet.sim.robot_model import RobotModel
from han_bullet.sim.room import VisualRoom
from han_bullet.sim.scene_state import DevicesOn, RobotPosture
from han_bullet.world_schema import World


@dataclass(frozen=True)
class DrawnBody:
    """A person or the robot, posed.

    Attributes:
        client: Holds nothing else.
        pose_in_world: Where the body stands.
        corners_in_world: Points whose hull holds it, shape (n, 3) [m].
    """

    client: int
    pose_in_world: Pose2D
    corners_in_world: Array


class DrawnScene:
    """Open clients as they are needed: about 30 MB and 20 ms each."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._clients: list[int] = []
        self._room: tuple[int, VisualRoom] | None = None
        self._robot: tuple[int, RobotModel, BodyOutline] | None = None
        self._people: list[tuple[int, Avatar, BodyOutline]] = []

    def room(self, devices_on: DevicesOn) -> int:
        """Return the client that holds the building, with the devices in a state."""
        if self._room is None:
            client = self._open_client()
            self._room = client, VisualRoom(client, self._world)
        client, room = self._room
        room.show_devices(devices_on)
        return client

    def people(self, body_poses: Sequence[BodyPose]) -> list[DrawnBody]:
        """Pose the people, in the order of the world."""
        if not self._people:
            for person in self._world.people:
                client = self._open_client()
                avatar = Avatar(client, person.build, person.outfit)
                self._people.append((client, avatar, BodyOutline(client, avatar.body)))
        bodies = []
        for (client, avatar, outline), body_pose in zip(self._people, body_poses, strict=True):
            avatar.place(body_pose)
            bodies.append(DrawnBody(client, body_pose.pose_in_world, outline.corners_in_world()))
        return bodies

    def robot(self, posture: RobotPosture) -> DrawnBody:
        """Pose the robot."""
        if self._robot is None:
            client = self._open_client()
            model = RobotModel(client, self._world.robot.urdf, posture.pose_in_world, fixed=True)
            self._robot = client, model, BodyOutline(client, model.body)
        client, model, outline = self._robot
        model.place(posture)
        return DrawnBody(client, posture.pose_in_world, outline.corners_in_world())

    def close(self) -> None:
        """Close all clients; the next use opens them again."""
        for client in self._clients:
            pybullet.disconnect(physicsClientId=client)
        self._clients.clear()
        self._people.clear()
        self._room, self._robot = None, None

    def _open_client(self) -> int:
        client: int = pybullet.connect(pybullet.DIRECT)
        self._clients.append(client)
        return client
