"""OpenCV's people detector on histograms of oriented gradients [Dalal2005], to measure others against."""

from __future__ import annotations

import cv2
import numpy as np

from han_bullet.detection.detector import Detector
from han_bullet.detection.matching import ASPECT
from han_bullet.detection.nms import suppress
from han_bullet.detection.pictures import Image, check_rgb
from han_bullet.errors import BadInputError
from han_bullet.messages import Detections

PERSON_IN_WINDOW = 96 / 128  # height of the person in the window, in whose centre they are
STRIDE, PADDING, SCALE = (8, 8), (16, 16), 1.05


class HogDetector(Detector):
    """Slides a window of 64 x 128 px over the image at many scales; the score is the distance to the SVM's plane.

    Args:
        threshold: Least score; lower it to draw a curve.
    """

    def __init__(self, threshold: float = 0.0) -> None:
        if not np.isfinite(threshold):
            raise BadInputError(f"detector threshold is {threshold}; a finite score would be right")
        self.threshold = threshold
        self._hog = cv2.HOGDescriptor()
        self._hog.setSVMDetector(np.array(cv2.HOGDescriptor.getDefaultPeopleDetector()))

    def detect(self, image: Image) -> Detections:
        """Return the people in an image, RGB, shape (h, w, 3), uint8, by falling score; boxes without the margin."""
        check_rgb(image)
        width, height = self._hog.winSize
        if image.shape[0] + 2 * PADDING[1] < height or image.shape[1] + 2 * PADDING[0] < width:
            return Detections.none()
        windows, weights = self._hog.detectMultiScale(
            np.ascontiguousarray(image[:, :, ::-1]),
            hitThreshold=self.threshold,
            winStride=STRIDE,
            padding=PADDING,
            scale=SCALE,
            groupThreshold=0,
        )
        found = np.asarray(windows, float).reshape(-1, 4)
        scores = np.asarray(weights, float).reshape(-1)
        tall = PERSON_IN_WINDOW * found[:, 3]
        middle = found[:, :2] + 0.5 * found[:, 2:]
        boxes = np.column_stack([middle[:, 0] - 0.5 * ASPECT * tall, middle[:, 1] - 0.5 * tall, ASPECT * tall, tall])
        kept = suppress(boxes, scores)
        return Detections(boxes[kept], scores[kept], np.ones(len(kept)))
