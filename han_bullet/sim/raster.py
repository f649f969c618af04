"""A picture with depth, and where it is taken from."""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array, Intrinsics

Image = NDArray[np.uint8]


@dataclass(frozen=True)
class View:
    """Where a picture is taken from.

    Attributes:
        intrinsics: Of the camera.
        camera_in_world: Its pose, shape (4, 4).
    """

    intrinsics: Intrinsics
    camera_in_world: Array


@dataclass(frozen=True)
class Raster:
    """A picture with depth; meshes are drawn into it, in place.

    Attributes:
        colour: RGB, shape (height, width, 3).
        inverse_depth: One over the distance along the view [1/m], shape (height, width); 0 where nothing was drawn.
    """

    colour: Image
    inverse_depth: NDArray[np.float32]

    @classmethod
    def blank(cls, intrinsics: Intrinsics) -> Raster:
        """Return a black picture of nothing."""
        shape = (intrinsics.height, intrinsics.width)
        return cls(np.zeros((*shape, 3), np.uint8), np.zeros(shape, np.float32))

    @property
    def drawn(self) -> NDArray[np.bool_]:
        """Tell in which pixels something was drawn, shape (height, width)."""
        somewhere: NDArray[np.bool_] = self.inverse_depth > 0.0
        return somewhere

    def fill_empty(self, colour: tuple[int, int, int]) -> None:
        """Paint all pixels in which nothing was drawn."""
        _fill_empty(self.colour, self.inverse_depth, colour)

    def copy(self) -> Raster:
        """Return a raster with arrays of its own."""
        return Raster(self.colour.copy(), self.inverse_depth.copy())


@numba.njit(cache=True)
def _fill_empty(colour: Image, inverse_depth: NDArray[np.float32], filling: tuple[int, int, int]) -> None:
    for row in range(colour.shape[0]):
        for column in range(colour.shape[1]):
            if not inverse_depth[row, column] > 0.0:
                colour[row, column, 0], colour[row, column, 1], colour[row, column, 2] = filling
