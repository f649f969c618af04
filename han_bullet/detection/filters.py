"""Locally decorrelated channels [Nam2014]: each channel through each filter, then halved."""

from __future__ import annotations

import cv2
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
    rows, columns, count = channels.shape
    planes = np.empty((len(filters) * count, rows, columns), np.float32)
    turned = np.ascontiguousarray(filters[:, ::-1, ::-1].transpose(0, 3, 1, 2))  # OpenCV correlates
    for channel in range(count):
        plane = np.ascontiguousarray(channels[:, :, channel])
        for which in range(len(filters)):
            target = planes[which * count + channel]
            cv2.filter2D(plane, -1, turned[which, channel], dst=target, borderType=cv2.BORDER_CONSTANT)
    return np.ascontiguousarray(resample_planes(planes, halved(rows), halved(columns)).transpose(1, 2, 0))
