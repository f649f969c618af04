"""Crops as other cameras, lights and proposals would have given them."""

from __future__ import annotations

import math

import cv2
import numpy as np

from han_bullet.detection.pictures import Image

# Proposals sit less exactly on people than training crops do: half a scale and half a cell of ACF, and more.
ZOOM_DEVIATION = 0.05
SHIFT_DEVIATION = 0.03  # of a side


def augment(crops: Image, size: tuple[int, int], generator: np.random.Generator) -> Image:
    """Change place, size, light, colour, sharpness and noise of crops, each in its own way; mirror half.

    Renderings have flat colours, hard edges and lights unlike photographs', and cameras add noise: none of these may
    matter.

    Args:
        crops: With a margin, shape (n, rows, columns, 3).
        size: Height and width to cut out of them [px].
        generator: Draws everything.

    Returns:
        Shape (n, height, width, 3).
    """
    return np.stack([_augmented(crop, size, generator) for crop in crops])


def centre(crops: Image, size: tuple[int, int]) -> Image:
    """Return the middle of crops with a margin, shape (n, height, width, 3)."""
    top, left = (crops.shape[1] - size[0]) // 2, (crops.shape[2] - size[1]) // 2
    return np.ascontiguousarray(crops[:, top : top + size[0], left : left + size[1]])


def _augmented(crop: Image, size: tuple[int, int], generator: np.random.Generator) -> Image:
    if generator.random() < 0.5:
        crop = crop[:, ::-1]
    crop = _changed_sharpness(_moved(np.ascontiguousarray(crop), size, generator), generator)
    picture = crop.astype(np.float32)
    grey = picture.mean(axis=2, keepdims=True)
    picture = grey + generator.uniform(0.3, 1.3) * (picture - grey)  # saturation
    gain = generator.uniform(0.7, 1.35) * generator.uniform(0.9, 1.1, 3)  # contrast and colour of the light
    picture = (picture - 128.0) * gain + 128.0 + generator.uniform(-30.0, 30.0)
    if generator.random() < 0.4:
        picture = picture + generator.normal(0.0, generator.uniform(0.0, 7.0), picture.shape)
    augmented: Image = np.clip(np.round(picture), 0, 255).astype(np.uint8)
    return augmented


def _moved(crop: Image, size: tuple[int, int], generator: np.random.Generator) -> Image:
    """Cut out a window near the middle, a little larger or smaller than the size."""
    height, width = size
    zoom = math.exp(generator.normal(0.0, ZOOM_DEVIATION))
    x, y = (0.5 * (side - 1) for side in (crop.shape[1], crop.shape[0]))
    x += generator.normal(0.0, SHIFT_DEVIATION * width)
    y += generator.normal(0.0, SHIFT_DEVIATION * height)
    warp = np.array([[zoom, 0.0, 0.5 * (width - 1) - zoom * x], [0.0, zoom, 0.5 * (height - 1) - zoom * y]])
    moved: Image = cv2.warpAffine(crop, warp, (width, height), borderMode=cv2.BORDER_REPLICATE)  # type: ignore[assignment]
    return moved


def _changed_sharpness(crop: Image, generator: np.random.Generator) -> Image:
    choice = generator.random()
    if choice < 0.2:
        return cv2.GaussianBlur(crop, (0, 0), generator.uniform(0.3, 1.1)).astype(np.uint8)
    if choice < 0.3:  # flattens texture and keeps edges, as renderings have them
        return cv2.medianBlur(crop, 3).astype(np.uint8)
    return crop
