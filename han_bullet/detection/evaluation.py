"""How well a detector finds people in photographs: log-average miss rate and the counts behind it [Dollar2012].

Any callable that maps an RGB image to detections can be evaluated. The true boxes are made 0.41 times as wide as
high, as the detector's are; a detection and a person match from an intersection over union of one half. A detection
that hits nobody and lies in an ignored region counts neither way.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.matching import fix_aspect, in_ignored, match
from han_bullet.detection.pictures import Image, read_picture
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array
from han_bullet.messages import Detections

REFERENCE_RATES = 10.0 ** np.arange(-2.0, 0.01, 0.25)  # false positives per image at which the miss rate is read
SMALLEST_MISS_RATE = 1e-10  # keeps the logarithm finite

Detect = Callable[[Image], Detections]
"""Maps an RGB image, (h, w, 3), to the people in it; `detect` of any `Detector` does."""


def no_boxes() -> Array:
    """Return an empty array of boxes, (0, 4)."""
    return np.empty((0, 4))


@dataclass(frozen=True)
class LabelledImage:
    """A photograph and the people in it.

    Attributes:
        path: File.
        boxes: The people, x, y, width, height, shape (n, 4) [px].
        ignored: Regions in which a detection counts neither way, shape (m, 4) [px].
    """

    path: Path
    boxes: Array
    ignored: Array = field(default_factory=no_boxes)


@dataclass(frozen=True)
class Counts:
    """What a detector got right and wrong at one threshold.

    Attributes:
        true_positives, false_positives, false_negatives: Detections that hit, that do not, and people missed.
    """

    true_positives: int
    false_positives: int
    false_negatives: int


@dataclass(frozen=True)
class JudgedImage:
    """The detections of one image that count.

    Attributes:
        scores: Shape (n,), falling.
        hits: Whether each is a person nobody else claimed, shape (n,).
        people: How many true people there are.
    """

    scores: Array
    hits: NDArray[np.bool_]
    people: int


def judge(boxes: Array, scores: Array, people: Array, ignored: Array) -> JudgedImage:
    """Hold the detections of one image against its true people.

    Args:
        boxes: Detections, (n, 4) [px].
        scores: Theirs, (n,).
        people: True boxes of any proportion, (m, 4) [px].
        ignored: Regions in which a detection that hits nobody does not count, (k, 4) [px].
    """
    order = np.argsort(-scores, kind="stable")
    boxes, scores = boxes[order], scores[order]
    hits = match(boxes, fix_aspect(people))
    counting = hits | ~in_ignored(boxes, ignored)
    return JudgedImage(scores[counting], hits[counting], len(people))


@dataclass(frozen=True)
class Evaluation:
    """All detections of a set of images, by falling score.

    Attributes:
        scores: Shape (n,).
        hits: Whether each is a person nobody else claimed, shape (n,).
        images: How many images.
        people: How many true people.
    """

    scores: Array
    hits: NDArray[np.bool_]
    images: int
    people: int

    @classmethod
    def of(cls, judged: Sequence[JudgedImage]) -> Evaluation:
        """Join the detections of all images.

        Raises:
            BadInputError: If there is nobody to find.
        """
        people = sum(image.people for image in judged)
        if people == 0:
            raise BadInputError(f"{len(judged)} images, and no person in them who counts: a miss rate needs one")
        scores = np.concatenate([image.scores for image in judged])
        order = np.argsort(-scores, kind="stable")
        return cls(scores[order], np.concatenate([image.hits for image in judged])[order], len(judged), people)

    def curve(self) -> tuple[Array, Array]:
        """Return false positives per image and miss rate after each detection, both (n,)."""
        return np.cumsum(~self.hits) / self.images, 1.0 - np.cumsum(self.hits) / self.people

    def reference_miss_rates(self) -> Array:
        """Return the miss rates at the nine rates of false positives from 0.01 to 1 per image, (9,)."""
        false_positives, miss_rates = self.curve()
        last = np.searchsorted(false_positives, REFERENCE_RATES, side="right")
        at_reference: Array = np.concatenate([[1.0], miss_rates])[last]
        return at_reference

    def log_average_miss_rate(self) -> float:
        """Return the geometric mean of the miss rates at the nine reference rates."""
        return math.exp(float(np.log(np.maximum(self.reference_miss_rates(), SMALLEST_MISS_RATE)).mean()))

    def counts(self, threshold: float = -math.inf) -> Counts:
        """Return the counts of the detections with at least this score."""
        kept = self.hits[self.scores >= threshold]
        hits = int(kept.sum())
        return Counts(hits, kept.size - hits, self.people - hits)

    def recall(self) -> float:
        """Return the share of the people that is found."""
        return float(self.hits.sum()) / self.people

    def false_positives_per_image(self) -> float:
        """Return how many detections per image are nobody, or somebody twice."""
        return float((~self.hits).sum()) / self.images

    def above(self, threshold: float) -> Evaluation:
        """Return the evaluation of the detections with at least this score."""
        kept = self.scores >= threshold
        return Evaluation(self.scores[kept], self.hits[kept], self.images, self.people)

    def threshold_at_fppi(self, rate: float) -> float:
        """Return the smallest score of a detection down to which there are at most `rate` false positives per image.

        Raises:
            BadInputError: If there is no such score.
        """
        false_positives, _ = self.curve()
        # Equal scores stand or fall together.
        last_of_score = np.append(self.scores[1:] != self.scores[:-1], True)[: self.scores.size]
        usable = self.scores[(false_positives <= rate) & last_of_score]
        if not usable.size:
            raise BadInputError(f"{rate} false positives per image: even the strongest detection leaves more")
        return float(usable[-1])


def evaluate(
    images: Iterable[LabelledImage], detect: Detect, report: Callable[[int], None] = lambda done: None
) -> Evaluation:
    """Run a detector over labelled images.

    Args:
        images: At least one, with at least one person among them.
        detect: The detector.
        report: Called after each image with how many are done.

    Raises:
        BadInputError: If there is nobody to find or a photograph cannot be read.
    """
    judged: list[JudgedImage] = []
    for labelled in images:
        found = detect(read_picture(labelled.path))
        judged.append(judge(found.boxes, found.scores, labelled.boxes, labelled.ignored))
        report(len(judged))
    return Evaluation.of(judged)
