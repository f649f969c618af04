"""What the pixels of one image tell of the camera that took it."""

from __future__ import annotations

import zlib

import cv2
import numpy as np

from han_bullet.detection.pictures import Image
from han_bullet.messages import ImageHealth

EVERY = 8  # of so many rows and columns one is looked at: enough that noise never repeats, and quick
COARSE = 16  # parts of the image along each side
DECIMALS = 3  # of what goes into files, so that a replay compares the same numbers


def image_health(image: Image, shift: tuple[float, float] = (0.0, 0.0)) -> ImageHealth:
    """Sum up an image, (height, width, 3) RGB, and how far its scene has moved [px]."""
    sample = np.ascontiguousarray(image[::EVERY, ::EVERY])
    parts = cv2.resize(sample, (COARSE, COARSE), interpolation=cv2.INTER_AREA)
    numbers = float(parts.mean()), float(parts.mean(axis=2).std()), *shift
    brightness, contrast, right, down = (round(number, DECIMALS) for number in numbers)
    return ImageHealth(zlib.crc32(sample.data), brightness, contrast, (right, down))
