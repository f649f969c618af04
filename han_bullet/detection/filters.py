"""Locally decorrelated channels [Nam2014]: each channel through each filter, then halved."""

from __future__ import annotations

import numba
import numpy as np

from han_bullet.detection.channels import Floats
from han_bullet.detection.resampling import resample_planes

HALVING = 2  # filtered channels are as many cells apart


def halved(cells: int) -> int:
    """Return how many rows or columns remain of so many, halves upward."""
    return (cells + 1) // HALVING


def filter_channels(channels: Floats, filters: Floats) -> Floats:
    """Return channels convolved with filters and halved.

    The convolution is the mathematical one, with the filter turned by half a turn; beyond the border is zero.

    Args:
        channels: Smoothed and padded, shape (rows, columns, 10).
        filters: Shape (n, height, width, 10), height and width odd.

    Returns:
        Shape (rows / 2, columns / 2, 10 n), the first filter's ten channels first.
    """
    rows, columns = channels.shape[:2]
    planes = resample_planes(_convolve(channels, filters), halved(rows), halved(columns))
    return np.ascontiguousarray(planes.transpose(1, 2, 0))


@numba.njit(cache=True, error_model="numpy")
def _convolve(channels: Floats, filters: Floats) -> Floats:
    """Return the convolved planes, (10 n, rows, columns)."""
    rows, columns, count = channels.shape
    number, height, width = filters.shape[:3]
    above, before = height // 2, width // 2
    planes = np.zeros((number * count, rows, columns), np.float32)
    framed = np.zeros((rows + height - 1, columns + width - 1), np.float32)
    for channel in range(count):
        framed[above : above + rows, before : before + columns] = channels[:, :, channel]
        for which in range(number):
            plane = planes[which * count + channel]
            for row in range(rows):
                out = plane[row]
                for down in range(height):
                    line = framed[row + down]
                    for across in range(width):
                        weight = filters[which, height - 1 - down, width - 1 - across, channel]
                        for place in range(columns):
                            out[place] += weight * line[place + across]
    return planes
