"""The detector's figures on the INRIA test photographs, stage by stage: what `han-bullet evaluate` shows."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.acf import AcfModel
from han_bullet.detection.detector import load_detector
from han_bullet.detection.evaluation import evaluate, load_inria_test
from han_bullet.detection.threads import use_one_thread
from han_bullet.geometry import Array

FALSE_POSITIVES_PER_IMAGE = 0.45  # what the paper's threshold of 40 leaves with the original's model [Mateus2019]


@dataclass(frozen=True)
class TableRow:
    """One line of the table.

    Attributes:
        detector: Which stages.
        threshold: Least ACF score, or None where every proposal counts.
        true_positives: People found.
        false_positives: Detections that are nobody, or somebody twice.
        false_negatives: People missed.
        miss_rate: Log-average over nine rates of false positives, in [0, 1].
        frames_per_second: Photographs per second, one thread.
    """

    detector: str
    threshold: float | None
    true_positives: int
    false_positives: int
    false_negatives: int
    miss_rate: float
    frames_per_second: float


def choose_threshold(data: Path, model: str) -> AcfModel:
    """Return an ACF model with the score threshold that leaves FALSE_POSITIVES_PER_IMAGE on the test photographs."""
    detector = load_detector(model, classifier=False)
    result = evaluate(load_inria_test(data), detector.proposer.detect)
    return detector.proposer.model.with_score_threshold(result.threshold_at_fppi(FALSE_POSITIVES_PER_IMAGE))


def evaluate_stages(data: Path, model: str, report: Callable[[float], None] = lambda done: None) -> list[TableRow]:
    """Evaluate ACF alone and with the CNN, all proposals and those above the model's score threshold.

    The rule is the paper's: a box that the CNN keeps is ranked by its ACF score.

    Args:
        data: Folder with inria/test and inria/gt.json.
        model: Of the ACF stage: "default", the name of a shipped one, or a file.
        report: Told the share that is done, in [0, 1].

    Raises:
        BadInputError: The data or the model cannot be used.
    """
    use_one_thread()
    photographs = load_inria_test(data)
    detector = load_detector(model)
    proposer, classifier = detector.proposer, detector.classifier
    assert classifier is not None  # load_detector was asked for one

    def with_cnn(image: NDArray[np.uint8], threshold: float) -> tuple[Array, Array]:
        boxes, scores = proposer.detect(image)
        boxes, scores = boxes[scores >= threshold], scores[scores >= threshold]
        kept = classifier.probabilities(image, boxes) >= classifier.least_probability
        return boxes[kept], scores[kept]

    def alone(image: NDArray[np.uint8], threshold: float) -> tuple[Array, Array]:
        boxes, scores = proposer.detect(image)
        return boxes[scores >= threshold], scores[scores >= threshold]

    rows = []
    trials = [(n, f, t) for n, f in (("ACF", alone), ("ACF + CNN", with_cnn)) for t in (None, detector.threshold)]
    for number, (name, detect, threshold) in enumerate(trials):
        least = -np.inf if threshold is None else threshold
        started = time.perf_counter()
        result = evaluate(
            photographs,
            lambda image, detect=detect, least=least: detect(image, least),  # type: ignore[misc]
            lambda done, number=number: report((number + done / len(photographs)) / len(trials)),  # type: ignore[misc]
        )
        speed = len(photographs) / (time.perf_counter() - started)
        counts = result.counts()
        rows.append(
            TableRow(
                name,
                threshold,
                counts.true_positives,
                counts.false_positives,
                counts.false_negatives,
                result.log_average_miss_rate(),
                speed,
            )
        )
    return rows
