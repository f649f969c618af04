"""The fast feature pyramid [Dollar2014]: one real scale per octave, the seven between approximated from it.

A channel of a resampled image is close to the resampled channel times (s / s_real)^-lambda, with one lambda for each
kind of channel.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.channels import CELL, CHANNELS, KIND_OF_CHANNEL, Floats, compute_channels
from han_bullet.detection.colour import luv
from han_bullet.detection.octaves import neighbourhood, plan
from han_bullet.detection.region import Region
from han_bullet.detection.resampling import resample, resample_planes
from han_bullet.detection.scales import LevelSize, level_sizes

PADDING_ROWS, PADDING_COLUMNS = 4, 3  # [cells] around each level, so that people at the border are found

_QUARTER = np.float32(0.25)
_TWO = np.float32(2.0)


@dataclass(frozen=True)
class PyramidSettings:
    """What a classifier asks of the pyramid it is applied to.

    Attributes:
        lambdas: Exponents of the colour, magnitude and orientation channels.
        smallest: Height and width of the smallest object [px]; coarser levels are left out.
        cell: Side of a cell [px].
        padding: Rows above and below and columns beside each level [cells].
        rough: Whether to compute with reciprocals as rough as the original's.
    """

    lambdas: tuple[float, float, float]
    smallest: tuple[int, int]
    cell: int = CELL
    padding: tuple[int, int] = (PADDING_ROWS, PADDING_COLUMNS)
    rough: bool = False


@dataclass(frozen=True)
class Level:
    """One scale of an image.

    Attributes:
        channels: Smoothed and padded, shape (rows, columns, 10), of all the padded level or of a part of it.
        size: Without padding.
        first_row, first_column: Of the padded level [cells] that the channels begin with.
    """

    channels: Floats
    size: LevelSize
    first_row: int = 0
    first_column: int = 0


def build_pyramid(
    image: NDArray[np.uint8], settings: PyramidSettings, needed: Callable[[LevelSize], Region | None] | None = None
) -> list[Level]:
    """Return the levels of an RGB image, (h, w, 3), from fine to coarse.

    Args:
        image: RGB.
        settings: What the levels are to be like.
        needed: Tells which part of a padded level [cells] is looked at; what only others need, and levels without any,
            are left out. None makes everything.
    """
    cell, rough, levels = settings.cell, settings.rough, []
    sizes = level_sizes(image.shape[0], image.shape[1], settings.smallest, cell)
    octaves, given = plan(image.shape[0], image.shape[1], sizes, cell, settings.padding, needed)
    if given is None:
        return []
    planes = luv(image, rough, given)
    for octave in octaves:
        if octave.planes is None:
            continue
        at_scale, made = planes, given
        if given.grid != octave.planes.grid:
            at_scale, made = resample_planes(planes, *octave.planes.grid, octave.planes, given), octave.planes
        if octave.channels is not None:
            cut = neighbourhood(octave.channels, cell)
            source = compute_channels(at_scale, cell, rough, cut.refined(cell).within(made))
            for size, part in octave.levels.items():
                gains = _gains(size.scale / octave.real.scale, settings)
                levels.append(_approximate(source, cut, size, part, gains, settings.padding))
        if octave.real.scale == 0.5:  # the coarser octaves start from the half image
            planes, given = at_scale, made
    return levels


@functools.lru_cache(maxsize=256)  # a camera's images all have one size
def _gains(relative: float, settings: PyramidSettings) -> Floats:
    """Return by what channels at a scale relative to the real one differ from it; nobody may write to it."""
    exponents = np.asarray(settings.lambdas)[KIND_OF_CHANNEL]
    gains: Floats = (relative**-exponents).astype(np.float32)
    return gains


def _approximate(
    source: Floats, given: Region, size: LevelSize, wanted: Region, gains: Floats, padding: tuple[int, int]
) -> Level:
    """Resample real channels, of which a part is given, to a level's size, and smooth and pad a part of that."""
    if given.grid == wanted.grid:
        channels = np.ascontiguousarray(source[wanted.within(given)])
    else:
        channels = resample(source, size.rows, size.columns, wanted, given)
    return Level(smooth_and_pad(channels, gains, *padding), size, wanted.rows.start, wanted.columns.start)


def smooth(channels: Floats) -> Floats:
    """Smooth channels, (h, w, 10), with [1 2 1] / 4 along both axes, border cells repeated outward."""
    smoothed: Floats = smooth_and_pad(channels, np.ones(CHANNELS, np.float32), 0, 0)
    return smoothed


@numba.njit(cache=True, error_model="numpy")
def smooth_and_pad(channels: Floats, gains: Floats, padding_rows: int, padding_columns: int) -> Floats:
    """Scale each channel by its gain, smooth with [1 2 1] / 4 along both axes and pad by so many cells on each side.

    Colour is repeated outward; the gradient channels are zero outside the image.
    """
    rows, columns = channels.shape[:2]
    padded = np.zeros((rows + 2 * padding_rows, columns + 2 * padding_columns, CHANNELS), np.float32)
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
        out = padded[row + padding_rows].reshape(-1)[padding_columns * CHANNELS :]
        for place in range(span):
            out[place] = line[place] + _TWO * line[place + CHANNELS] + line[place + 2 * CHANNELS]
        _repeat_colour_sideways(padded[row + padding_rows], padding_columns)
    for row in range(padding_rows):
        padded[row, :, :3] = padded[padding_rows, :, :3]
        padded[rows + padding_rows + row, :, :3] = padded[rows + padding_rows - 1, :, :3]
    return padded


@numba.njit(cache=True)
def _repeat_colour_sideways(line: Floats, padding_columns: int) -> None:
    """Copy the colour of a padded row's first and last image cell into the padding."""
    for column in range(padding_columns):
        line[column, :3] = line[padding_columns, :3]
        line[-1 - column, :3] = line[-1 - padding_columns, :3]
