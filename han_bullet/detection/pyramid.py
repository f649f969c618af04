"""The fast feature pyramid [Dollar2014]: one real scale per octave, the seven between approximated from it.

A channel of a resampled image is close to the resampled channel times (s / s_real)^-lambda, with one lambda for each
kind of channel.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.channels import CELL, CHANNELS, KIND_OF_CHANNEL, Floats, compute_channels, luv
from han_bullet.detection.resampling import resample, resample_planes
from han_bullet.geometry import Array

SCALES_PER_OCTAVE = 8
PADDING_ROWS, PADDING_COLUMNS = 4, 3  # [cells] around each level, so that people at the border are found
SCALE_TRIALS = 100  # candidates near each scale, of which the one that fits both sides best is taken

_QUARTER = np.float32(0.25)
_TWO = np.float32(2.0)


@dataclass(frozen=True)
class Level:
    """One scale of an image.

    Attributes:
        channels: Smoothed and padded, shape (rows, columns, 10).
        scale: Size relative to the image.
        scale_x, scale_y: The same along each side, whose lengths are rounded to whole cells.
    """

    channels: Floats
    scale: float
    scale_x: float
    scale_y: float


def pyramid_scales(height: int, width: int, smallest_height: int, smallest_width: int) -> list[float]:
    """Return the falling scales at which an image [px] is at least as large as the smallest object [px].

    Near each power 2^(-i/8) the scale is taken whose rounding to whole cells distorts the two sides least.
    """
    room = min(height / smallest_height, width / smallest_width)
    if room < 1.0:
        return []
    count = math.floor(SCALES_PER_OCTAVE * math.log2(room) + 1)
    shorter, longer = min(height, width), max(height, width)
    scales: list[float] = []
    for number in range(count):
        length = round_to_cells(shorter * 2.0 ** (-number / SCALES_PER_OCTAVE)) * CELL
        low, high = (length - CELL / 4) / shorter, (length + CELL / 4) / shorter
        trials = low + np.arange(SCALE_TRIALS) / SCALE_TRIALS * (high - low)
        errors = np.maximum(_distance_to_cells(shorter * trials), _distance_to_cells(longer * trials))
        scale = float(trials[np.argmin(errors)])
        if not scales or scale != scales[-1]:
            scales.append(scale)
    return scales


def round_to_cells(length: float) -> int:
    """Return a length [px] in whole cells, halves upward."""
    return math.floor(length / CELL + 0.5)


def _distance_to_cells(lengths: Array) -> Array:
    """Return how far lengths [px] are from a whole number of cells [px]."""
    distances: Array = np.abs(lengths - np.floor(lengths / CELL + 0.5) * CELL)
    return distances


def build_pyramid(image: NDArray[np.uint8], lambdas: Sequence[float], smallest: tuple[int, int]) -> list[Level]:
    """Return the levels of an RGB image, (h, w, 3), from fine to coarse.

    Args:
        image: RGB.
        lambdas: Exponents of the colour, magnitude and orientation channels.
        smallest: Height and width of the smallest object [px]; coarser levels are left out.
    """
    height, width = image.shape[:2]
    scales = pyramid_scales(height, width, *smallest)
    exponents = np.asarray(lambdas)[KIND_OF_CHANNEL]
    planes = luv(image)
    levels = []
    for real, members in _octaves(len(scales)):
        source, planes = _real_channels(planes, scales[real], height, width)
        for number in members:
            gains = ((scales[number] / scales[real]) ** -exponents).astype(np.float32)
            levels.append(_make_level(source, scales[number], gains, height, width))
    return levels


def _octaves(count: int) -> list[tuple[int, range]]:
    """Return each real scale's number with the numbers of the scales nearest to it."""
    reals = list(range(0, count, SCALES_PER_OCTAVE))
    # Counted from one, as the original does, the scales are parted at the floor of the midpoint between two real ones.
    ends = [(a + b + 2) // 2 for a, b in itertools.pairwise(reals)] + [count]
    return [(real, range(start, end)) for real, start, end in zip(reals, [0, *ends], ends, strict=False)]


def _real_channels(planes: Floats, scale: float, height: int, width: int) -> tuple[Floats, Floats]:
    """Return the channels at a scale of the whole image, and the planes from which the next octave may start."""
    rows, columns = round_to_cells(height * scale) * CELL, round_to_cells(width * scale) * CELL
    if planes.shape[1:] == (rows, columns):
        return compute_channels(planes), planes
    resampled = resample_planes(planes, rows, columns)
    return compute_channels(resampled), resampled if scale == 0.5 else planes


def _make_level(source: Floats, scale: float, gains: Floats, height: int, width: int) -> Level:
    """Resample real channels to a scale of the image, (height, width) [px], and smooth and pad them."""
    rows, columns = round_to_cells(height * scale), round_to_cells(width * scale)
    same = source.shape[:2] == (rows, columns)
    channels = source if same else resample(source, rows, columns)
    return Level(smooth_and_pad(channels, gains), scale, columns * CELL / width, rows * CELL / height)


def smooth(channels: Floats) -> Floats:
    """Smooth channels, (h, w, 10), with [1 2 1] / 4 along both axes, border cells repeated outward."""
    padded = smooth_and_pad(channels, np.ones(CHANNELS, np.float32))
    return padded[PADDING_ROWS:-PADDING_ROWS, PADDING_COLUMNS:-PADDING_COLUMNS]


@numba.njit(cache=True, error_model="numpy")
def smooth_and_pad(channels: Floats, gains: Floats) -> Floats:
    """Scale each channel by its gain, smooth with [1 2 1] / 4 along both axes and pad.

    Colour is repeated outward; the gradient channels are zero outside the image.
    """
    rows, columns = channels.shape[:2]
    padded = np.zeros((rows + 2 * PADDING_ROWS, columns + 2 * PADDING_COLUMNS, CHANNELS), np.float32)
    span = columns * CHANNELS
    flat = channels.reshape(rows, span)
    weights = np.empty(span, np.float32)
    for place in range(span):
        weights[place] = gains[place % CHANNELS] * _QUARTER * _QUARTER
    line = np.empty(span + 2 * CHANNELS, np.float32)
    for row in range(rows):
        above, here, below = flat[max(row - 1, 0)], flat[row], flat[min(row + 1, rows - 1)]
        for place in range(span):
            line[CHANNELS + place] = (above[place] + _TWO * here[place] + below[place]) * weights[place]
        line[:CHANNELS] = line[CHANNELS : 2 * CHANNELS]
        line[-CHANNELS:] = line[-2 * CHANNELS : -CHANNELS]
        out = padded[row + PADDING_ROWS].reshape(-1)[PADDING_COLUMNS * CHANNELS :]
        for place in range(span):
            out[place] = line[place] + _TWO * line[place + CHANNELS] + line[place + 2 * CHANNELS]
        _repeat_colour_sideways(padded[row + PADDING_ROWS])
    for row in range(PADDING_ROWS):
        padded[row, :, :3] = padded[PADDING_ROWS, :, :3]
        padded[rows + PADDING_ROWS + row, :, :3] = padded[rows + PADDING_ROWS - 1, :, :3]
    return padded


@numba.njit(cache=True)
def _repeat_colour_sideways(line: Floats) -> None:
    """Copy the colour of a padded row's first and last image cell into the padding."""
    for column in range(PADDING_COLUMNS):
        line[column, :3] = line[PADDING_COLUMNS, :3]
        line[-1 - column, :3] = line[-1 - PADDING_COLUMNS, :3]
