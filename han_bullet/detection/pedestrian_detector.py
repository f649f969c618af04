"""The two stages of pedestrian detection joined: ACF proposes, a CNN decides [Mateus2019]."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from han_bullet.detection.acf import AcfDetector
from han_bullet.detection.detector import Detector
from han_bullet.detection.pictures import Image
from han_bullet.detection.search_area import SearchArea
from han_bullet.errors import BadInputError
from han_bullet.messages import Detections

if TYPE_CHECKING:  # torch costs 0.9 s and 217 MB in every process, so only those that use the CNN import it
    from han_bullet.detection.cnn import Classifier


class PedestrianDetector(Detector):
    """Keeps the proposals with a score of at least the threshold that the CNN calls a pedestrian.

    They keep their ACF score and box.

    Attributes:
        threshold: Least ACF score of a proposal.
    """

    def __init__(self, proposer: AcfDetector, classifier: Classifier | None, threshold: float) -> None:
        """Join the stages.

        Args:
            proposer: The sliding window.
            classifier: The second stage; None keeps every proposal, with probability 1.
            threshold: Least ACF score of a proposal; -inf keeps all.
        """
        if math.isnan(threshold):
            raise BadInputError(f"detector threshold is {threshold}; an ACF score would be right")
        self.threshold = threshold
        self.proposer = proposer
        self.classifier = classifier
        self.smallest_area = proposer.smallest_area

    def detect(self, image: Image) -> Detections:
        """Return the pedestrians in an image, RGB, shape (h, w, 3), uint8, by falling score."""
        return self.decide(image, self.propose(image))

    def propose(self, image: Image, area: SearchArea | None = None) -> Detections:
        """Return ACF's boxes from the threshold on; windows that an area forbids are not looked at."""
        proposals = self.proposer.detect(image, area)
        return proposals.select(proposals.scores >= self.threshold)

    def decide(self, image: Image, proposals: Detections) -> Detections:
        """Return the proposals that the CNN calls pedestrians, with their probability."""
        if self.classifier is None:
            return proposals
        probabilities = self.classifier.probabilities(image, proposals.boxes)  # one batch per image
        judged = replace(proposals, probabilities=probabilities)
        return judged.select(probabilities >= self.classifier.least_probability)
