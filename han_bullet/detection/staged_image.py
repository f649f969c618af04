"""What the two stages found in an image and how long they took, kept so that every figure derives from one look."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.evaluation import JudgedImage, judge
from han_bullet.detection.pictures import Image
from han_bullet.detection.rules import Rule
from han_bullet.detection.stages import Stages
from han_bullet.geometry import Array


@dataclass(frozen=True)
class StagedImage:
    """The proposals of one image.

    Attributes:
        boxes: x, y, width, height, shape (n, 4) [px].
        scores: Of the first stage, shape (n,).
        probabilities: Of the second stage, or of the first where there is no second, shape (n,).
        people: True boxes, shape (m, 4) [px].
        ignored: Regions that do not count, shape (k, 4) [px].
        proposing: Wall-clock time of the first stage [s].
        classifying: Of the second stage [s], by threshold: of the batch of all proposals (None), and of the batch of
            those above the threshold alone, for which the network ran once more.
    """

    boxes: Array
    scores: Array
    probabilities: Array
    people: Array
    ignored: Array
    proposing: float
    classifying: Mapping[float | None, float]

    def proposals(self, threshold: float | None) -> NDArray[np.bool_]:
        """Tell which proposals reach a threshold, (n,); None: all do."""
        return _reaching(self.scores, threshold)

    def decide(self, rule: Rule, threshold: float | None) -> tuple[Array, Array]:
        """Return boxes, (m, 4), and scores, (m,), of what a rule keeps of the proposals that reach a threshold."""
        kept, ranking = rule.apply(self.scores, self.probabilities)
        kept = kept & self.proposals(threshold)
        return self.boxes[kept], ranking[kept]

    def judge(self, rule: Rule, threshold: float | None) -> JudgedImage:
        """Hold what `decide` returns against the people in the image."""
        return judge(*self.decide(rule, threshold), self.people, self.ignored)


def look(stages: Stages, image: Image, people: Array, ignored: Array) -> StagedImage:
    """Run both stages on an image, the second one on all proposals and again on those above the threshold.

    Args:
        stages: The detector.
        image: RGB, (h, w, 3).
        people: True boxes, (m, 4) [px]; only kept.
        ignored: Regions that do not count, (k, 4) [px]; only kept.
    """
    started = perf_counter()
    proposals = stages.propose(image)
    proposing = perf_counter() - started
    boxes, scores, probabilities = proposals.boxes, proposals.scores, proposals.probabilities
    classifying: dict[float | None, float] = {}
    if stages.classifier is not None:
        for threshold in stages.thresholds:
            batch = boxes[_reaching(scores, threshold)]
            started = perf_counter()
            answers = stages.classifier.probabilities(image, batch)
            classifying[threshold] = perf_counter() - started
            probabilities = answers if threshold is None else probabilities
    return StagedImage(boxes, scores, probabilities, people, ignored, proposing, classifying)


def _reaching(scores: Array, threshold: float | None) -> NDArray[np.bool_]:
    reached: NDArray[np.bool_] = scores >= (-math.inf if threshold is None else threshold)
    return reached
