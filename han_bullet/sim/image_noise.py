"""Noise of an image sensor, made in advance so that a frame costs a millisecond."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

BANK_FRAMES = 5  # images' worth of samples: two frames practically never start at the same one of millions


class ImageNoise:
    """Independent Gaussian noise on every value of every image.

    A frame takes a stretch of one long row of samples from a place that its numbers draw, so that its noise depends on
    them alone, never on what was rendered before or where.
    """

    def __init__(self, standard_deviation: float, seed: int, largest_image: int) -> None:
        """Draw the samples.

        Args:
            standard_deviation: [grey levels].
            seed: The same seed gives the same noise.
            largest_image: Number of values in the largest image.
        """
        self._seed = seed
        count = BANK_FRAMES * largest_image
        samples = np.random.default_rng(seed).standard_normal(count, dtype=np.float32) * standard_deviation
        self._samples = np.clip(np.rint(samples), -127, 127).astype(np.int8)

    def add(self, image: NDArray[np.uint8], camera: int, frame_number: int) -> NDArray[np.uint8]:
        """Return the image, shape (height, width, 3), with the noise of one frame of one camera."""
        generator = np.random.default_rng([self._seed, camera, frame_number])
        start = generator.integers(len(self._samples) - image.size)
        noise = self._samples[start : start + image.size].reshape(image.shape)
        return cv2.add(image, noise, dtype=cv2.CV_8U).astype(np.uint8, copy=False)
