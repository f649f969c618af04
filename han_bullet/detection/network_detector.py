"""Person detectors of one pass of a network, run by OpenCV: the steps that all of them share."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.detector import Detector
from han_bullet.detection.nms import suppress
from han_bullet.detection.pictures import Image, check_rgb
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array
from han_bullet.messages import Detections

GREY = (114, 114, 114)  # what the YOLO family pads with


class NetworkDetector(Detector):
    """Fits an image into a square, asks a network, and keeps the persons; a subclass knows the network's output.

    The score of a box is the network's own probability of a person, and is given as both.

    Attributes:
        threshold: Least probability of a person.
        side: Of the network's square input [px].
        keeps_aspect: Whether the image is padded to a square; if not, it is stretched.
        red_first: Whether the network takes RGB; if not, BGR.
    """

    default_threshold = 0.5
    keeps_aspect = True
    red_first = True

    def __init__(self, network: Any, side: int, threshold: float | None = None) -> None:
        """Take a network that OpenCV has read; no threshold takes the default of the kind."""
        self.threshold = self.default_threshold if threshold is None else threshold
        if not (math.isfinite(self.threshold) and 0.0 <= self.threshold <= 1.0):
            raise BadInputError(f"detector threshold is {threshold}; a probability from 0 to 1 would be right")
        self.side = side
        self._network = network

    @abstractmethod
    def decode(self, outputs: Sequence[Array]) -> tuple[Array, Array]:
        """Return every box, (n, 4): centre x, y, width, height [px of the input], and its probability, (n,)."""

    def detect(self, image: Image) -> Detections:
        """Return the persons in an image, RGB, shape (h, w, 3), uint8, by falling probability.

        Raises:
            BadInputError: It is no such image, or OpenCV cannot run the network.
        """
        check_rgb(image)
        if image.size == 0:
            return Detections.none()
        square, scale, shift = self._fit(image)
        try:
            with quiet_opencv():
                outputs = forward(self._network, square, self.red_first)
        except cv2.error as error:
            raise BadInputError(
                f"OpenCV cannot run the network at {self.side} x {self.side} px: {reason(error)}"
            ) from error
        boxes, scores = self.decode(outputs)
        kept = (scores >= self.threshold) & np.isfinite(scores) & np.isfinite(boxes).all(axis=1)
        boxes, scores = boxes[kept].astype(float), scores[kept].astype(float)
        corners = boxes[:, :2] - 0.5 * boxes[:, 2:]
        boxes = np.column_stack([(corners - shift) / scale, boxes[:, 2:] / scale])
        there = _meet(boxes, image)
        boxes, scores = boxes[there], scores[there]
        return Detections(boxes, scores, scores).select(suppress(boxes, scores))

    def _fit(self, image: Image) -> tuple[Image, Array, Array]:
        """Return the square image, the factors of x and y, and where the image begins in it [px]."""
        full = np.array(image.shape[1::-1], float)
        size = np.full(2, self.side)
        if self.keeps_aspect:
            size = np.maximum(np.rint(full * self.side / full.max()), 1).astype(int)
        resized = cv2.resize(image, (int(size[0]), int(size[1])), interpolation=cv2.INTER_LINEAR)
        left, top = (self.side - size) // 2
        right, bottom = self.side - size - (left, top)
        square = cv2.copyMakeBorder(
            resized, int(top), int(bottom), int(left), int(right), cv2.BORDER_CONSTANT, value=GREY
        )
        return np.asarray(square, np.uint8), size / full, np.array([left, top], float)


def _meet(boxes: Array, image: Image) -> NDArray[np.bool_]:
    """Tell which boxes, (n, 4), have an area and share some of it with the image; a network may give any numbers."""
    near, size = boxes[:, :2], boxes[:, 2:]
    inside: NDArray[np.bool_] = (size > 0.0) & (near + size > 0.0) & (near < image.shape[1::-1])
    return np.asarray(inside.all(axis=1), np.bool_)


def forward(network: Any, square: Image, red_first: bool = True) -> list[Array]:
    """Return every output of a network for a square RGB image, whose values it takes from 0 to 1."""
    network.setInput(cv2.dnn.blobFromImage(square, 1.0 / 255.0, swapRB=not red_first))
    return list(network.forward(network.getUnconnectedOutLayersNames()))


@contextmanager
def quiet_opencv() -> Iterator[None]:
    """Keep OpenCV from printing pages about an error that it raises anyway."""
    level = cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        yield
    finally:
        cv2.utils.logging.setLogLevel(level)


def reason(error: cv2.error) -> str:
    """Return what OpenCV complains about, in one line."""
    return " ".join(str(error.err or error).split())[:160]
