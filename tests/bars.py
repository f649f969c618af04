"""Bright upright bars on dark ground, a model that finds them and a network that tells their colours apart."""

import math
from pathlib import Path

import numpy as np
import torch

from han_bullet.detection.acf import AcfDetector
from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.cnn import Classifier
from han_bullet.detection.network import CropNetwork
from han_bullet.detection.pedestrian_detector import PedestrianDetector
from han_bullet.geometry import Intrinsics
from han_bullet.messages import Detections, Frame

INTRINSICS = Intrinsics.from_vertical_field_of_view(320, 240, math.radians(45.0))


def bar_model() -> AcfModel:
    """Return a hand-made model that finds bright upright bars on dark ground.

    Each of ten trees adds 5 where the middle of the window is bright and the margin beside, above or below it dark, and
    takes 10 away elsewhere. L is the first channel; bright is L > 0.2 of at most 0.37, dark L < 0.1.
    """
    places = [(16, 8), (6, 8), (26, 8), (11, 8), (21, 8)]
    margins = [(16, 2), (16, 13), (1, 8), (30, 8), (8, 2)]
    pairs = [(place, margins[i]) for i, place in enumerate(places)] + list(zip(places, margins[::-1], strict=True))
    index = np.array([[(row * 16 + column) * 10 for row, column in pair] for pair in pairs])
    features = np.stack([index[:, 0], index[:, 1], index[:, 1]], axis=1).astype(np.int32)
    thresholds = np.tile(np.float32([0.2, 0.1, 0.1]), (len(pairs), 1))
    leaves = np.tile(np.float32([-10.0, -10.0, 5.0, -10.0]), (len(pairs), 1))
    return AcfModel(features, thresholds, leaves, lambdas=(0.0, 0.1, 0.1))


class RedNetwork(CropNetwork):
    """A network whose logit for pedestrian is how much redder than blue the middle of the crop is."""

    def __init__(self) -> None:
        super().__init__(64, 64, {})

    def start(self, weights: Path | None, deviation: float = 0.01) -> None:
        """Do nothing: it has no weights."""

    def forward(self, crops: torch.Tensor) -> torch.Tensor:
        middle = crops[:, :, 28:36, 28:36].mean(dim=(2, 3))
        redness = (middle[:, 0] - middle[:, 2]) / 20.0
        return torch.stack([torch.zeros_like(redness), redness], dim=1)


def image(*bars: tuple[int, tuple[int, int, int]]) -> np.ndarray:
    """Return a dark image with upright bars, 24 x 92 px, at these left edges [px] and of these colours."""
    picture = np.full((240, 320, 3), 10, np.uint8)
    for left, colour in bars:
        picture[70:162, left : left + 24] = colour
    return picture


def frame(*bars: tuple[int, tuple[int, int, int]], camera: str = "a", time: float = 0.0, fixed: bool = True) -> Frame:
    """Return a frame of the same."""
    return Frame(camera, time, image(*bars), INTRINSICS, np.eye(4), fixed)


RED, BLUE, WHITE = (255, 200, 150), (150, 200, 255), (240, 240, 240)


def detector(classifier: Classifier | None = None, threshold: float = 20.0) -> PedestrianDetector:
    """Return a detector of bars."""
    return PedestrianDetector(AcfDetector(bar_model()), classifier, threshold)


def found_at(detections: Detections) -> list[int]:
    """Return the centres of the boxes, left to right, rounded to 12 px, without repeats."""
    centres = detections.boxes[:, 0] + 0.5 * detections.boxes[:, 2]
    return sorted({round(float(centre) / 12.0) * 12 for centre in centres})
