"""What a picture truly shows of one body: where all of it lies, and how much of it something nearer hides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from han_bullet.geometry import Array
from han_bullet.sim.raster import Raster


@dataclass(frozen=True)
class Silhouette:
    """The outline of a body drawn alone, and what is left of it among everything else.

    Attributes:
        box: Tight around the body as far as it lies inside the picture, hidden parts included: x, y of the upper left
            corner, width, height, shape (4,) [px].
        cut: Whether it reaches the picture's edge.
        hidden: Part of its pixels that show something nearer, in [0, 1].
    """

    box: Array
    cut: bool
    hidden: float


def silhouette_of(body: Raster, picture: Raster) -> Silhouette | None:
    """Compare a body, drawn alone, with the whole picture.

    Returns:
        None where the body has no pixel in the picture.
    """
    drawn = body.drawn
    rows, columns = np.flatnonzero(drawn.any(axis=1)), np.flatnonzero(drawn.any(axis=0))
    if not len(rows):
        return None
    left, right, top, bottom = int(columns[0]), int(columns[-1]) + 1, int(rows[0]), int(rows[-1]) + 1
    height, width = drawn.shape
    # The same triangles give the same depths to the last bit, so an equal depth shows the body.
    shown = drawn & (body.inverse_depth == picture.inverse_depth)
    return Silhouette(
        box=np.array([left, top, right - left, bottom - top], float),
        cut=left <= 0 or top <= 0 or right >= width or bottom >= height,
        hidden=1.0 - float(shown.sum()) / float(drawn.sum()),
    )
