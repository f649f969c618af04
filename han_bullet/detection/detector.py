"""The stages of pedestrian detection in one place: ACF proposals, threshold, empty-scene mask, CNN."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from han_bullet.detection.acf import AcfDetector, load_acf_model
from han_bullet.detection.model_files import DEFAULT
from han_bullet.detection.still_scene import StillScene
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array
from han_bullet.messages import Detections, Frame

if TYPE_CHECKING:  # torch costs 0.9 s and 217 MB in every process, so only those that use the CNN import it
    from han_bullet.detection.cnn import Classifier


class Detector(ABC):
    """Something that finds pedestrians in images."""

    @abstractmethod
    def detect(self, frames: Sequence[Frame]) -> list[Detections]:
        """Return the pedestrians in each frame, in the order of the frames."""


class PedestrianDetector(Detector):
    """ACF proposes, a CNN decides [Mateus2019].

    Per frame: proposals with a score of at least the threshold; of a calibrated fixed camera, those where something
    differs from the empty scene; of these, those that the CNN calls a pedestrian. They keep their ACF score and box.

    Attributes:
        threshold: Least ACF score of a proposal.
    """

    def __init__(self, proposer: AcfDetector, classifier: Classifier | None, threshold: float) -> None:
        """Join the stages.

        Args:
            proposer: The sliding window.
            classifier: The second stage; None keeps every proposal, with probability 1.
            threshold: Least ACF score of a proposal.
        """
        if not np.isfinite(threshold):
            raise BadInputError(f"detector threshold is {threshold}; a finite ACF score would be right")
        self.threshold = threshold
        self.proposer = proposer
        self.classifier = classifier
        self._scenes: dict[str, StillScene] = {}

    def calibrate(self, frames: Sequence[Frame]) -> None:
        """Learn the empty scene of fixed cameras.

        Args:
            frames: One person-free frame per camera; a second one of the same camera replaces the first.

        Raises:
            BadInputError: A frame is of a camera that moves.
        """
        for frame in frames:
            if not frame.fixed:
                raise BadInputError(f"camera {frame.camera!r} moves and has no empty scene; calibrate fixed ones")
            self._scenes[frame.camera] = StillScene(frame.image, self._propose(frame)[0])

    def detect(self, frames: Sequence[Frame]) -> list[Detections]:
        """Return the pedestrians in each frame, in the order of the frames, the highest score first."""
        return [self._detect(frame) for frame in frames]

    def _detect(self, frame: Frame) -> Detections:
        scene = self._scenes.get(frame.camera) if frame.fixed else None
        if scene is not None and not scene.may_hold(frame.image, self.proposer.model.smallest_box_area):
            return Detections(frame.camera, frame.time, np.zeros((0, 4)), np.zeros(0), np.zeros(0))
        boxes, scores = self._propose(frame)
        if scene is not None:
            kept = scene.keep(frame.image, boxes)
            boxes, scores = boxes[kept], scores[kept]
        probabilities: Array = np.ones(len(boxes))
        if self.classifier is not None:
            probabilities = self.classifier.probabilities(frame.image, boxes)  # one batch per frame
            kept = probabilities >= self.classifier.least_probability
            boxes, scores, probabilities = boxes[kept], scores[kept], probabilities[kept]
        return Detections(frame.camera, frame.time, boxes, scores, probabilities)

    def _propose(self, frame: Frame) -> tuple[Array, Array]:
        boxes, scores = self.proposer.detect(frame.image)
        kept = scores >= self.threshold
        return boxes[kept], scores[kept]


def load_detector(
    name_or_path: str | Path = DEFAULT, threshold: float | None = None, classifier: bool = True
) -> PedestrianDetector:
    """Build a detector from shipped models.

    Args:
        name_or_path: ACF model as `load_acf_model` takes it: "default", the name of a shipped one, or a file.
        threshold: Least ACF score; None takes the model's own.
        classifier: Whether the CNN decides about the proposals.

    Raises:
        BadInputError: No such model, it is not one, or no threshold is given and it has none.
    """
    model = load_acf_model(name_or_path)
    if threshold is None:
        threshold = model.score_threshold
        if not math.isfinite(threshold):
            raise BadInputError(
                f"model {str(name_or_path)!r} has no score threshold; give --threshold or choose one with "
                "`han-bullet evaluate --choose-threshold`"
            )
    network = None
    if classifier:
        from han_bullet.detection.cnn import load_classifier

        network = load_classifier()
    return PedestrianDetector(AcfDetector(model), network, threshold)
