"""How well a detector finds people in photographs: log-average miss rate and the counts behind it [Dollar2012].

Any callable that maps an RGB image to detections can be evaluated. The true boxes are made 0.41 times as wide as
high, as the detector's are; a detection and a person match from an intersection over union of one half.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.overlap import intersection_over_union
from han_bullet.detection.pictures import read_picture
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array
from han_bullet.messages import Detections

ASPECT = 0.41  # width over height of every person's box
SMALLEST_MATCH = 0.5  # intersection over union of a hit
REFERENCE_RATES = 10.0 ** np.arange(-2.0, 0.01, 0.25)  # false positives per image at which the miss rate is read
SMALLEST_MISS_RATE = 1e-10  # keeps the logarithm finite

Detect = Callable[[NDArray[np.uint8]], Detections]
"""Maps an RGB image, (h, w, 3), to the people in it; `detect` of any `Detector` does."""


@dataclass(frozen=True)
class LabelledImage:
    """A photograph and the people in it.

    Attributes:
        path: File.
        boxes: x, y, width, height, shape (n, 4) [px].
    """

    path: Path
    boxes: Array


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

    def curve(self) -> tuple[Array, Array]:
        """Return false positives per image and miss rate after each detection, both (n,)."""
        return np.cumsum(~self.hits) / self.images, 1.0 - np.cumsum(self.hits) / self.people

    def log_average_miss_rate(self) -> float:
        """Return the geometric mean of the miss rates at nine rates of false positives from 0.01 to 1 per image."""
        false_positives, miss_rates = self.curve()
        last = np.searchsorted(false_positives, REFERENCE_RATES, side="right") - 1
        at_reference = np.where(last >= 0, miss_rates[np.maximum(last, 0)] if len(miss_rates) else 1.0, 1.0)
        return math.exp(float(np.log(np.maximum(at_reference, SMALLEST_MISS_RATE)).mean()))

    def counts(self, threshold: float = -math.inf) -> Counts:
        """Return the counts of the detections with at least this score."""
        kept = self.hits[self.scores >= threshold]
        hits = int(kept.sum())
        return Counts(hits, kept.size - hits, self.people - hits)

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


def load_inria_test(data: Path) -> list[LabelledImage]:
    """Return the INRIA test photographs of a data folder, in the order of their names.

    Raises:
        BadInputError: If inria/gt.json or a photograph is missing or malformed.
    """
    file = data / "inria" / "gt.json"
    try:
        entries = json.loads(file.read_text(encoding="utf-8"))
        labelled = [
            LabelledImage(data / "inria" / "test" / name, _from_corners(entry["boxes_xyxy"]))
            for name, entry in sorted(entries.items())
        ]
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise BadInputError(f"{file} must map names to boxes_xyxy, lists of x0, y0, x1, y1: {error}") from error
    if not labelled:
        raise BadInputError(f"{file} names no photograph")
    return labelled


def _from_corners(corners: list[list[float]]) -> Array:
    """Return x, y, width, height of boxes given by two corners."""
    boxes = np.asarray(corners, float).reshape(-1, 4)
    return np.column_stack([boxes[:, :2], boxes[:, 2:] - boxes[:, :2]])


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
    scores: list[Array] = [np.empty(0)]
    hits: list[NDArray[np.bool_]] = [np.empty(0, bool)]
    people = count = 0
    for count, labelled in enumerate(images, start=1):
        found = detect(read_picture(labelled.path))
        found = found.select(np.argsort(-found.scores, kind="stable"))
        scores.append(found.scores)
        hits.append(match(found.boxes, fix_aspect(labelled.boxes)))
        people += len(labelled.boxes)
        report(count)
    if people == 0:
        raise BadInputError(f"{count} images with no person in them: a miss rate needs at least one")
    all_scores, all_hits = np.concatenate(scores), np.concatenate(hits)
    order = np.argsort(-all_scores, kind="stable")
    return Evaluation(all_scores[order], all_hits[order], count, people)


def fix_aspect(boxes: Array) -> Array:
    """Return boxes, (n, 4), of the same height and centre that are 0.41 times as wide as high."""
    width = ASPECT * boxes[:, 3]
    return np.column_stack([boxes[:, 0] + 0.5 * (boxes[:, 2] - width), boxes[:, 1], width, boxes[:, 3]])


def match(boxes: Array, people: Array) -> NDArray[np.bool_]:
    """Tell which detections, sorted by falling score, hit: each takes the free person it overlaps most.

    Args:
        boxes: Detections, shape (n, 4) [px].
        people: True boxes, shape (m, 4) [px].
    """
    overlaps = intersection_over_union(boxes, people)
    hits = np.zeros(len(boxes), bool)
    for number in range(len(boxes)):
        if not len(people):
            break
        best = int(np.argmax(overlaps[number]))
        if overlaps[number, best] >= SMALLEST_MATCH:
            hits[number] = True
            overlaps[:, best] = -1.0  # this person is taken
    return hits
