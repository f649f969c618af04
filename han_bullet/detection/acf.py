"""The pedestrian detector on aggregated channel features [Dollar2014]: the sliding window."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.cascade import Ints, feature_offsets, feature_rows, scan
from han_bullet.detection.detector import Detector
from han_bullet.detection.filters import filter_channels, halved
from han_bullet.detection.model_files import DEFAULT, proposer_file
from han_bullet.detection.nms import suppress
from han_bullet.detection.pictures import Image, check_rgb
from han_bullet.detection.pyramid import Level, build_pyramid
from han_bullet.detection.scales import LevelSize, level_sizes
from han_bullet.detection.scan_limits import ScanLimits
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
        self._window_columns = model.window_width // model.window_cell
        self._feature_rows = feature_rows(model.features, self._window_columns, model.window_channels)

    def detect(self, image: Image, limits: ScanLimits | None = None) -> Detections:
        """Return the people found in an image by falling score.

        Args:
            image: RGB, shape (h, w, 3), uint8.
            limits: How high people may be, by where their feet are; None looks for people of all sizes everywhere.

        Returns:
            Boxes as high as the person, with probability 1.

        Raises:
            BadInputError: If the array is not such an image.
        """
        found = self.scan(image, limits)
        kept = suppress(found.boxes, found.scores)
        return Detections(found.boxes[kept], found.scores[kept], np.ones(len(kept)))

    def scan(self, image: Image, limits: ScanLimits | None = None) -> Scan:
        """Return every window that passes the cascade, before non-maximum suppression; arguments as for `detect`."""
        check_rgb(image)
        model = self.model
        sizes = level_sizes(image.shape[0], image.shape[1], (model.person_height, model.person_width), model.cell)
        rows = {size: self._window_rows(size, limits) for size in sizes}
        needed = None if limits is None else lambda size: self._level_rows(rows[size], size)
        levels = build_pyramid(image, model.pyramid_settings, needed)
        found = [self._scan_level(level, rows[level.size]) for level in levels]
        return Scan(
            np.concatenate([np.empty((0, 4)), *(scan.boxes for scan in found)]),
            np.concatenate([np.empty(0), *(scan.scores for scan in found)]),
            sum(scan.windows for scan in found),
            sum(scan.trees for scan in found),
        )

    def _scan_level(self, level: Level, window_rows: Ints) -> Scan:
        """Return what is found in the windows that start in some rows of a level."""
        model, size = self.model, level.size
        channels = level.channels if model.filters is None else filter_channels(level.channels, model.filters)
        window_columns = self._window_columns
        offsets = feature_offsets(model.features, self._feature_rows, window_columns, *channels.shape[1:])
        rows_in_band = window_rows - np.int32(level.first_row)
        rows, columns, scores, trees = scan(
            channels, rows_in_band, window_columns, offsets, model.thresholds, model.leaves, model.cascade_threshold
        )
        boxes = np.empty((rows.size, 4))
        margin = 0.5 * (model.window_width - model.person_width) - model.padding_width
        boxes[:, 0] = (columns * model.window_cell + margin) / size.scale_x
        boxes[:, 1] = self._tops(rows + level.first_row, size)
        boxes[:, 2], boxes[:, 3] = model.person_width / size.scale, model.person_height / size.scale
        windows = window_rows.size * max(channels.shape[1] - window_columns + 1, 0)
        return Scan(boxes, scores.astype(np.float64), windows, trees)

    def _window_rows(self, size: LevelSize, limits: ScanLimits | None) -> Ints:
        """Return the rows of a level [cells] where windows start that may hold a person."""
        model = self.model
        level_rows = size.rows + 2 * (model.padding_height // model.cell)
        if model.filters is not None:
            level_rows = halved(level_rows)
        rows = np.arange(max(level_rows - model.window_height // model.window_cell + 1, 0), dtype=np.int32)
        if limits is None:
            return rows
        height = model.person_height / size.scale
        return rows[limits.allow(self._tops(rows, size) + height, height)]

    def _level_rows(self, window_rows: Ints, size: LevelSize) -> range:
        """Return the rows of a padded level [cells] that its windows look at, given the first of each."""
        if not window_rows.size:
            return range(0)
        if self.model.filters is not None:
            return range(size.rows + 2 * (self.model.padding_height // self.model.cell))
        return range(int(window_rows[0]), int(window_rows[-1]) + self.model.window_height // self.model.cell)

    def _tops(self, rows: Ints, size: LevelSize) -> Array:
        """Return the upper edges of the people [px] in the windows that start in some rows of a level."""
        model = self.model
        margin = 0.5 * (model.window_height - model.person_height) - model.padding_height
        return np.asarray((rows * model.window_cell + margin) / size.scale_y, np.float64)
