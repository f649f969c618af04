"""Colour and depth of what one PyBullet client holds, and joining two such pictures by depth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pybullet
from numpy.typing import NDArray

from han_bullet.geometry import Array, Intrinsics
from han_bullet.sim.lens import Crop, projection_matrix, view_matrix
from han_bullet.world_schema import Light

Image = NDArray[np.uint8]
EMPTY = 1.0 - 2.0**-23  # depth of a pixel in which nothing was drawn: the renderer gives a last bit less than 1


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
    """A picture with depth; its arrays are filled in place as bodies are joined.

    Attributes:
        colour: RGB, shape (height, width, 3).
        depth: The renderer's depth buffer, shape (height, width), 0 near and 1 far.
    """

    colour: Image
    depth: NDArray[np.float32]

    def join(self, other: Raster, crop: Crop) -> None:
        """Draw another raster, which covers one part of this one, where it is nearer."""
        colour, depth = self.colour[crop.window], self.depth[crop.window]
        nearer = other.depth < depth
        colour[nearer] = other.colour[nearer]
        depth[nearer] = other.depth[nearer]

    def fill_empty(self, colour: tuple[int, int, int]) -> None:
        """Paint all pixels in which nothing was drawn."""
        self.colour[self.depth >= EMPTY] = colour

    def copy(self) -> Raster:
        """Return a raster with arrays of its own."""
        return Raster(self.colour.copy(), self.depth.copy())


def draw(client: int, view: View, crop: Crop, light: Light) -> Raster:
    """Draw what a client holds, as seen in one part of an image.

    Without shadows: a picture is joined from several clients, and a shadow would need them all in one.
    """
    _, _, rgba, depth, _ = pybullet.getCameraImage(
        crop.width,
        crop.height,
        view_matrix(view.camera_in_world),
        projection_matrix(view.intrinsics, crop),
        lightDirection=light.direction,
        lightColor=light.colour,
        lightAmbientCoeff=light.ambient,
        lightDiffuseCoeff=light.diffuse,
        lightSpecularCoeff=0.0,
        shadow=0,
        flags=pybullet.ER_NO_SEGMENTATION_MASK,
        renderer=pybullet.ER_TINY_RENDERER,
        physicsClientId=client,
    )
    return Raster(np.ascontiguousarray(rgba[..., :3]), depth.copy())
