"""The pedestrian detector on aggregated channel features [Dollar2014]: the sliding window."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.cascade import feature_offsets, scan
from han_bullet.detection.channels import CELL
from han_bullet.detection.detector import Detector
from han_bullet.detection.model_files import DEFAULT, proposer_file
from han_bullet.detection.nms import suppress
from han_bullet.detection.pyramid import PADDING_COLUMNS, PADDING_ROWS, Level, build_pyramid
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array
from han_bullet.messages import Detections


def load_acf_model(name_or_path: str | Path = DEFAULT) -> AcfModel:
    """Load a model.

    Args:
        name_or_path: "default", the name of a model that comes with the package ("acf_inria"), or a file: one of ours,
            .npz, or one of the toolbox, .mat.

    Raises:
        BadInputError: If there is no such model, or the file is not one.
    """
    path = proposer_file(name_or_path)
    if path.suffix.lower() != ".mat":
        return AcfModel.load(path)
    from han_bullet.detection.toolbox import load_toolbox_model  # scipy.io takes as long as all the rest to import

    return load_toolbox_model(path)


class AcfDetector(Detector):
    """Finds upright people in an image; one core, deterministic.

    Args:
        model: The classifier.
    """

    def __init__(self, model: AcfModel) -> None:
        self.model = model
        self.smallest_area = model.smallest_box_area

    def detect(self, image: NDArray[np.uint8]) -> Detections:
        """Return the people found in an image by falling score.

        Args:
            image: RGB, shape (h, w, 3), uint8.

        Returns:
            Boxes as high as the person, with probability 1.

        Raises:
            BadInputError: If the array is not such an image.
        """
        boxes, scores = self.scan(image)
        kept = suppress(boxes, scores)
        return Detections(boxes[kept], scores[kept], np.ones(len(kept)))

    def scan(self, image: NDArray[np.uint8]) -> tuple[Array, Array]:
        """Return boxes x, y, width, height, (n, 4) [px], and scores, (n,), of every window that passes the cascade."""
        if image.ndim != 3 or image.shape[2] != 3 or image.dtype != np.uint8:
            raise BadInputError(f"image has shape {image.shape} and type {image.dtype}, must be (h, w, 3) and uint8")
        model = self.model
        levels = build_pyramid(image, model.lambdas, (model.person_height, model.person_width))
        found = [self._scan_level(level) for level in levels]
        boxes = np.concatenate([np.empty((0, 4)), *(box for box, _ in found)])
        return boxes, np.concatenate([np.empty(0), *(score for _, score in found)])

    def _scan_level(self, level: Level) -> tuple[Array, Array]:
        """Return boxes in the image and scores of one level's windows."""
        model = self.model
        window_rows, window_columns = model.window_height // CELL, model.window_width // CELL
        offsets = feature_offsets(model.features, window_columns, level.channels.shape[1])
        rows, columns, scores = scan(
            level.channels,
            window_rows,
            window_columns,
            offsets,
            model.thresholds,
            model.leaves,
            model.cascade_threshold,
        )
        margin_x = 0.5 * (model.window_width - model.person_width)
        margin_y = 0.5 * (model.window_height - model.person_height)
        boxes = np.empty((rows.size, 4))
        boxes[:, 0] = (columns * CELL + margin_x - PADDING_COLUMNS * CELL) / level.scale_x
        boxes[:, 1] = (rows * CELL + margin_y - PADDING_ROWS * CELL) / level.scale_y
        boxes[:, 2], boxes[:, 3] = model.person_width / level.scale, model.person_height / level.scale
        return boxes, scores.astype(np.float64)
