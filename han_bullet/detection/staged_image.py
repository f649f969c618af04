"""What the two stages found in an image and how long they took, kept so that every figure derives from one pass."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.evaluation import Detect, Evaluation, judge
from han_bullet.detection.pictures import Image
from han_bullet.detection.rules import Rule
from han_bullet.geometry import Array

if TYPE_CHECKING:  # torch is slow to import
    from han_bullet.detection.cnn import Classifier


@dataclass(frozen=True)
class Stages:
    """A detector taken apart.

    Attributes:
        kind: Of its first stage, such as "ACF".
        model: Of its first stage, by name.
        propose: The first stage, without a threshold.
        threshold: Least score of a proposal that it recommends; None if it has none.
        classifier: The second stage; None for a detector without one.
    """

    kind: str
    model: str
    propose: Detect
    threshold: float | None = None
    classifier: Classifier | None = None

    @property
    def thresholds(self) -> tuple[float | None, ...]:
        """Return those that figures are given for: None, all proposals, and the recommended one where there is one."""
        return (None,) if self.threshold is None else (None, self.threshold)


@dataclass(frozen=True)
class StagedImage:
    """The proposals of one image.

    Attributes:
        boxes: x, y, width, height, shape (n, 4) [px].
        scores: Of the first stage, shape (n,).
        probabilities: Of the second stage, shape (n,); 1 without one.
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
    classifying: dict[float | None, float]


def look(stages: Stages, image: Image, people: Array, ignored: Array) -> StagedImage:
    """Run both stages on an image, the second one on all proposals and again on those above the threshold.

    Args:
        stages: The detector.
        image: RGB, (h, w, 3).
        people: True boxes, (m, 4) [px]; only kept.
        ignored: Regions that do not count, (k, 4) [px]; only kept.
    """
    started = perf_counter()
    boxes, scores = stages.propose(image)
    proposing = perf_counter() - started
    probabilities: Array = np.ones(len(boxes))
    classifying: dict[float | None, float] = {}
    if stages.classifier is not None:
        for threshold in stages.thresholds:
            batch = boxes[_at_least(scores, threshold)]
            started = perf_counter()
            answers = stages.classifier.probabilities(image, batch)
            classifying[threshold] = perf_counter() - started
            probabilities = answers if threshold is None else probabilities
    return StagedImage(boxes, scores, probabilities, people, ignored, proposing, classifying)


def decide(images: Sequence[StagedImage], rule: Rule, threshold: float | None) -> Evaluation:
    """Return how well a rule does on the proposals with at least this first-stage score; None: on all.

    Raises:
        BadInputError: If there is nobody to find.
    """
    judged = []
    for image in images:
        kept, ranking = rule.apply(image.scores, image.probabilities)
        kept = kept & _at_least(image.scores, threshold)
        judged.append(judge(image.boxes[kept], ranking[kept], image.people, image.ignored))
    return Evaluation.of(judged)


def _at_least(scores: Array, threshold: float | None) -> NDArray[np.bool_]:
    """Tell which scores reach a threshold, (n,); None: all do."""
    reached: NDArray[np.bool_] = scores >= (-math.inf if threshold is None else threshold)
    return reached
