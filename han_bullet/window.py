"""Windows that show one picture after another, or figures to click in; matplotlib's, since this OpenCV has none."""

from __future__ import annotations

import os
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

from han_bullet.errors import BadInputError


def open_figure(title: str, option: str, otherwise: str) -> tuple[Any, Any]:
    """Open an empty matplotlib figure in a window.

    Args:
        title: Of the window.
        option: Of the command that asked for a window, for the message.
        otherwise: What to do without a display, for the message.

    Returns:
        Pyplot and the figure.

    Raises:
        BadInputError: There is no display, or Python has no tkinter.
    """
    if sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise BadInputError(f"{option} needs a display, and there is none; {otherwise}")
    try:
        import tkinter

        import matplotlib

        matplotlib.use("TkAgg")
        from matplotlib import pyplot

        return pyplot, pyplot.figure(title)
    except (ImportError, tkinter.TclError) as error:
        raise BadInputError(f"{option} needs tkinter and a display that it can use: {error}") from error


class Window:
    """Open a window.

    Raises:
        BadInputError: There is no display, or Python has no tkinter.
    """

    def __init__(self, title: str) -> None:
        self._pyplot, self._figure = open_figure(title, "--show", "look at the annotated copies instead")
        self._axes = self._figure.add_axes((0.0, 0.0, 1.0, 1.0))
        self._axes.set_axis_off()

    def show(self, picture: NDArray[np.uint8]) -> None:
        """Show an RGB picture."""
        self._axes.clear()
        self._axes.set_axis_off()
        self._axes.imshow(picture)
        self._pyplot.pause(0.001)
