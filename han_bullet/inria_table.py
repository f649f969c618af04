"""The detector's figures on the INRIA test photographs, stage by stage: what `han-bullet evaluate` shows."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from han_bullet.detection.acf import AcfDetector, load_acf_model
from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.cnn import Classifier, load_classifier
from han_bullet.detection.evaluation import LabelledImage, evaluate, load_inria_test
from han_bullet.detection.pedestrian_detector import PedestrianDetector
from han_bullet.detection.threads import use_one_thread

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
    """Return an ACF model with the score threshold that leaves FALSE_POSITIVES_PER_IMAGE on the test photographs.

    Args:
        data: Folder with inria/test and inria/gt.json.
        model: As `load_acf_model` takes it; it may have a threshold or none, as a freshly trained one.

    Raises:
        BadInputError: The data or the model cannot be used, or even its best detections leave more false positives.
    """
    proposer = AcfDetector(load_acf_model(model))
    result = evaluate(load_inria_test(data), proposer.detect)
    return proposer.model.with_score_threshold(result.threshold_at_fppi(FALSE_POSITIVES_PER_IMAGE))


def evaluate_stages(data: Path, model: str, report: Callable[[float], None] = lambda done: None) -> list[TableRow]:
    """Evaluate ACF alone and with the CNN, all proposals and, if the model has a score threshold, those above it.

    The rule is the paper's: a box that the CNN keeps is ranked by its ACF score.

    Args:
        data: Folder with inria/test and inria/gt.json.
        model: Of the ACF stage, as `load_acf_model` takes it: "default", the name of a shipped one, or a file.
        report: Told the share that is done, in [0, 1].

    Raises:
        BadInputError: The data or the model cannot be used.
    """
    use_one_thread()
    photographs = load_inria_test(data)
    proposer = AcfDetector(load_acf_model(model))
    own = proposer.model.score_threshold
    thresholds = (None, own) if math.isfinite(own) else (None,)
    trials = [(classifier, threshold) for classifier in (None, load_classifier()) for threshold in thresholds]
    rows: list[TableRow] = []
    for classifier, threshold in trials:
        before = len(rows)

        def part(done: float, before: int = before) -> None:
            report((before + done) / len(trials))

        rows.append(_row(photographs, proposer, classifier, threshold, part))
    return rows


def _row(
    photographs: Sequence[LabelledImage],
    proposer: AcfDetector,
    classifier: Classifier | None,
    threshold: float | None,
    report: Callable[[float], None],
) -> TableRow:
    """Evaluate the stages as they are given."""
    detector = PedestrianDetector(proposer, classifier, -math.inf if threshold is None else threshold)
    started = time.perf_counter()
    result = evaluate(photographs, detector.detect, lambda done: report(done / len(photographs)))
    speed = len(photographs) / (time.perf_counter() - started)
    counts = result.counts()
    return TableRow(
        "ACF" if classifier is None else "ACF + CNN",
        threshold,
        counts.true_positives,
        counts.false_positives,
        counts.false_negatives,
        result.log_average_miss_rate(),
        speed,
    )
