"""A detector's figures on a set of images, stage by stage: the lines of the paper's Tables 1 and 2 [Mateus2019]."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from han_bullet.detection.evaluation import Evaluation
from han_bullet.detection.pictures import Image
from han_bullet.detection.rules import FIRST_STAGE_ALONE, Rule, rules_of
from han_bullet.detection.staged_image import StagedImage, look
from han_bullet.detection.stages import Stages
from han_bullet.geometry import Array


@dataclass(frozen=True)
class FiguresRow:
    """One line of a table.

    Attributes:
        images: Name of the set.
        detector: Which stages.
        model: Of the first stage.
        rule: How the stages' scores become one decision.
        threshold: Least score of a proposal; None where every one counts.
        evaluation: What they found.
        proposals: Per image, those that reach the threshold.
        detections: Per image, those that the rule keeps of these.
        proposing: Time of the first stage per image [s], one thread, the image already read.
        classifying: Of the second [s]; with a threshold that of the proposals above it, as a batch of their own.
    """

    images: str
    detector: str
    model: str
    rule: str
    threshold: float | None
    evaluation: Evaluation
    proposals: float
    detections: float
    proposing: float
    classifying: float

    @property
    def frames_per_second(self) -> float:
        """Return how many images the stages look at in a second."""
        return 1.0 / (self.proposing + self.classifying)


def figures(name: str, images: Iterable[tuple[Image, Array, Array]], detectors: Sequence[Stages]) -> list[FiguresRow]:
    """Measure detectors with all proposals and, where one has a threshold, with those above it; with each rule.

    Args:
        name: Of the set of images.
        images: RGB (h, w, 3), true boxes (n, 4) and ignored regions (m, 4) [px] of each; taken one after another.
        detectors: All look at one image, once, before the next.

    Raises:
        BadInputError: There is nobody to find.
    """
    seen: list[list[StagedImage]] = [[] for _ in detectors]
    for number, image in enumerate(images):
        for stages, found in zip(detectors, seen, strict=True):
            if number == 0:
                look(stages, *image)  # loads compiled code, which is not to be timed
            found.append(look(stages, *image))
    return [row for stages, found in zip(detectors, seen, strict=True) for row in _rows(name, stages, found)]


def _rows(name: str, stages: Stages, images: Sequence[StagedImage]) -> list[FiguresRow]:
    """Return a detector's lines: the first stage alone, then both by each rule."""
    rules = (FIRST_STAGE_ALONE, *(rules_of(stages.classifier) if stages.classifier else ()))
    return [_row(name, stages, images, rule, threshold) for rule in rules for threshold in stages.thresholds]


def _row(name: str, stages: Stages, images: Sequence[StagedImage], rule: Rule, threshold: float | None) -> FiguresRow:
    alone = rule is FIRST_STAGE_ALONE
    return FiguresRow(
        images=name,
        detector=stages.kind if alone else f"{stages.kind} + CNN",
        model=stages.model,
        rule=rule.name,
        threshold=threshold,
        evaluation=Evaluation.of([image.judge(rule, threshold) for image in images]),
        proposals=float(np.mean([image.proposals(threshold).sum() for image in images])),
        detections=float(np.mean([len(image.decide(rule, threshold)[0]) for image in images])),
        proposing=float(np.mean([image.proposing for image in images])),
        classifying=0.0 if alone else float(np.mean([image.classifying[threshold] for image in images])),
    )
