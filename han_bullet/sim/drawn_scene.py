"""The things that a picture shows, as meshes in the world."""

from __future__ import annotations

import functools
from collections.abc import Collection, Sequence

import pybullet

from han_bullet.sim.avatar import Avatar
from han_bullet.sim.gait import BodyPose
from han_bullet.sim.jointed_body import JointedBody
from han_bullet.sim.mesh import Mesh, painted
from han_bullet.sim.robot_model import RobotModel
from han_bullet.sim.room import load_furniture, texture_path
from han_bullet.sim.room_surfaces import (
    SCREEN_DARK,
    SCREEN_LIT,
    SCREEN_TEXTURE,
    Material,
    device_boxes,
    furniture_boxes,
    plain_furniture,
    room_surfaces,
    screen,
)
from han_bullet.sim.scene_state import DevicesOn, RobotPosture
from han_bullet.sim.surfaces import Surface
from han_bullet.world_schema import World

Meshes = Sequence[Mesh]


class DrawnScene:
    """The building, the people and the robot; a PyBullet client that is never stepped poses what has joints."""

    def __init__(self, world: World) -> None:
        """Load everything.

        Raises:
            BadInputError: A texture, a URDF file or a mesh is missing, or of a kind that cannot be drawn.
        """
        self._world = world
        self._client: int = pybullet.connect(pybullet.DIRECT)
        try:
            self._room, self._fleeting = self._load_room()
            self._screens = self._load_screens()
            self._people = [self._load_person(person.build, person.outfit) for person in world.people]
            self._robot = RobotModel(self._client, world.robot.urdf, world.robot.start_pose_in_world, fixed=True)
            self._robot_body = JointedBody(self._client, self._robot.body)
            # Cameras take the same moment one after the other.
            self._posed_people = functools.lru_cache(maxsize=1)(self._pose_people)
            self._posed_robot = functools.lru_cache(maxsize=1)(self._pose_robot)
        except BaseException:
            self.close()
            raise

    def room(self, devices_on: DevicesOn, taken_away: Collection[str] = ()) -> Meshes:
        """Return the building, with the devices in a state and without the furniture that is taken away."""
        fleeting = [mesh for name, meshes in self._fleeting.items() if name not in taken_away for mesh in meshes]
        return [*self._room, *fleeting, *(self._screens[device, on] for device, on in devices_on)]

    def people(self, body_poses: tuple[BodyPose, ...]) -> tuple[Meshes, ...]:
        """Return the body of each person in a pose, in the order of the world."""
        return self._posed_people(body_poses)

    def robot(self, posture: RobotPosture) -> Meshes:
        """Return the body of the robot in a posture."""
        return self._posed_robot(posture)

    def close(self) -> None:
        """Close the client; nothing can be drawn after that."""
        pybullet.disconnect(physicsClientId=self._client)

    def _pose_people(self, body_poses: tuple[BodyPose, ...]) -> tuple[Meshes, ...]:
        for (avatar, _), body_pose in zip(self._people, body_poses, strict=True):
            avatar.place(body_pose)
        return tuple(body.meshes_in_world() for _, body in self._people)

    def _pose_robot(self, posture: RobotPosture) -> Meshes:
        self._robot.place(posture)
        return self._robot_body.meshes_in_world()

    def _load_room(self) -> tuple[list[Mesh], dict[str, Meshes]]:
        """Return what stays, and by name the furniture that does not."""
        stays = [_painted(*pair) for pair in room_surfaces(self._world).items()]
        fleeting: dict[str, Meshes] = {}
        for box, piece in zip(furniture_boxes(self._world), self._world.furniture, strict=True):
            meshes: Meshes = ()
            if piece.urdf is not None:
                meshes = JointedBody(self._client, load_furniture(self._client, piece.urdf, box)).meshes_in_world()
            elif piece.until is not None:
                meshes = [_painted(*plain_furniture(box, piece))]
            if piece.until is not None:
                fleeting[piece.name] = meshes
            else:
                stays.extend(meshes)
        return stays, fleeting

    def _load_screens(self) -> dict[tuple[str, bool], Mesh]:
        """Return the screens of the devices, off and on."""
        texture = texture_path(SCREEN_TEXTURE)
        return {
            (tv.name, on): painted(screen(tv, box), texture, SCREEN_LIT if on else SCREEN_DARK)
            for tv, box in zip(self._world.devices, device_boxes(self._world), strict=True)
            for on in (False, True)
        }

    def _load_person(self, build: str, outfit: int) -> tuple[Avatar, JointedBody]:
        avatar = Avatar(self._client, build, outfit)
        return avatar, JointedBody(self._client, avatar.body)


def _painted(material: Material, surface: Surface) -> Mesh:
    return painted(surface, None if material.texture is None else texture_path(material.texture), material.colour)
