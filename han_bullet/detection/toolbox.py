"""Reads the ACF models that come with Piotr's Computer Vision Matlab Toolbox 3.40 [Dollar2014]."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat

from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.cascade import Ints
from han_bullet.detection.channels import CELL, CHANNELS
from han_bullet.errors import BadInputError

DEMO_CALIBRATION = 0.01  # what the toolbox's INRIA demo adds to every leaf; scores rise by this for each tree
PAPER_THRESHOLD = 40.0  # on the score of the toolbox's INRIA model [Mateus2019]


def load_toolbox_model(path: Path) -> AcfModel:
    """Read a detector with depth-2 trees and a shrinkage of 4 from the toolbox's .mat file.

    The file holds no score threshold; the model gets the paper's.

    Args:
        path: Such as AcfInriaDetector.mat.

    Raises:
        BadInputError: If the file is not such a detector.
    """
    try:
        detector = loadmat(path, squeeze_me=True, struct_as_record=False)["detector"]
        return _convert(detector.clf, detector.opts)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, IndexError, NotImplementedError) as error:
        raise BadInputError(f"{path} is not an ACF detector of the toolbox with depth-2 trees: {error}") from error


def _convert(classifier: Any, options: Any) -> AcfModel:
    """Build our model from the toolbox's structures, whose columns are trees and whose nodes count from one."""
    if int(classifier.treeDepth) != 2 or int(options.pPyramid.pChns.shrink) != CELL or np.size(options.filters):
        raise ValueError("trees must be two deep, shrink must be 4, and there must be no filters")
    window_height, window_width = (int(size) for size in options.modelDsPad)
    person_height, person_width = (int(size) for size in options.modelDs)
    colour, magnitude, orientation = (float(value) for value in options.pPyramid.lambdas)
    features = _transpose_features(classifier.fids[:3].T.astype(np.int32), window_height // CELL, window_width // CELL)
    return AcfModel(
        features=features,
        thresholds=np.ascontiguousarray(classifier.thrs[:3].T, np.float32),
        leaves=np.ascontiguousarray(classifier.hs[3:7].T + np.float32(DEMO_CALIBRATION), np.float32),
        lambdas=(colour, magnitude, orientation),
        person_height=person_height,
        person_width=person_width,
        window_height=window_height,
        window_width=window_width,
        cascade_threshold=float(options.cascThr),
        score_threshold=PAPER_THRESHOLD,
    )


def _transpose_features(features: Ints, rows: int, columns: int) -> Ints:
    """Turn indices into windows laid out (channel, column, row) into indices into (row, column, channel)."""
    channel, rest = np.divmod(features, rows * columns)
    column, row = np.divmod(rest, rows)
    return np.ascontiguousarray((row * columns + column) * CHANNELS + channel, np.int32)
