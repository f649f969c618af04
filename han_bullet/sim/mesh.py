"""What the renderer draws: a surface with a picture on it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from han_bullet.errors import BadInputError
from han_bullet.sim.raster import Image
from han_bullet.sim.surfaces import Surface


@dataclass(frozen=True)
class Mesh:
    """A surface and how it looks.

    Attributes:
        surface: Its triangles.
        picture: What its texture coordinates refer to, RGB, shape (height, width, 3); one pixel for a plain colour.
    """

    surface: Surface
    picture: Image


def painted(surface: Surface, texture: Path | None, colour: tuple[float, float, float]) -> Mesh:
    """Return a surface with a texture, or plain; the colour, in [0, 1], multiplies it.

    Raises:
        BadInputError: The texture is no picture.
    """
    picture = np.full((1, 1, 3), 255, np.uint8) if texture is None else _read(texture)
    return Mesh(surface, (picture * np.asarray(colour, np.float32)).astype(np.uint8))


def _read(path: Path) -> Image:
    picture = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if picture is None:
        raise BadInputError(f"texture {path} is not a picture that can be read")
    return np.ascontiguousarray(picture[..., ::-1], np.uint8)
