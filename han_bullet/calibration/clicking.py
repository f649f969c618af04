"""Points marked by clicking into the image in a window, their places on the floor typed in the terminal."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from han_bullet.calibration.points import MarkedPoints
from han_bullet.detection.pictures import Image
from han_bullet.window import open_figure

HELP = "click a floor point (zoom with the toolbar first), then type its place in the terminal; Enter here ends"
LEFT, END = 1, ("enter", "escape")
MARK = {"color": "gold", "marker": "+", "markersize": 14, "markeredgewidth": 2}

Ask = Callable[[str], str]
"""Returns what a person answers to a question, as `input`."""


def open_clicking(image: Image) -> ClickedImage:
    """Show an image in a window, to be clicked in.

    Raises:
        BadInputError: There is no display, or Python has no tkinter.
    """
    without = "list the points in a file and give it as --points FILE, without --click"
    pyplot, figure = open_figure("han-bullet calibrate", "--click", without)
    clicked = ClickedImage(figure, image)
    pyplot.show(block=False)
    return clicked


class ClickedImage:
    """An image in a matplotlib figure, and the clicks into it."""

    def __init__(self, figure: Any, image: Image) -> None:
        height, width = image.shape[:2]
        self._canvas = figure.canvas
        self._axes = figure.add_axes((0.0, 0.0, 1.0, 0.94))
        self._axes.set_axis_off()
        self._axes.set_title(HELP, fontsize=9)
        self._axes.imshow(image, extent=(0.0, width, height, 0.0))  # so that coordinates count from the corner
        self._clicked: tuple[float, float] | None = None
        self._open = True
        self._canvas.mpl_connect("button_press_event", self._on_click)
        self._canvas.mpl_connect("key_press_event", self._on_key)
        self._canvas.mpl_connect("close_event", self._on_close)

    def clicks(self) -> Iterator[tuple[float, float]]:
        """Give each clicked pixel (u, v) [px] until Enter is pressed or the window closed."""
        while self._open:
            self._clicked = None
            self._canvas.start_event_loop(0)
            if self._clicked is None:
                return
            yield self._clicked

    def mark(self, pixel: tuple[float, float], text: str) -> None:
        """Show a mark with a text, if the window is still there."""
        if not self._open:
            return
        self._axes.plot(*pixel, **MARK)
        self._axes.annotate(text, pixel, (6, 6), textcoords="offset points", color="gold", fontweight="bold")
        self._canvas.draw()
        self._canvas.flush_events()

    def _on_click(self, event: Any) -> None:
        moving = getattr(self._canvas.toolbar, "mode", "")  # zooming and panning are clicks, too
        if event.button == LEFT and event.inaxes is self._axes and not moving:
            self._clicked = (float(event.xdata), float(event.ydata))
            self._canvas.stop_event_loop()

    def _on_close(self, event: Any) -> None:
        self._open = False
        self._canvas.stop_event_loop()

    def _on_key(self, event: Any) -> None:
        if event.key in END:
            self._canvas.stop_event_loop()


def click_points(
    window: ClickedImage, points: MarkedPoints, ask: Ask, keep: Callable[[MarkedPoints], None]
) -> MarkedPoints:
    """Add points, one after another.

    Args:
        window: Shows the image.
        points: Marked before.
        ask: Gets x, y and, above the floor, z of a clicked point [m]; an empty answer forgets the click.
        keep: Called with all points after each new one, so that none is lost.
    """
    for number, (u, v) in enumerate(points.pixels.tolist(), 1):
        window.mark((u, v), str(number))
    for pixel in window.clicks():
        place = _asked_place(f"point {len(points) + 1} at u {pixel[0]:.1f}, v {pixel[1]:.1f}: x, y [m]: ", ask)
        if place is not None:
            points = MarkedPoints(np.vstack([points.pixels, pixel]), np.vstack([points.points_in_world, place]))
            window.mark(pixel, str(len(points)))
            keep(points)
    return points


def _asked_place(question: str, ask: Ask) -> tuple[float, float, float] | None:
    """Return the place typed; None for an empty answer."""
    while True:
        words = ask(question).replace(",", " ").split()
        if not words:
            return None
        try:
            values = [float(word) for word in words]
        except ValueError:
            values = []
        if len(values) in (2, 3) and all(map(math.isfinite, values)):
            x, y, z = (*values, 0.0)[:3]
            return x, y, z
        question = "two numbers, x and y in metres, or three with the height z; nothing forgets the click: "
