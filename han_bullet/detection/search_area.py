"""Where in an image people may be, so that a detector looks nowhere else."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array

Windows = NDArray[np.bool_]
"""Which of a grid of windows to look at, shape (rows, columns)."""


class SearchArea(ABC):
    """Tells which boxes may hold a person."""

    @abstractmethod
    def windows(self, x: Array, y: Array, width: float, height: float) -> Windows:
        """Tell which boxes of one size may hold a person, shape (rows, columns).

        Args:
            x: Left edges, shape (columns,) [px].
            y: Upper edges, shape (rows,) [px].
            width: Of every box [px].
            height: Of every box [px].
        """

    def allow_boxes(self, boxes: Array) -> NDArray[np.bool_]:
        """Tell which boxes, shape (n, 4): x, y, width, height [px], may hold a person; shape (n,)."""
        return np.array([self.windows(box[:1], box[1:2], box[2], box[3])[0, 0] for box in boxes], np.bool_)


class Both(SearchArea):
    """What two areas allow."""

    def __init__(self, first: SearchArea, second: SearchArea) -> None:
        """Join two areas."""
        self._first, self._second = first, second

    def windows(self, x: Array, y: Array, width: float, height: float) -> Windows:
        """Tell which boxes of one size both areas allow; see `SearchArea`."""
        return self._first.windows(x, y, width, height) & self._second.windows(x, y, width, height)
