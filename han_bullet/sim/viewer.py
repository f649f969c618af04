"""A window on the scene: everything drawn in one client that is shown and never stepped."""

from __future__ import annotations

import math
import os
import sys

import numpy as np
import pybullet

from han_bullet.errors import BadInputError, HanError
from han_bullet.sim.avatar import Avatar
from han_bullet.sim.robot_model import RobotModel
from han_bullet.sim.room import VisualRoom
from han_bullet.sim.scene_state import SceneState
from han_bullet.world_schema import World


class Viewer:
    """Show a world in PyBullet's own window."""

    def __init__(self, world: World) -> None:
        """Open the window.

        Raises:
            BadInputError: There is no display.
            HanError: A window is open already.
        """
        if sys.platform == "linux" and not os.environ.get("DISPLAY"):  # PyBullet would end the process
            raise BadInputError("a window needs a display, and DISPLAY names none; set it or leave out --gui")
        self._client: int = pybullet.connect(pybullet.GUI)
        if self._client < 0:
            raise HanError("PyBullet's window did not open; it needs a display, and there can be one per process")
        try:
            self._load(world)
        except BaseException:
            self.close()
            raise

    def _load(self, world: World) -> None:
        pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_GUI, 0, physicsClientId=self._client)
        self._room = VisualRoom(self._client, world)
        settings = world.robot
        self._robot = RobotModel(self._client, settings.urdf, settings.start_pose_in_world, fixed=True)
        self._people = [Avatar(self._client, person.build, person.outfit) for person in world.people]
        self._look_down_on(world)

    def show(self, state: SceneState) -> None:
        """Show a moment."""
        self._room.show_devices(state.devices_on)
        self._room.take_away(state.taken_away)
        self._robot.place(state.robot)
        for avatar, body_pose in zip(self._people, state.people, strict=True):
            avatar.place(body_pose)

    def close(self) -> None:
        """Close the window."""
        if pybullet.isConnected(physicsClientId=self._client):
            pybullet.disconnect(physicsClientId=self._client)

    def _look_down_on(self, world: World) -> None:
        """Place the camera above the middle of the floor, far enough to see all of it, tilted 60 degrees down."""
        corners = np.array([(x, y) for area in world.floor for x in area.x for y in area.y])
        low, high = corners.min(axis=0), corners.max(axis=0)
        middle = [*(0.5 * (low + high)), 0.0]
        distance = 0.7 * math.hypot(*(high - low))
        pybullet.resetDebugVisualizerCamera(distance, 0.0, -60.0, middle, physicsClientId=self._client)
