"""Pictures of the scene."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, camera_on_robot, rotation
from han_bullet.sim.drawn_scene import DrawnScene, Meshes
from han_bullet.sim.image_noise import ImageNoise
from han_bullet.sim.raster import Image, Raster, View
from han_bullet.sim.rasterizer import draw
from han_bullet.sim.scene_state import DevicesOn, SceneState
from han_bullet.sim.silhouette import Silhouette, silhouette_of
from han_bullet.world_schema import CeilingCamera, Light, World

__all__ = ["FrameSource", "Image", "InProcessRenderer", "Renderer"]

CALIBRATION_FRAME = 2**31  # beyond the frame numbers of any episode


class Renderer:
    """Take pictures of a world; each depends on the scene's state and the seed alone, not on what was taken before.

    The building before a fixed camera is drawn once, and people and robot into a copy of it.
    """

    def __init__(self, world: World, seed: int) -> None:
        """Load all that can be seen.

        Args:
            world: With its light and image noise as they are.
            seed: Of the image noise.

        Raises:
            BadInputError: A texture, a URDF file or a mesh is missing, or of a kind that cannot be drawn.
        """
        self._world = world
        self._scene = DrawnScene(world)
        largest = max((3 * camera.size[0] * camera.size[1] for camera in world.cameras), default=1)
        self._noise = ImageNoise(world.image_noise, seed, largest)
        self._fixed = {c.name: c.camera_in_world for c in world.cameras if isinstance(c, CeilingCamera)}
        self._camera_index = {camera.name: index for index, camera in enumerate(world.cameras)}
        self._backgrounds: dict[tuple[str, float, DevicesOn, tuple[str, ...]], Raster] = {}

    def render(self, camera_name: str, state: SceneState) -> Image:
        """Return the picture of one camera, shape (height, width, 3), RGB.

        Raises:
            BadInputError: No camera has that name.
        """
        exposure = state.exposure_of(camera_name)
        if exposure.black:
            width, height = self._world.camera(camera_name).size
            return self._add_noise(np.zeros((height, width, 3), np.uint8), camera_name, exposure.moment)
        raster = self._draw(camera_name, exposure.moment, exposure.turned)[0]
        return self._add_noise(raster.colour, camera_name, exposure.moment)

    def render_with_people(self, camera_name: str, state: SceneState) -> tuple[Image, tuple[Silhouette | None, ...]]:
        """Return the same picture and what it truly shows of each person, in the order of the world.

        None stands for a person of whom no pixel lies in the picture.

        Raises:
            BadInputError: No camera has that name.
        """
        raster, view, people = self._draw(camera_name, state)
        silhouettes = tuple(silhouette_of(self._add(Raster.blank(view.intrinsics), p, view), raster) for p in people)
        return self._add_noise(raster.colour, camera_name, state), silhouettes

    def calibration_image(self, camera_name: str) -> Image:
        """Return the picture of a fixed camera with neither people nor robot, devices as at the start.

        Raises:
            BadInputError: No fixed camera has that name.
        """
        camera = self._world.camera(camera_name)
        if not isinstance(camera, CeilingCamera):
            raise BadInputError(f"camera {camera_name!r} moves; only a ceiling camera has a calibration image")
        devices = tuple((tv.name, tv.on) for tv in self._world.devices)
        colour = self._background(camera, 0.0, devices).colour
        return self._noise.add(colour, self._camera_index[camera_name], CALIBRATION_FRAME)

    def close(self) -> None:
        """Close the scene; no more pictures can be taken."""
        self._scene.close()

    def _draw(
        self, camera_name: str, state: SceneState, turned: float = 0.0
    ) -> tuple[Raster, View, tuple[Meshes, ...]]:
        """Return the picture without noise, where it was taken from, and the people in it."""
        camera = self._world.camera(camera_name)
        people = self._scene.people(state.people)
        if isinstance(camera, CeilingCamera):
            view = View(camera.intrinsics, _turned_left(self._fixed[camera.name], turned))
            raster = self._background(camera, turned, state.devices_on, state.taken_away).copy()
            self._add(raster, self._scene.robot(state.robot), view)
        else:  # without the robot: its camera looks over the base from inside the head
            mount = (camera.forward, camera.height, camera.pitch_down)
            mounted = camera_on_robot(state.robot.pose_in_world, *mount)
            view = View(camera.intrinsics, _turned_left(mounted, turned))
            raster = self._draw_room(view, state.devices_on, state.taken_away)
        for person in people:
            self._add(raster, person, view)
        return raster, view, people

    def _background(
        self, camera: CeilingCamera, turned: float, devices_on: DevicesOn, taken_away: tuple[str, ...] = ()
    ) -> Raster:
        key = (camera.name, turned, devices_on, taken_away)
        if key not in self._backgrounds:
            view = View(camera.intrinsics, _turned_left(self._fixed[camera.name], turned))
            self._backgrounds[key] = self._draw_room(view, devices_on, taken_away)
        return self._backgrounds[key]

    def _draw_room(self, view: View, devices_on: DevicesOn, taken_away: tuple[str, ...]) -> Raster:
        raster = self._add(Raster.blank(view.intrinsics), self._scene.room(devices_on, taken_away), view)
        raster.fill_empty(_ceiling_colour(self._world.light))
        return raster

    def _add(self, raster: Raster, meshes: Meshes, view: View) -> Raster:
        for mesh in meshes:
            draw(raster, mesh, view, self._world.light)
        return raster

    def _add_noise(self, colour: Image, camera_name: str, state: SceneState) -> Image:
        return self._noise.add(colour, self._camera_index[camera_name], state.frame_number)


def _turned_left(camera_in_world: Array, angle: float) -> Array:
    """Return the pose, shape (4, 4), of a camera turned to the left about the vertical [rad]."""
    if angle == 0.0:
        return camera_in_world
    turned = camera_in_world.copy()
    turned[:2, :3] = rotation(angle) @ camera_in_world[:2, :3]
    return turned


def _ceiling_colour(light: Light) -> tuple[int, int, int]:
    """Return how a plain white ceiling looks.

    It fills just the pixels that walls and floor leave empty, so that no ceiling need be drawn.
    """
    shade = light.ambient + light.diffuse * max(0.0, -light.direction[2] / float(np.linalg.norm(light.direction)))
    red, green, blue = (min(255, round(255 * shade * part)) for part in light.colour)
    return red, green, blue


class FrameSource(ABC):
    """Take pictures with several cameras at once: in this process or in others."""

    @abstractmethod
    def render(self, cameras: Sequence[str], state: SceneState) -> list[Image]:
        """Return one picture per named camera, each of shape (height, width, 3), RGB."""


class InProcessRenderer(FrameSource):
    """Render in this process, one camera after the other."""

    def __init__(self, world: World, seed: int) -> None:
        self.renderer = Renderer(world, seed)

    def render(self, cameras: Sequence[str], state: SceneState) -> list[Image]:
        """Return one picture per named camera; see FrameSource."""
        return [self.renderer.render(camera, state) for camera in cameras]

    def calibration_images(self, cameras: Sequence[str]) -> list[Image]:
        """Return one picture per named fixed camera, with neither people nor robot."""
        return [self.renderer.calibration_image(camera) for camera in cameras]

    def close(self) -> None:
        """Close the renderer's clients."""
        self.renderer.close()
