"""Person detectors as ONNX or Darknet files: FastestDet, YOLOv5, YOLOv8, Yolo-Fastest, told apart by their output."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from han_bullet.detection.network_detector import NetworkDetector, forward, quiet_opencv, reason
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array

# OpenCV does not tell for which input a network was exported; one of a fixed size fails at the others.
SIDES = (640, 352, 416, 320, 512, 1280)  # [px]
CLASSES = 80  # of COCO, the first of which is the person
PERSON = 0


class FastestDet(NetworkDetector):
    """FastestDet: one output, (1, 85, rows, columns): objectness, four box terms, classes."""

    keeps_aspect = False
    red_first = False
    trained_side = 352

    def decode(self, outputs: Sequence[Array]) -> tuple[Array, Array]:
        """Return boxes whose centre lies within a cell of the one that gives them."""
        cells = outputs[0][0]
        rows, columns = np.mgrid[: cells.shape[1], : cells.shape[2]]
        x = (columns + np.tanh(cells[1])) / cells.shape[2]
        y = (rows + np.tanh(cells[2])) / cells.shape[1]
        width, height = (1.0 / (1.0 + np.exp(-cells[term])) for term in (3, 4))
        boxes = self.side * np.stack([x, y, width, height], axis=-1).reshape(-1, 4)
        person = np.where(cells[5:].argmax(axis=0) == PERSON, cells[5 + PERSON], 0.0)
        return boxes, (cells[0] ** 0.6 * person**0.4).reshape(-1)


class YoloV5(NetworkDetector):
    """YOLOv5 as its export writes it: one output, (1, n, 85): box, objectness, classes."""

    def decode(self, outputs: Sequence[Array]) -> tuple[Array, Array]:
        """Return boxes with objectness times person."""
        rows = outputs[0][0]
        return rows[:, :4], rows[:, 4] * _persons(rows[:, 5:])


class YoloV8(NetworkDetector):
    """YOLOv8 as its export writes it: one output, (1, 84, n): box, classes."""

    def decode(self, outputs: Sequence[Array]) -> tuple[Array, Array]:
        """Return boxes with the probability of a person."""
        rows = outputs[0][0].T
        return rows[:, :4], _persons(rows[:, 4:])


class YoloFastest(NetworkDetector):
    """Yolo-Fastest-body in Darknet's format: outputs (n, 6): box as parts of the image, objectness, person."""

    keeps_aspect = False

    def decode(self, outputs: Sequence[Array]) -> tuple[Array, Array]:
        """Return boxes with the product that OpenCV has already made of objectness and person."""
        rows = np.concatenate(outputs)
        return self.side * rows[:, :4], rows[:, 5]


def _persons(classes: Array) -> Array:
    """Return the probability of a person, 0 where another class, (n, 80), is likelier; shape (n,)."""
    likelier: Array = np.where(classes.argmax(axis=1) == PERSON, classes[:, PERSON], 0.0)
    return likelier


def load_onnx(path: Path, threshold: float | None = None) -> NetworkDetector:
    """Read a person detector from an ONNX file.

    Args:
        path: The file.
        threshold: Least probability of a person; None takes the kind's own.

    Raises:
        BadInputError: The file is no ONNX network that OpenCV can run, or its output has an unknown layout.
    """
    try:
        with quiet_opencv():
            network = cv2.dnn.readNetFromONNX(np.frombuffer(path.read_bytes(), np.uint8))
            side, outputs = _probe(network, SIDES)
            kind = kind_of_output([output.shape for output in outputs], str(path))
            if kind is FastestDet:  # an export without a fixed size takes any side
                side, _ = _probe(network, (FastestDet.trained_side, side))
    except cv2.error as error:
        raise BadInputError(f"{path} is not an ONNX detector that OpenCV can run: {reason(error)}") from error
    return kind(network, side, threshold)


def kind_of_output(shapes: Sequence[tuple[int, ...]], name: str) -> type[NetworkDetector]:
    """Tell which detector gives outputs of these shapes.

    Raises:
        BadInputError: None does; the sentence names the file.
    """
    match shapes:
        case [(1, channels, _, _)] if channels == 5 + CLASSES:
            return FastestDet
        case [(1, _, values)] if values == 5 + CLASSES:
            return YoloV5
        case [(1, values, _)] if values == 4 + CLASSES:
            return YoloV8
    raise BadInputError(
        f"{name} gives {', '.join(map(str, shapes))}; (1, 85, rows, columns) of FastestDet, (1, n, 85) of YOLOv5 or "
        "(1, 84, n) of YOLOv8 would be right"
    )


def _probe(network: Any, sides: Sequence[int]) -> tuple[int, list[Array]]:
    """Return the first input side that the network takes, and what it gives for an empty image of that size."""
    for side in sides:
        try:
            return side, forward(network, np.zeros((side, side, 3), np.uint8))
        except cv2.error as error:
            refused = error
    raise refused


def load_darknet(path: Path, threshold: float | None = None) -> NetworkDetector:
    """Read a Yolo-Fastest person detector from Darknet's .cfg file and the .weights file of the same name beside it.

    Raises:
        BadInputError: A file is missing, or they are not such a network.
    """
    weights = path.with_suffix(".weights")
    try:
        network = cv2.dnn.readNetFromDarknet(
            np.frombuffer(path.read_bytes(), np.uint8), np.frombuffer(weights.read_bytes(), np.uint8)
        )
        outputs = forward(network, np.zeros((320, 320, 3), np.uint8))
    except (cv2.error, OSError) as error:
        raise BadInputError(f"{path} with {weights.name} is not a Darknet network that OpenCV can run") from error
    if any(output.ndim != 2 or output.shape[1] != 6 for output in outputs):
        raise BadInputError(f"{path} gives {[o.shape for o in outputs]}; (n, 6) of one class would be right")
    return YoloFastest(network, 320, threshold)
