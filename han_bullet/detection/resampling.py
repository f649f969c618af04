"""Resampling of channels and planes: area means where they shrink, bilinear where they grow."""

from __future__ import annotations

import functools

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.channels import CHANNELS, Floats
from han_bullet.detection.region import Region

NEGLIGIBLE = 1e-3  # share of a pixel below which it does not count towards an area

_ZERO = np.float32(0.0)
_HALF = np.float32(0.5)
Ints = NDArray[np.int32]


def resample(
    channels: Floats, rows: int, columns: int, wanted: Region | None = None, given: Region | None = None
) -> Floats:
    """Resize channels, (h, w, 10), to (rows, columns, 10): area means where they shrink, bilinear where they grow.

    Args:
        channels: What to resize.
        rows: Height of the whole result.
        columns: Width of the whole result.
        wanted: Part of the result to return; None returns all.
        given: Part of the whole source that the channels are, with all that `sources` asks for; None if they are all.
    """
    given = given or Region.all_of(*channels.shape[:2])
    vertical, horizontal = _both_axes(given, wanted or Region.all_of(rows, columns))
    return _resample(channels, *vertical, *horizontal)


def resample_planes(
    planes: Floats, rows: int, columns: int, wanted: Region | None = None, given: Region | None = None
) -> Floats:
    """Resize planes, (n, h, w), to (n, rows, columns) in the same way."""
    given, wanted = given or Region.all_of(*planes.shape[1:]), wanted or Region.all_of(rows, columns)
    if given.grid == (2 * rows, 2 * columns):
        start = (2 * wanted.rows.start - given.rows.start, 2 * wanted.columns.start - given.columns.start)
        halved: Floats = _halve_planes(planes, *start, len(wanted.rows), len(wanted.columns))
        return halved
    vertical, horizontal = _both_axes(given, wanted)
    return _resample_planes(planes, *vertical, *horizontal)


def sources(wanted: Region, rows: int, columns: int) -> Region:
    """Return the part of a grid of so many rows and columns from which a part of the resampled one is made."""
    vertical = _sources(rows, wanted.grid[0], wanted.rows)
    return Region(vertical, _sources(columns, wanted.grid[1], wanted.columns), (rows, columns))


def _sources(before: int, after: int, wanted: range) -> range:
    """Return the inputs of some outputs of one axis."""
    if before == after:
        return wanted
    first, weights = _resampling(before, after)
    return range(int(first[wanted[0]]), min(int(first[wanted[-1]]) + weights.shape[1], before))


def _both_axes(given: Region, wanted: Region) -> tuple[tuple[Ints, Floats], tuple[Ints, Floats]]:
    """Return for both axes what `_resampling` does, but of some outputs, and counted from the first input given."""
    vertical = _some(given.grid[0], wanted.grid[0], given.rows, wanted.rows)
    return vertical, _some(given.grid[1], wanted.grid[1], given.columns, wanted.columns)


def _some(before: int, after: int, given: range, wanted: range) -> tuple[Ints, Floats]:
    first, weights = _resampling(before, after)
    return first[wanted.start : wanted.stop] - np.int32(given.start), weights[wanted.start : wanted.stop]


@functools.lru_cache(maxsize=512)  # a camera's images all have one size
def _resampling(before: int, after: int) -> tuple[Ints, Floats]:
    """Return the same for each pair of sizes; nobody may write to it."""
    first, weights = _make_resampling(before, after)
    return first, weights


@numba.njit(cache=True, error_model="numpy")
def _make_resampling(before: int, after: int) -> tuple[Ints, Floats]:
    """Return, for one axis, each output's first input, (after,), and the weights of the inputs from there, (after, n).

    Inputs past the end have weight zero.
    """
    ratio = before / after
    taps = int(np.ceil(ratio)) + 1 if ratio > 1.0 else 2
    first = np.zeros(after, np.int32)
    weights = np.zeros((after, taps), np.float32)
    for output in range(after):
        if ratio > 1.0:
            start, end = output * ratio, (output + 1) * ratio
            first[output] = min(int(start + NEGLIGIBLE), before - 1)
            total = 0.0
            for tap in range(taps):
                place = first[output] + tap
                share = min(place + 1.0, end, before) - max(float(place), start)
                if share > NEGLIGIBLE:
                    weights[output, tap] = share
                    total += share
            weights[output] /= np.float32(total)
        else:
            centre = min(max((output + 0.5) * ratio - 0.5, 0.0), before - 1.0)
            first[output] = int(centre)
            weights[output, 1] = centre - first[output]
            weights[output, 0] = np.float32(1.0) - weights[output, 1]
    return first, weights


@numba.njit(cache=True, error_model="numpy")
def _resample(
    values: Floats, first_row: Ints, row_weights: Floats, first_column: Ints, column_weights: Floats
) -> Floats:
    """Apply the weights of both axes to an array laid out (row, column, channel)."""
    rows, columns = first_row.size, first_column.size
    result = np.empty((rows, columns, CHANNELS), np.float32)
    flat = values.reshape(values.shape[0], values.shape[1] * CHANNELS)
    line = np.empty(flat.shape[1], np.float32)
    for row in range(rows):
        _weigh_rows(flat, first_row[row], row_weights[row], line)
        for column in range(columns):
            start = first_column[column] * CHANNELS
            cell = result[row, column]
            for channel in range(CHANNELS):
                cell[channel] = column_weights[column, 0] * line[start + channel]
            for tap in range(1, column_weights.shape[1]):
                weight = column_weights[column, tap]
                if weight > _ZERO:
                    for channel in range(CHANNELS):
                        cell[channel] += weight * line[start + tap * CHANNELS + channel]
    return result


@numba.njit(cache=True, error_model="numpy")
def _resample_planes(
    planes: Floats, first_row: Ints, row_weights: Floats, first_column: Ints, column_weights: Floats
) -> Floats:
    """Apply the weights of both axes to planes."""
    rows, columns = first_row.size, first_column.size
    result = np.empty((planes.shape[0], rows, columns), np.float32)
    line = np.empty(planes.shape[2], np.float32)
    for plane in range(planes.shape[0]):
        for row in range(rows):
            _weigh_rows(planes[plane], first_row[row], row_weights[row], line)
            for column in range(columns):
                value = _ZERO
                for tap in range(column_weights.shape[1]):
                    weight = column_weights[column, tap]
                    if weight > _ZERO:
                        value += weight * line[first_column[column] + tap]
                result[plane, row, column] = value
    return result


@numba.njit(cache=True, error_model="numpy")
def _halve_planes(planes: Floats, first_row: int, first_column: int, rows: int, columns: int) -> Floats:
    """Do for exact halves what `_resample_planes` does, to the bit, in a quarter of its time.

    It begins at a row and a column of the planes.
    """
    result = np.empty((planes.shape[0], rows, columns), np.float32)
    for plane in range(result.shape[0]):
        for row in range(result.shape[1]):
            upper = planes[plane, first_row + 2 * row, first_column:]
            lower = planes[plane, first_row + 2 * row + 1, first_column:]
            out = result[plane, row]
            for column in range(out.size):
                left = _HALF * upper[2 * column] + _HALF * lower[2 * column]
                right = _HALF * upper[2 * column + 1] + _HALF * lower[2 * column + 1]
                out[column] = _HALF * left + _HALF * right
    return result


@numba.njit(cache=True, error_model="numpy")
def _weigh_rows(lines: Floats, first: int, weights: Floats, out: Floats) -> None:
    """Write the weighted sum of the rows from `first` on."""
    for place in range(out.size):
        out[place] = weights[0] * lines[first, place]
    for tap in range(1, weights.size):
        if weights[tap] > _ZERO:
            for place in range(out.size):
                out[place] += weights[tap] * lines[first + tap, place]
