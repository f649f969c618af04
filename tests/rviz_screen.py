"""A screen that nobody sees, with rviz on it: clicked and looked at by the tests."""

from __future__ import annotations

import contextlib
import os
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import yaml
from mosquitto import until
from PIL import Image
from ros_master import DIES_WITH_US, PATIENCE, Master

CONFIG = Path(__file__).parent.parent / "ros1_bridge/rviz/han_bullet.rviz"
SIZE = "1300x900x24"
LEAST = 300  # [px]: narrower ones show images
DRAG = 60  # [px]: along it the goal looks
RADIUS = 0.3  # [m] of the robot
DARK = 150  # in all channels: the robot is, the map and all that lies on it are not


class Rviz:
    """rviz with the shipped configuration.

    Args:
        display: Of the screen, such as ":7".
    """

    def __init__(self, display: str, environment: dict[str, str]) -> None:
        self._environment = {**environment, "DISPLAY": display}
        view = yaml.safe_load(CONFIG.read_text())["Visualization Manager"]["Views"]["Current"]
        self._scale, self._centre = view["Scale"], (view["X"], view["Y"])

    @property
    def view(self) -> tuple[int, int, int, int] | None:
        """Left, top, width and height of the picture of the floor [px]; None as long as there is none."""
        tree = self._run("xwininfo", "-root", "-tree")  # what OpenGL draws into has no name; the floor's is the largest
        found = re.findall(r"\(has no name\): \(\) +(\d+)x(\d+)\+-?\d+\+-?\d+ +\+(\d+)\+(\d+)", tree)
        views = [(int(left), int(top), int(width), int(height)) for width, height, left, top in found]
        return max((view for view in views if view[2] > LEAST), key=lambda view: view[2], default=None)

    def click_goal(self, x: float, y: float) -> None:
        """Press "2D Nav Goal" and draw an arrow from a place on the map [m] along its x axis."""
        assert self.view is not None
        left, top, _, _ = self.view
        column, row = self._pixel(x, y)
        column, row = left + column, top + row
        self._run("xdotool", "mousemove", str(column), str(row), "key", "g", "sleep", "0.3")
        along = ["mousemove", str(column + DRAG), str(row)]
        self._run("xdotool", "mousedown", "1", "sleep", "0.2", *along, "sleep", "0.2", "mouseup", "1")

    def floor(self, path: Path) -> Image.Image:
        """The picture of the floor; the whole screen goes to a file, for whoever looks why a test fails."""
        self._run("import", "-window", "root", str(path))
        left, top, width, height = self.view or (0, 0, 0, 0)
        return Image.open(path).convert("RGB").crop((left, top, left + width, top + height))

    def has_robot_at(self, x: float, y: float, floor: Image.Image) -> bool:
        """Whether a place on the map [m] is dark as the robot is, in a good part of its size."""
        column, row = self._pixel(x, y)
        half = round(RADIUS * self._scale)
        place = floor.crop((column - half, row - half, column + half, row + half))
        dark = sum(count for count, colour in place.getcolors(place.width * place.height) if max(colour) < DARK)
        return dark > half**2

    def _pixel(self, x: float, y: float) -> tuple[int, int]:
        """Column and row in the picture of the floor that show a place on the map [m]."""
        _, _, width, height = self.view or (0, 0, 0, 0)
        column = round(width / 2 + (x - self._centre[0]) * self._scale)
        return column, round(height / 2 - (y - self._centre[1]) * self._scale)

    def _run(self, *command: str) -> str:
        done = subprocess.run(command, env=self._environment, check=True, capture_output=True, text=True)
        return done.stdout


@contextlib.contextmanager
def rviz(master: Master, folder: Path) -> Iterator[Rviz]:
    """rviz on a screen of its own, once it shows the floor."""
    reading, writing = os.pipe()
    with (folder / "rviz.log").open("wb") as log, contextlib.ExitStack() as closing:
        screen = subprocess.Popen(
            [*DIES_WITH_US, "Xvfb", "-displayfd", str(writing), "-screen", "0", SIZE, "-nolisten", "tcp"],
            pass_fds=[writing],
            stdout=log,
            stderr=log,
        )
        closing.callback(_end, screen)
        os.close(writing)
        with os.fdopen(reading) as number:
            display = f":{number.readline().strip()}"
        (folder / "run").mkdir(mode=0o700)
        settings = {"LIBGL_ALWAYS_SOFTWARE": "1", "QT_X11_NO_MITSHM": "1", "XDG_RUNTIME_DIR": str(folder / "run")}
        environment = {**master.environment(), **settings, "HOME": str(folder)}
        command = [*DIES_WITH_US, "rviz", "-d", str(CONFIG), "-s", ""]
        process = subprocess.Popen(command, env={**environment, "DISPLAY": display}, stdout=log, stderr=log)
        closing.callback(_end, process)
        window = Rviz(display, environment)
        until(lambda: window.view is not None, PATIENCE)
        yield window


def _end(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait()
