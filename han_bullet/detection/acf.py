"""The pedestrian detector on aggregated channel features [Dollar2014]: the sliding window."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numba
import numpy as np

from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.cascade import Offsets, feature_offsets, feature_rows, scan
from han_bullet.detection.detector import Detector
from han_bullet.detection.filters import filter_channels, halved
from han_bullet.detection.model_files import DEFAULT, proposer_file
from han_bullet.detection.nms import suppress
from han_bullet.detection.pictures import Image, check_rgb
from han_bullet.detection.pyramid import Level, build_pyramid
from han_bullet.detection.region import Region
from han_bullet.detection.scales import LevelSize, level_sizes
from han_bullet.detection.search_area import SearchArea, Windows
from han_bullet.detection.toolbox import load_toolbox_model
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array
from han_bullet.messages import Detections


def load_acf_model(name_or_path: str | Path = DEFAULT, calibration: float | None = None) -> AcfModel:
    """Load a model.

    Args:
        name_or_path: "default", the name of a model that comes with the package ("acf_inria"), or a file: one of ours,
            .npz, or one of the toolbox, .mat.
        calibration: Added to every leaf; None adds 0.01 to a model of the toolbox without filters, as its demo does,
            and nothing to others.

    Raises:
        BadInputError: If there is no such model, the file is not one, or the calibration is no finite number.
    """
    if calibration is not None and not math.isfinite(calibration):
        raise BadInputError(f"calibration is {calibration}; a small number such as 0.01 would be right")
    path = proposer_file(name_or_path)
    if path.suffix.lower() == ".mat":
        return load_toolbox_model(path, calibration)
    model = AcfModel.load(path)
    return model if calibration is None else replace(model, leaves=model.leaves + np.float32(calibration))


@dataclass(frozen=True)
class Scan:
    """Every window of an image that passes the cascade, and what finding them took.

    Attributes:
        boxes: x, y, width, height, shape (n, 4) [px], as high as the person, unsorted and overlapping.
        scores: Shape (n,).
        windows: How many windows were looked at.
        trees: How many trees were evaluated in all of them.
    """

    boxes: Array
    scores: Array
    windows: int
    trees: int


class AcfDetector(Detector):
    """Finds upright people in an image; one core, deterministic.

    Args:
        model: The classifier.
    """

    def __init__(self, model: AcfModel) -> None:
        self.model = model
        self.smallest_area = model.smallest_box_area
        self._window_rows = model.window_height // model.window_cell
        self._window_columns = model.window_width // model.window_cell
        self._edges = functools.lru_cache(maxsize=256)(self._find_edges)  # a camera's images all have one size
        self._offsets = functools.lru_cache(maxsize=256)(self._find_offsets)
        self._feature_rows = feature_rows(model.features, self._window_columns, model.window_channels)

    def detect(self, image: Image, area: SearchArea | None = None) -> Detections:
        """Return the people found in an image by falling score.

        Args:
            image: RGB, shape (h, w, 3), uint8.
            area: Where people may be; None looks for people of all sizes everywhere.

        Returns:
            Boxes as high as the person, with probability 1.

        Raises:
            BadInputError: If the array is not such an image.
        """
        found = self.scan(image, area)
        kept = suppress(found.boxes, found.scores)
        return Detections(found.boxes[kept], found.scores[kept], np.ones(len(kept)))

    def scan(self, image: Image, area: SearchArea | None = None) -> Scan:
        """Return every window that passes the cascade, before non-maximum suppression; arguments as for `detect`."""
        check_rgb(image)
        model = self.model
        sizes = level_sizes(image.shape[0], image.shape[1], (model.person_height, model.person_width), model.cell)
        windows = {size: self._windows(size, area) for size in sizes}
        needed = None if area is None else lambda size: self._looked_at(windows[size], size)
        levels = build_pyramid(image, model.pyramid_settings, needed)
        found = [self._scan_level(level, windows[level.size]) for level in levels]
        return Scan(
            np.concatenate([np.empty((0, 4)), *(scan.boxes for scan in found)]),
            np.concatenate([np.empty(0), *(scan.scores for scan in found)]),
            sum(scan.windows for scan in found),
            sum(scan.trees for scan in found),
        )

    def _scan_level(self, level: Level, windows: Windows) -> Scan:
        """Return what is found in some windows of a level."""
        model, size = self.model, level.size
        channels = level.channels if model.filters is None else filter_channels(level.channels, model.filters)
        part = windows[
            level.first_row : level.first_row + max(channels.shape[0] - self._window_rows + 1, 0),
            level.first_column : level.first_column + max(channels.shape[1] - self._window_columns + 1, 0),
        ].copy()
        offsets = self._offsets(*channels.shape[1:])
        rows, columns, scores, trees = scan(
            channels, part, offsets, model.thresholds, model.leaves, model.cascade_threshold
        )
        boxes = np.empty((rows.size, 4))
        lefts, tops = self._edges(size)
        boxes[:, 0], boxes[:, 1] = lefts[columns + level.first_column], tops[rows + level.first_row]
        boxes[:, 2], boxes[:, 3] = model.person_width / size.scale, model.person_height / size.scale
        return Scan(boxes, scores.astype(np.float64), int(np.count_nonzero(part)), trees)

    def _windows(self, size: LevelSize, area: SearchArea | None) -> Windows:
        """Return which windows of a level to look at, by their first row and column."""
        lefts, tops = self._edges(size)
        if area is None:
            return np.ones((tops.size, lefts.size), np.bool_)
        return area.windows(lefts, tops, self.model.person_width / size.scale, self.model.person_height / size.scale)

    def _looked_at(self, windows: Windows, size: LevelSize) -> Region | None:
        """Return the part of a padded level [cells] that its windows look at."""
        rows, columns = _bounds(windows)
        if not len(rows):
            return None
        if self.model.filters is not None:
            return Region.all_of(*self._padded(size))
        below, beside = self._window_rows - 1, self._window_columns - 1
        return Region(
            range(rows.start, rows.stop + below), range(columns.start, columns.stop + beside), self._padded(size)
        )

    def _find_offsets(self, level_columns: int, channels: int) -> Offsets:
        return feature_offsets(self.model.features, self._feature_rows, self._window_columns, level_columns, channels)

    def _padded(self, size: LevelSize) -> tuple[int, int]:
        """Return rows and columns of a level with its padding [cells]."""
        padding_rows, padding_columns = self.model.pyramid_settings.padding
        return size.rows + 2 * padding_rows, size.columns + 2 * padding_columns

    def _find_edges(self, size: LevelSize) -> tuple[Array, Array]:
        """Return the left and the upper edges of the people [px] in the windows of a level, by column and by row."""
        model = self.model
        rows, columns = self._padded(size)
        if model.filters is not None:
            rows, columns = halved(rows), halved(columns)
        beside = 0.5 * (model.window_width - model.person_width) - model.padding_width
        above = 0.5 * (model.window_height - model.person_height) - model.padding_height
        lefts = np.arange(max(columns - self._window_columns + 1, 0)) * model.window_cell + beside
        tops = np.arange(max(rows - self._window_rows + 1, 0)) * model.window_cell + above
        return np.asarray(lefts / size.scale_x, np.float64), np.asarray(tops / size.scale_y, np.float64)


def _bounds(windows: Windows) -> tuple[range, range]:
    """Return the rows and columns that hold all windows to look at; empty ranges if there are none."""
    top, bottom, left, right = _first_and_last(windows)
    return range(top, bottom), range(left, right)


@numba.njit(cache=True)
def _first_and_last(windows: Windows) -> tuple[int, int, int, int]:
    top, bottom, left, right = windows.shape[0], 0, windows.shape[1], 0
    for row in range(windows.shape[0]):
        for column in range(windows.shape[1]):
            if windows[row, column]:
                top, bottom = min(top, row), row + 1
                left, right = min(left, column), max(right, column + 1)
    return top, max(bottom, top), left, max(right, left)
