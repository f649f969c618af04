"""The video of a run: the map above, the camera images with their detections below; one picture per camera period."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from han_bullet.episode import Hook, Tick
from han_bullet.film import Film
from han_bullet.geometry import Array
from han_bullet.lettering import Lettering, Picture
from han_bullet.panels import CameraStrip, TitleBar, draw_legend
from han_bullet.topdown import TopDownView
from han_bullet.world_schema import CONTROL_PERIOD, World

WIDTH = 1920  # [px]; five 4:3 images of 384 px, or 81 px per metre of a 23 m corridor
TITLE_HEIGHT, MAP_HEIGHT, LEGEND_HEIGHT, CAMERA_HEIGHT = 52, 592, 28, 288  # [px]; 960 in all, 672 without cameras
TICKS_WITHOUT_CAMERAS = 2  # 10 pictures per second


class VideoRecorder(Hook):
    """Write an H.264 video that plays in real time.

    Args:
        path: The file, ending in .mp4; an older one is replaced.
        world: Building, cameras and task.
        show_cameras: Whether camera images will come; without them the video is the map alone.
    """

    def __init__(self, path: Path, world: World, *, show_cameras: bool = True) -> None:
        cameras = world.cameras if show_cameras else ()
        self._ticks_per_picture = min((c.ticks_per_frame for c in cameras), default=TICKS_WITHOUT_CAMERAS)
        heights = (TITLE_HEIGHT, MAP_HEIGHT, LEGEND_HEIGHT, CAMERA_HEIGHT if cameras else 0)
        self._picture = np.zeros((sum(heights), WIDTH, 3), np.uint8)
        self._title_rows, self._map_rows, legend_rows, strip_rows = np.split(self._picture, np.cumsum(heights)[:-1])
        lettering = Lettering()
        self._title = TitleBar(world, (WIDTH, TITLE_HEIGHT), lettering)
        self._map = TopDownView(world, (WIDTH, MAP_HEIGHT), lettering)
        legend_rows[:] = draw_legend((WIDTH, LEGEND_HEIGHT), lettering, self._map.scale)
        names = [camera.name for camera in cameras]
        self._strip = CameraStrip(names, strip_rows, lettering) if names else None
        self._measurements: list[Array] = []
        self._ticks = 0
        self._film = Film(path, rate=1.0 / (self._ticks_per_picture * CONTROL_PERIOD))

    def record(self, tick: Tick) -> None:
        """Take in a tick, and draw it where a picture is due.

        Raises:
            HanError: The encoder has died.
        """
        self._title.record(tick)
        if self._strip is not None:
            self._strip.record(tick)
        self._measurements += [scan.positions for scan in tick.decision.scans]
        if self._ticks % self._ticks_per_picture == 0:
            self._film.write(self.draw(tick))
            self._measurements.clear()
        self._ticks += 1

    def draw(self, tick: Tick) -> Picture:
        """Return the picture of a tick, RGB, shape (height, width, 3); it changes with the next tick."""
        self._title.draw(self._title_rows, tick)
        self._map.draw(self._map_rows, tick, self._measurements)
        return self._picture

    def close(self) -> None:
        """Let the encoder finish the file."""
        self._film.close()
