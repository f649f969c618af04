"""What a fixed camera sees without people, and what that rules out.

A still camera on a still scene repeats its mistakes in every frame, so no later count of hits filters them. One
person-free image per camera, part of its calibration, does: a person is a change of pixels. That is background
subtraction: it drops every box where too little has changed, whether the empty scene gives that box too or not.
"""

from __future__ import annotations

import cv2
import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.foot_edge import foot_rows
from han_bullet.detection.overlap import intersection_over_union
from han_bullet.detection.pictures import Image
from han_bullet.detection.scene_shift import scene_shift
from han_bullet.detection.search_area import SearchArea, Windows
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array

Cells = NDArray[np.bool_]
"""A truth value of each cell of an image, shape (height // CELL, width // CELL)."""

# Images are compared as means over cells of this many pixels: a noise of 6 grey levels, the most that worlds draw,
# leaves 6 / 4 = 1.5 in a cell, 2.1 in the difference of two.
CELL = 4  # [px]
# A cell has changed when one of its colours differs by more: 5 standard deviations of that difference.
CHANGED_LEVEL = 11  # [grey levels]
# A box with a smaller part changed holds no person: rendered people change 27 to 75 % of a box around them, and one in
# clothes of the wall's colour still has head, shoes and shade.
LEAST_CHANGED_PART = 0.08
# A box that the empty scene gives too needs more: a passer-by who covers a corner of it explains nothing.
LEAST_CHANGED_PART_OF_REPEATED = 0.2
# With less of an image changed, the camera has not moved: half a degree changes 8 % of what our cameras see, or more.
LEAST_MOVED_PART = 0.06
# Boxes of one mistake jump between neighbouring scales (2 ** (1/8)) and cells from frame to frame; two with this
# overlap (intersection over union) are the same.
SAME_PLACE_OVERLAP = 0.5


class StillScene:
    """The person-free view of one fixed camera.

    Attributes:
        boxes: The detector's own mistakes in it, shape (m, 4): x, y, width, height [px].
    """

    def __init__(self, image: Image, boxes: Array) -> None:
        """Keep the calibration image, (height, width, 3) RGB, and the proposals that it gives."""
        self.boxes = np.asarray(boxes, float).reshape(-1, 4)
        self._image = image.copy()  # a caller may draw the next frame into theirs
        self._cells = _cell_means(image)

    def changes(self, image: Image) -> Changes:
        """Return what of an image differs from the empty scene.

        Raises:
            BadInputError: The image is not as large as that of the calibration.
        """
        if image.shape != self._image.shape:
            raise BadInputError(f"image is {image.shape}, but the camera was calibrated with {self._image.shape}")
        red, green, blue = np.moveaxis(cv2.absdiff(_cell_means(image), self._cells), 2, 0)
        return Changes(np.maximum(np.maximum(red, green), blue) > CHANGED_LEVEL)

    def shift(self, image: Image, changes: Changes) -> tuple[float, float]:
        """Return how far the scene has moved in an image with these changes, right and down [px]; see `scene_shift`."""
        if changes.cells.mean() < LEAST_MOVED_PART:  # nearly every image: people alone
            return 0.0, 0.0
        right, down = scene_shift(self._cells, _cell_means(image))
        return CELL * right, CELL * down

    def keep(self, changes: Changes, boxes: Array) -> NDArray[np.bool_]:
        """Tell which boxes, shape (n, 4) [px], of the image with these changes may hold a person; shape (n,)."""
        part = changes.part_of(boxes)
        repeated = intersection_over_union(boxes, self.boxes).max(axis=1, initial=0.0) >= SAME_PLACE_OVERLAP
        return part >= np.where(repeated, LEAST_CHANGED_PART_OF_REPEATED, LEAST_CHANGED_PART)

    def feet(self, image: Image, boxes: Array) -> Array:
        """Return the rows [px] where the feet in boxes, shape (n, 4) [px], end; NaN where nobody can tell, (n,)."""
        return foot_rows(image, self._image, boxes)


class Changes(SearchArea):
    """Which cells of an image differ from an empty scene; where that is enough for `StillScene.keep` is to be searched.

    Attributes:
        cells: A truth value of each.
    """

    def __init__(self, cells: Cells) -> None:
        self.cells = cells
        self._counts: NDArray[np.int32] = cv2.integral(cells.astype(np.uint8))  # type: ignore[assignment]

    def windows(self, x: Array, y: Array, width: float, height: float) -> Windows:
        """Tell which boxes of one size may hold a person; see `SearchArea`."""
        changed: Windows = _changed_windows(self._counts, x, y, width, height)
        return changed

    def may_hold(self, smallest_area: float) -> bool:
        """Tell whether enough has changed for `keep` to keep any box of at least an area [px^2]; exact, and cheap."""
        return bool(self._counts[-1, -1] * CELL**2 >= LEAST_CHANGED_PART * smallest_area)

    def part_of(self, boxes: Array) -> Array:
        """Return the part of each box, shape (n, 4) [px], whose pixels differ from the empty scene; shape (n,).

        A box that reaches over the image's edge counts as unchanged out there.
        """
        counts = self._counts
        x0, y0, width, height = np.asarray(boxes, float).reshape(-1, 4).T.copy()
        left, right = (_nearest(x, counts.shape[1]) for x in (x0, x0 + width))
        top, bottom = (_nearest(y, counts.shape[0]) for y in (y0, y0 + height))
        count = counts[bottom, right] - counts[top, right] - counts[bottom, left] + counts[top, left]
        part: Array = count * CELL**2 / (width * height)
        return part


@numba.njit(cache=True)
def _changed_windows(counts: NDArray[np.int32], x: Array, y: Array, width: float, height: float) -> Windows:
    """Do for all boxes of a grid what `Changes.part_of` does for a few; a box without area holds nobody."""
    changed = np.zeros((y.size, x.size), np.bool_)
    if not width * height > 0.0:
        return changed
    left, right = _nearest(x, counts.shape[1]), _nearest(x + width, counts.shape[1])
    top, bottom = _nearest(y, counts.shape[0]), _nearest(y + height, counts.shape[0])
    for row in range(y.size):
        upper, lower = counts[top[row]], counts[bottom[row]]
        for column in range(x.size):
            count = lower[right[column]] - upper[right[column]] - lower[left[column]] + upper[left[column]]
            changed[row, column] = count * CELL**2 / (width * height) >= LEAST_CHANGED_PART
    return changed


@numba.njit(cache=True)
def _nearest(places: Array, size: int) -> NDArray[np.int64]:
    """Return the edges between cells, of so many, that are nearest to places [px]."""
    edges = np.empty(places.size, np.int64)
    for index in range(places.size):
        edges[index] = min(max(round(places[index] / CELL), 0), size - 1)
    return edges


def _cell_means(image: Image) -> Image:
    means: Image = _means_of_lines(np.ascontiguousarray(image).reshape(len(image), -1))
    return means


@numba.njit(cache=True)
def _means_of_lines(lines: Image) -> Image:
    """Return the means, shape (height // CELL, width // CELL, 3), of an image, shape (height, 3 * width).

    They are rounded, halves to even, as OpenCV's are, which take six times as long.
    """
    rows, columns = lines.shape[0] // CELL, lines.shape[1] // (3 * CELL)
    means = np.empty((rows, columns, 3), np.uint8)
    sums = np.empty(lines.shape[1], np.uint16)
    for row in range(rows):
        sums[:] = 0
        for line in lines[row * CELL : (row + 1) * CELL]:
            for place in range(sums.size):
                sums[place] += line[place]
        for column in range(columns):
            for colour in range(3):
                total = 0
                for pixel in range(column * CELL, (column + 1) * CELL):
                    total += sums[3 * pixel + colour]
                mean, rest = divmod(total, CELL**2)
                means[row, column, colour] = mean + (2 * rest + mean % 2 > CELL**2)
    return means
