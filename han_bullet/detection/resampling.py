"""Resampling of channels and planes: area means where they shrink, bilinear where they grow."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.channels import CHANNELS, Floats

NEGLIGIBLE = 1e-3  # share of a pixel below which it does not count towards an area

_ZERO = np.float32(0.0)
_HALF = np.float32(0.5)
Ints = NDArray[np.int32]


def resample(channels: Floats, rows: int, columns: int, band: slice = slice(None)) -> Floats:
    """Resize channels, (h, w, 10), to (rows, columns, 10): area means where they shrink, bilinear where they grow.

    Args:
        channels: What to resize.
        rows: Height of the whole result.
        columns: Width of the result.
        band: Rows of the result to return.
    """
    (first_row, row_weights), horizontal = _resampling(channels.shape[0], rows), _resampling(channels.shape[1], columns)
    return _resample(channels, first_row[band], row_weights[band], *horizontal)


def resample_planes(planes: Floats, rows: int, columns: int) -> Floats:
    """Resize planes, (n, h, w), to (n, rows, columns) in the same way."""
    if planes.shape[1:] == (2 * rows, 2 * columns):
        halved: Floats = _halve_planes(planes)
        return halved
    vertical, horizontal = _resampling(planes.shape[1], rows), _resampling(planes.shape[2], columns)
    return _resample_planes(planes, *vertical, *horizontal)


@numba.njit(cache=True, error_model="numpy")
def _resampling(before: int, after: int) -> tuple[Ints, Floats]:
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
def _halve_planes(planes: Floats) -> Floats:
    """Do for exact halves what `_resample_planes` does, to the bit, in a quarter of its time."""
    result = np.empty((planes.shape[0], planes.shape[1] // 2, planes.shape[2] // 2), np.float32)
    for plane in range(result.shape[0]):
        for row in range(result.shape[1]):
            upper, lower, out = planes[plane, 2 * row], planes[plane, 2 * row + 1], result[plane, row]
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
