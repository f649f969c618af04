"""The detector's figures on the INRIA test photographs, the paper's Table 1 [Mateus2019]: `han-bullet evaluate`.

Each photograph is looked at once; every row derives from what the stages found in it and how long they took.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from han_bullet.detection.acf import AcfDetector, load_acf_model
from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.cnn import Classifier, load_classifier
from han_bullet.detection.evaluation import Evaluation, LabelledImage, evaluate
from han_bullet.detection.inria import load_test_photographs
from han_bullet.detection.model_files import proposer_file
from han_bullet.detection.pictures import read_picture
from han_bullet.detection.rules import FIRST_STAGE_ALONE, Rule, rules_of
from han_bullet.detection.staged_image import StagedImage, Stages, decide, look
from han_bullet.detection.threads import use_one_thread

FALSE_POSITIVES_PER_IMAGE = 0.45  # what the paper's threshold of 40 leaves with the original's model [Mateus2019]


@dataclass(frozen=True)
class TableRow:
    """One line of the table.

    Attributes:
        detector: Which stages.
        model: Of the first stage.
        rule: How the stages' scores become one decision.
        threshold: Least score of a proposal; None where every one counts.
        evaluation: What they found.
        frames_per_second: Photographs per second of wall clock that the stages take, one thread, without reading the
            files. With a threshold the CNN's time is that of the proposals above it, as a batch of their own.
    """

    detector: str
    model: str
    rule: str
    threshold: float | None
    evaluation: Evaluation
    frames_per_second: float


def choose_threshold(data: Path, model: str) -> AcfModel:
    """Return an ACF model with the score threshold that leaves FALSE_POSITIVES_PER_IMAGE on the test photographs.

    Args:
        data: Folder with the photographs, as `load_test_photographs` takes it.
        model: As `load_acf_model` takes it; it may have a threshold or none, as a freshly trained one.

    Raises:
        BadInputError: The data or the model cannot be used, or even its best detections leave more false positives.
    """
    proposer = AcfDetector(load_acf_model(model))
    result = evaluate(load_test_photographs(data), proposer.detect)
    return proposer.model.with_score_threshold(result.threshold_at_fppi(FALSE_POSITIVES_PER_IMAGE))


def load_stages(models: Sequence[str], classifier: str) -> list[Stages]:
    """Return the detectors to evaluate.

    Args:
        models: Of the first stage, as `load_acf_model` takes them.
        classifier: Of the second, as `load_classifier` takes it.

    Raises:
        BadInputError: One of them cannot be used.
    """
    use_one_thread()
    second = load_classifier(classifier)
    return [_acf_stages(model, second) for model in models]


def _acf_stages(name_or_path: str, classifier: Classifier) -> Stages:
    model = load_acf_model(name_or_path)
    threshold = model.score_threshold if math.isfinite(model.score_threshold) else None
    return Stages("ACF", proposer_file(name_or_path).stem, AcfDetector(model).detect, threshold, classifier)


def evaluate_stages(
    images: Sequence[LabelledImage], detectors: Sequence[Stages], report: Callable[[int], None] = lambda done: None
) -> list[TableRow]:
    """Evaluate detectors with all proposals and, where one has a threshold, with those above it; with each rule.

    Args:
        images: At least one, with at least one person among them.
        detectors: All look at one photograph before the next.
        report: Called after each photograph with how many are done.

    Raises:
        BadInputError: There is nobody to find or a photograph cannot be read.
    """
    seen: list[list[StagedImage]] = [[] for _ in detectors]
    for number, image in enumerate(images, start=1):
        picture = read_picture(image.path)
        for stages, found in zip(detectors, seen, strict=True):
            if number == 1:
                look(stages, picture, image.boxes, image.ignored)  # loads compiled code, which is not to be timed
            found.append(look(stages, picture, image.boxes, image.ignored))
        report(number)
    return [row for stages, found in zip(detectors, seen, strict=True) for row in _rows(stages, found)]


def _rows(stages: Stages, images: Sequence[StagedImage]) -> list[TableRow]:
    """Return a detector's lines: the first stage alone, then both by each rule."""
    rows = [_row(stages, images, FIRST_STAGE_ALONE, threshold) for threshold in stages.thresholds]
    if stages.classifier is not None:
        rules = rules_of(stages.classifier)
        rows += [_row(stages, images, rule, threshold) for rule in rules for threshold in stages.thresholds]
    return rows


def _row(stages: Stages, images: Sequence[StagedImage], rule: Rule, threshold: float | None) -> TableRow:
    alone = rule is FIRST_STAGE_ALONE
    seconds = sum(image.proposing + (0.0 if alone else image.classifying[threshold]) for image in images)
    return TableRow(
        stages.kind if alone else f"{stages.kind} + CNN",
        stages.model,
        rule.name,
        threshold,
        decide(images, rule, threshold),
        len(images) / seconds,
    )
