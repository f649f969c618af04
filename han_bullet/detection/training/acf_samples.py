"""Training windows for the ACF classifier: people from the INRIA crops, background from person-free photographs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np

from han_bullet.detection.acf import AcfDetector
from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.channels import CELL, CHANNELS, Floats, compute_channels
from han_bullet.detection.colour import luv
from han_bullet.detection.pictures import Image, cut, read_picture
from han_bullet.detection.pyramid import smooth
from han_bullet.detection.resampling import resample_planes
from han_bullet.detection.training.boxes import misplaced
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array

# [px] in the window: as the INRIA crops have them, because any resampling would blur people but not background.
PERSON_HEIGHT, PERSON_WIDTH = 96, 39
WINDOW_HEIGHT, WINDOW_WIDTH = 128, 64  # [px] with the margin that the classifier looks at
WINDOW_VALUES = WINDOW_HEIGHT * WINDOW_WIDTH // CELL**2 * CHANNELS
MARGIN = 32  # [px] around the window, so that its channels do not see the crop's border
CROP_MARGIN = 16  # [px] kept around the window in those crops, which have little more to give
TINY_MEAN = 1 / 50  # of the largest mean: flat windows have no meaningful ratio between scales
LAMBDA_DIGITS = 5


def window_features(crop: Image) -> Floats:
    """Return the smoothed channels of the window in the centre of a crop, flattened as (row, column, channel)."""
    channels = smooth(compute_channels(luv(crop)))
    rows, columns = WINDOW_HEIGHT // CELL, WINDOW_WIDTH // CELL
    top, left = (channels.shape[0] - rows) // 2, (channels.shape[1] - columns) // 2
    window: Floats = channels[top : top + rows, left : left + columns].reshape(-1)
    return window


def person_crop(path: Path) -> Image:
    """Return an INRIA crop, 160 x 96 px, with a person of 96 px in its centre.

    Raises:
        BadInputError: It is no picture or of another size.
    """
    crop = read_picture(path)
    if crop.shape[:2] != (WINDOW_HEIGHT + 2 * CROP_MARGIN, WINDOW_WIDTH + 2 * CROP_MARGIN):
        raise BadInputError(
            f"{path} is {crop.shape[1]} x {crop.shape[0]} px; INRIA's crops of 96 x 160 px would be right"
        )
    return crop


def box_crop(image: Image, box: Array) -> Image:
    """Return a crop, 192 x 128 px, around a box (x, y, width, height) [px] that is scaled to a person's height.

    The cut lies on whole pixels, so that a box of the window's own size is copied unchanged.
    """
    height, width = WINDOW_HEIGHT + 2 * MARGIN, WINDOW_WIDTH + 2 * MARGIN
    scale = PERSON_HEIGHT / float(box[3])
    left, top = box[0] + box[2] / 2 - width / scale / 2, box[1] + box[3] / 2 - height / scale / 2
    x0, y0 = round(float(left)), round(float(top))
    patch = cut(image, x0, y0, x0 + round(width / scale), y0 + round(height / scale))
    if patch.shape[:2] == (height, width):
        return patch
    return np.asarray(cv2.resize(patch, (width, height), interpolation=cv2.INTER_AREA), np.uint8)


def misplaced_windows(crops: Sequence[Image], count: int, rng: np.random.Generator) -> Floats:
    """Return the features, (n, 5120), of `count` windows per INRIA crop that are wrong by half a person."""
    x, y = 0.5 * (WINDOW_WIDTH - PERSON_WIDTH) + CROP_MARGIN, 0.5 * (WINDOW_HEIGHT - PERSON_HEIGHT) + CROP_MARGIN
    person = np.array([x, y, PERSON_WIDTH, PERSON_HEIGHT])
    kinds = rng.integers(4, size=(len(crops), count))
    windows = [
        window_features(box_crop(crop, misplaced(person, kind, rng)))
        for crop, row in zip(crops, kinds, strict=True)
        for kind in row
    ]
    return np.array(windows, np.float32).reshape(-1, WINDOW_VALUES)


def estimate_lambdas(windows: Sequence[Image]) -> tuple[float, float, float]:
    """Return how strongly colour, magnitude and orientation fade with scale, from pictures of 128 x 64 px.

    lambda is the slope of log2(mean at s / mean at 1) on -log2(s), with an intercept, over the sizes that are
    whole cells on both sides [Dollar2014]. Colour hardly fades and gets exactly 0, as in the original.
    """
    steps = range(WINDOW_WIDTH // CELL, WINDOW_WIDTH // CELL // 4 - 1, -1)
    scales = np.array([step * CELL / WINDOW_WIDTH for step in steps])
    means = np.array([_gradient_means(luv(window), scales) for window in windows])
    slopes = []
    for kind in range(means.shape[2]):
        usable = means[:, :, kind].min(axis=1) > TINY_MEAN * means[:, :, kind].max()
        ratios = np.log2(means[usable, 1:, kind] / means[usable, :1, kind]).mean(axis=0)
        slopes.append(round(float(np.polyfit(-np.log2(scales[1:]), ratios, 1)[0]), LAMBDA_DIGITS))
    return 0.0, slopes[0], slopes[1]


def _gradient_means(planes: Floats, scales: Array) -> Array:
    """Return the mean magnitude and the mean orientation channel at each scale, shape (scales, 2)."""
    means = []
    for scale in scales:
        resampled = resample_planes(planes, round(planes.shape[1] * scale), round(planes.shape[2] * scale))
        mean = compute_channels(resampled).reshape(-1, CHANNELS).mean(axis=0, dtype=np.float64)
        means.append([mean[3], mean[4:].mean()])
    return np.array(means)


def grid_boxes(height: int, width: int, count: int) -> Array:
    """Return up to `count` boxes of a person's size, (n, 4) [px], spread regularly over an image [px]."""
    if height < PERSON_HEIGHT or width < PERSON_WIDTH:
        return np.empty((0, 4))
    rows = int(np.ceil(np.sqrt(count * height / width)))
    columns = int(np.ceil(count / rows))
    y, x = np.meshgrid(
        np.linspace(0, height - PERSON_HEIGHT, rows), np.linspace(0, width - PERSON_WIDTH, columns), indexing="ij"
    )
    boxes = np.stack([x.ravel(), y.ravel(), np.full(x.size, PERSON_WIDTH), np.full(x.size, PERSON_HEIGHT)], axis=1)
    return boxes[:count].astype(np.float64)


def collect_negatives(
    files: Sequence[Path],
    model: AcfModel | None,
    wanted: int,
    per_image: int,
    rng: np.random.Generator,
    report: Callable[[float], None],
) -> tuple[Floats, int]:
    """Return background windows' features, (n, 5120), and how many photographs were looked at.

    Without a model the windows lie on a regular grid; with one they are its strongest detections, all of them wrong
    because nobody is in these photographs.
    """
    detector = AcfDetector(model) if model else None
    found: list[Floats] = []
    used = 0
    for index in rng.permutation(len(files)):
        if len(found) >= wanted:
            break
        image = read_picture(files[index])
        boxes = (
            detector.detect(image).boxes[:per_image]
            if detector
            else grid_boxes(image.shape[0], image.shape[1], per_image)
        )
        found.extend(window_features(box_crop(image, box)) for box in boxes)
        used += 1
        report(max(used / len(files), len(found) / wanted))
    return np.array(found[:wanted], np.float32).reshape(-1, WINDOW_VALUES), used
