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
        levels = np.clip(np.rint(samples), -127, 127)
        # What brightens and what darkens: OpenCV adds and subtracts unsigned numbers four times as fast as signed ones.
        self._brighter, self._darker = np.maximum(levels, 0).astype(np.uint8), np.maximum(-levels, 0).astype(np.uint8)

    def add(self, image: NDArray[np.uint8], camera: int, frame_number: int) -> NDArray[np.uint8]:
        """Return the image, shape (height, width, 3), with the noise of one frame of one camera."""
        generator = np.random.default_rng([self._seed, camera, frame_number])
        start = generator.integers(len(self._brighter) - image.size)
        part = slice(start, start + image.size)
        brighter, darker = self._brighter[part].reshape(image.shape), self._darker[part].reshape(image.shape)
        noisy: NDArray[np.uint8] = cv2.subtract(cv2.add(image, brighter), darker)  # type: ignore[assignment]
        return noisy
