"""Turns the detectors that come with Piotr's Computer Vision Matlab Toolbox 3.40 into models of ours.

These are plain ACF detectors [Dollar2014] and such with filters, LDCF [Nam2014].
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.acf_model import LARGEST_DEPTH, LARGEST_WINDOW, AcfModel
from han_bullet.detection.cascade import Ints
from han_bullet.detection.channels import CHANNELS, Floats
from han_bullet.detection.filters import HALVING
from han_bullet.detection.mat_file import Value, read_mat
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array

DEMO_CALIBRATION = 0.01  # what the toolbox's INRIA demo adds to every leaf of ACF; scores rise by this for each tree
PAPER_THRESHOLD = 40.0  # on the score of the toolbox's INRIA model, with that calibration [Mateus2019]
INRIA_TREES, INRIA_PERSON = 2048, (100, 41)  # of that model; height and width [px]
MOST_TREES = 2**16

# What of the toolbox's options this detector computes, and nothing else.
_COMPUTED: dict[str, float | str] = {
    "pPyramid.pChns.pColor.enabled": 1,
    "pPyramid.pChns.pColor.smooth": 1,
    "pPyramid.pChns.pColor.colorSpace": "luv",
    "pPyramid.pChns.pGradMag.enabled": 1,
    "pPyramid.pChns.pGradMag.colorChn": 0,
    "pPyramid.pChns.pGradMag.normRad": 5,
    "pPyramid.pChns.pGradMag.normConst": 0.005,
    "pPyramid.pChns.pGradMag.full": 0,
    "pPyramid.pChns.pGradHist.enabled": 1,
    "pPyramid.pChns.pGradHist.nOrients": 6,
    "pPyramid.pChns.pGradHist.softBin": 0,
    "pPyramid.pChns.pGradHist.useHog": 0,
    "pPyramid.nPerOct": 8,
    "pPyramid.nOctUp": 0,
    "pPyramid.nApprox": 7,
    "pPyramid.smooth": 1,
    "pNms.type": "maxg",
    "pNms.overlap": 0.65,
    "pNms.ovrDnm": "min",
}


def load_toolbox_model(path: Path, calibration: float | None = None) -> AcfModel:
    """Read a detector from the toolbox's .mat file.

    The file holds no score threshold. The INRIA model's kind (no filters, 2048 trees, a person of 100 x 41 px) gets the
    paper's, every other none, -inf.

    Args:
        path: Such as AcfInriaDetector.mat or LdcfInriaDetector.mat.
        calibration: Added to every leaf; None adds what the toolbox's demos do, 0.01 without filters and 0 with.

    Raises:
        BadInputError: If the file is not such a detector.
    """
    try:
        variables = read_mat(path)
        classifier, options = _get(variables, "detector.clf"), _get(variables, "detector.opts")
        with np.errstate(all="ignore"):  # the model checks that its numbers are finite
            return _convert(classifier, options, calibration)
    except (OSError, ValueError, BadInputError) as error:
        raise BadInputError(f"{path} is not an ACF or LDCF detector of the toolbox: {error}") from error


def _convert(classifier: Value, options: Value, calibration: float | None) -> AcfModel:
    """Build our model from the toolbox's structures."""
    _check_options(options)
    filters = _filters(options)
    if calibration is None:
        calibration = DEMO_CALIBRATION if filters is None else 0.0
    features, thresholds, leaves = _complete_trees(classifier)
    colour, magnitude, orientation = (float(value) for value in _numbers(options, "pPyramid.lambdas", 3))
    person, window = _integers(options, "modelDs", 2), _integers(options, "modelDsPad", 2)
    padding, (cell,) = _integers(options, "pPyramid.pad", 2), _integers(options, "pPyramid.pChns.shrink", 1)
    (step,) = _integers(options, "stride", 1)
    window_cell = cell if filters is None else HALVING * cell
    if step != window_cell or step < 1:
        raise ValueError(f"its windows lie {step} px apart; with its cells {window_cell} px would be right")
    channels = CHANNELS if filters is None else CHANNELS * len(filters)
    return AcfModel(
        features=_transpose_features(features, window[0] // window_cell, window[1] // window_cell, channels),
        thresholds=thresholds,
        leaves=leaves + np.float32(calibration),
        lambdas=(colour, magnitude, orientation),
        person_height=person[0],
        person_width=person[1],
        window_height=window[0],
        window_width=window[1],
        cascade_threshold=float(_numbers(options, "cascThr", 1)[0]),
        score_threshold=_score_threshold(filters, len(leaves), person, calibration),
        cell=cell,
        padding_height=padding[0],
        padding_width=padding[1],
        filters=filters,
        rough=True,
    )


def _score_threshold(filters: Floats | None, trees: int, person: Sequence[int], calibration: float) -> float:
    """Return the paper's threshold, which moves with the calibration that each tree adds; -inf for other models."""
    if filters is not None or (trees, tuple(person)) != (INRIA_TREES, INRIA_PERSON):
        return -math.inf
    return PAPER_THRESHOLD + trees * (calibration - DEMO_CALIBRATION)


def _check_options(options: Value) -> None:
    """Check that the detector computes what ours computes."""
    for name, right in _COMPUTED.items():
        found = _get(options, name)
        fits = found == right if isinstance(right, str) else _numbers(options, name, 1)[0] == right
        if not fits:
            raise ValueError(f"its option {name} is not {right}, the only one supported")
    if np.size(_get(options, "pPyramid.pChns.pCustom")):  # type: ignore[arg-type]
        raise ValueError("it has channels of its own (pCustom), which are not supported")


def _filters(options: Value) -> Floats | None:
    """Return the filters, (n, height, width, 10), or None."""
    filters = _get(options, "filters")
    if not isinstance(filters, np.ndarray) or filters.dtype.kind not in "iuf":
        raise ValueError("its filters are no numbers")
    if not filters.size:
        return None
    if filters.ndim != 4:
        raise ValueError(f"its filters have shape {filters.shape}; (height, width, channels, filters) would be right")
    return np.ascontiguousarray(filters.transpose(3, 0, 1, 2), np.float32)


def _complete_trees(classifier: Value) -> tuple[Ints, Floats, Floats]:
    """Return features, thresholds and leaves of complete trees, from columns of nodes with a table of children.

    A node's child is the number of its left child, counted from one, and the right one follows it; a leaf has none, 0.
    Below a leaf that comes early, the complete tree repeats it.
    """
    tables = [_table(classifier, name) for name in ("child", "fids", "thrs", "hs")]
    child, features, thresholds, scores = tables
    trees, nodes = child.shape
    if any(table.shape != child.shape for table in tables) or not 0 < trees <= MOST_TREES:
        raise ValueError(
            f"its tables {[table.shape[::-1] for table in tables]} must have one shape, with 1 to {MOST_TREES} trees"
        )
    if not np.all((child == 0) | ((child >= 2) & (child < nodes) & (child == np.floor(child)))):
        raise ValueError(f"its trees have {nodes} nodes, and children that are none of them")
    each = np.arange(trees)[:, np.newaxis]
    level: NDArray[np.int64] = np.zeros((trees, 1), np.int64)
    inner: list[NDArray[np.int64]] = []
    while (child[each, level] > 0).any():
        if len(inner) == LARGEST_DEPTH:
            raise ValueError(f"its trees are more than {LARGEST_DEPTH} deep, or turn in a circle")
        inner.append(level)
        left = child[each, level].astype(np.int64) - 1
        pairs = np.stack([np.where(left < 0, level, left), np.where(left < 0, level, left + 1)], axis=2)
        level = pairs.reshape(trees, -1)
    if not inner:
        raise ValueError("none of its trees has a branch")
    node = np.concatenate(inner, axis=1)
    branches = child[each, node] > 0
    used = np.where(branches, features[each, node], 0)
    if not np.all((used >= 0) & (used < np.iinfo(np.int32).max) & (used == np.floor(used))):
        raise ValueError("the features of its trees must be whole numbers from 0 on")
    return (
        used.astype(np.int32),
        np.where(branches, thresholds[each, node], 0).astype(np.float32),
        scores[each, level].astype(np.float32),
    )


def _transpose_features(features: Ints, rows: int, columns: int, channels: int) -> Ints:
    """Turn indices into windows laid out (channel, column, row) into indices into (row, column, channel)."""
    if features.max() >= rows * columns * channels:
        raise ValueError(f"its trees look at feature {features.max()} of {rows * columns * channels}")
    channel, rest = np.divmod(features, rows * columns)
    column, row = np.divmod(rest, rows)
    return np.ascontiguousarray((row * columns + column) * channels + channel, np.int32)


def _get(value: Value, path: str) -> Value:
    """Return what stands at a path of field names."""
    for field in path.split("."):
        if not isinstance(value, dict) or field not in value:
            raise ValueError(f"it has no {path}")
        value = value[field]
    return value


def _table(classifier: Value, name: str) -> Array:
    """Return a table of numbers, shape (trees, nodes)."""
    table = _get(classifier, name)
    if not isinstance(table, np.ndarray) or table.ndim != 2 or table.dtype.kind not in "iuf":
        raise ValueError(f"its {name} is no table of numbers")
    return table.T.astype(np.float64)


def _numbers(options: Value, name: str, count: int) -> Array:
    """Return an option that is so many numbers."""
    numbers = _get(options, name)
    if not isinstance(numbers, np.ndarray) or numbers.size != count or numbers.dtype.kind not in "iuf":
        raise ValueError(f"its option {name} must be {count} number{'s' * (count > 1)}")
    return numbers.astype(np.float64).ravel()


def _integers(options: Value, name: str, count: int) -> list[int]:
    """Return an option that is so many whole numbers of pixels."""
    numbers = _numbers(options, name, count)
    if not np.all((numbers >= 0) & (numbers <= LARGEST_WINDOW) & (numbers == np.floor(numbers))):
        raise ValueError(
            f"its option {name} is {numbers.tolist()}; whole numbers up to {LARGEST_WINDOW} would be right"
        )
    return [int(number) for number in numbers]
