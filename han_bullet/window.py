"""A window that shows one picture after another; matplotlib's, since this OpenCV has none."""

from __future__ import annotations

import os
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

from han_bullet.errors import BadInputError


class Window:
    """Open a window.

    Raises:
        BadInputError: There is no display, or Python has no tkinter.
    """

    def __init__(self, title: str) -> None:
        if sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            raise BadInputError("--show needs a display, and there is none; look at the annotated copies instead")
        try:
            import tkinter

            import matplotlib

            matplotlib.use("TkAgg")
            from matplotlib import pyplot

            self._pyplot: Any = pyplot
            self._figure = pyplot.figure(title)
        except (ImportError, tkinter.TclError) as error:
            raise BadInputError(f"--show needs tkinter and a display that it can use: {error}") from error
        self._axes = self._figure.add_axes((0.0, 0.0, 1.0, 1.0))
        self._axes.set_axis_off()

    def show(self, picture: NDArray[np.uint8]) -> None:
        """Show an RGB picture."""
        self._axes.clear()
        self._axes.set_axis_off()
        self._axes.imshow(picture)
        self._pyplot.pause(0.001)
