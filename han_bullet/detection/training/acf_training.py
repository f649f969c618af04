"""Trains the ACF classifier on the INRIA person data in four bootstrapped stages [Dollar2014]."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.acf_model import LARGEST_DEPTH, AcfModel
from han_bullet.detection.channels import Floats
from han_bullet.detection.inria import train_backgrounds, train_people
from han_bullet.detection.pictures import Image
from han_bullet.detection.training.acf_samples import (
    CROP_MARGIN,
    PERSON_HEIGHT,
    PERSON_WIDTH,
    WINDOW_HEIGHT,
    WINDOW_WIDTH,
    collect_negatives,
    estimate_lambdas,
    misplaced_windows,
    person_crop,
    window_features,
)
from han_bullet.detection.training.boosting import Boosting, BoostingStep, GentleBoost, boost
from han_bullet.detection.training.trees import quantise
from han_bullet.errors import BadInputError

LEAF_CALIBRATION = 0.005  # added to each leaf after training, so that the cascade gives up fewer people
REPORTED_TREES = 16  # the log has a line for every so many trees

Report = Callable[[str, float], None]
"""Gets a line for the log and the share of the whole work that is done, in [0, 1]."""


@dataclass(frozen=True)
class AcfTrainingOptions:
    """What the training may vary; sizes are those of the original for INRIA.

    Attributes:
        boosting: How samples are weighed and leaves vote; `DiscreteAdaBoost` is the original's.
        depth: Of each tree.
        misplaced: Windows beside, above, around or inside each person that count as background in every stage, for a
            box that is half a person off is a mistake; the original has none.
        trees_of_stages: Each stage trains a classifier from scratch, the next one on what it got wrong.
        new_negatives: Background windows gathered for each stage.
        all_negatives: Background windows kept in total.
        per_photograph: Background windows taken from one photograph at most.
    """

    boosting: Boosting = field(default_factory=GentleBoost)
    depth: int = 3
    misplaced: int = 1
    trees_of_stages: tuple[int, ...] = (32, 128, 512, 2048)
    new_negatives: int = 5000
    all_negatives: int = 10_000
    per_photograph: int = 25

    def __post_init__(self) -> None:
        """Check that every count is positive and trees are no deeper than a model may have them."""
        counts = (self.depth, *self.trees_of_stages, self.new_negatives, self.all_negatives, self.per_photograph)
        if not self.trees_of_stages or min(counts) < 1:
            raise BadInputError(f"training options {self}: all counts must be at least 1")
        if self.misplaced < 0:
            raise BadInputError(f"misplaced windows per person are {self.misplaced}; 0 or more would be right")
        if self.depth > LARGEST_DEPTH:
            raise BadInputError(f"depth of the trees is {self.depth}; 1 to {LARGEST_DEPTH} would be right")


def train_acf(data: Path, out: Path, seed: int, report: Report, options: AcfTrainingOptions | None = None) -> AcfModel:
    """Train a classifier, write it, and write each stage's classifier beside it (`<out>_stage<k>.npz`).

    The same seed and data give the same file contents bit for bit.

    Args:
        data: Folder with the INRIA photographs, see `han_bullet.detection.inria`.
        out: File to write, .npz.
        seed: Of all random choices.
        report: Receives the log.
        options: Sizes of the stages.

    Raises:
        BadInputError: If the data are missing or unreadable.
    """
    options = options or AcfTrainingOptions()
    rng = np.random.default_rng(seed)
    photographs = train_backgrounds(data)
    crops = [person_crop(file) for file in train_people(data)]
    people, lambdas = _people(crops, report)
    beside = misplaced_windows(crops, options.misplaced, rng)
    negatives: Floats = np.empty((0, people.shape[1]), np.float32)
    model: AcfModel | None = None
    total, done = sum(options.trees_of_stages), 0
    for stage, trees in enumerate(options.trees_of_stages, start=1):
        line = _StageLog(stage, done / total, (done + trees) / total, report)
        fresh, used = collect_negatives(
            photographs, model, options.new_negatives, options.per_photograph, rng, line.gathering
        )
        line.say(f"{len(fresh)} negatives from {used} photographs", _StageLog.GATHERING)
        negatives = np.concatenate([_subset(negatives, options.all_negatives - len(fresh), rng), fresh])
        model = _train_stage(people, np.concatenate([beside, negatives]), trees, lambdas, options, rng, line)
        model.save(out.with_name(f"{out.stem}_stage{stage}.npz"))
        done += trees
    assert model is not None  # there is at least one stage
    boosting = options.boosting
    model = replace(
        model,
        leaves=model.leaves + np.float32(boosting.calibration),
        cascade_threshold=boosting.cascade_threshold,
    )
    model.save(out)
    return model


class _StageLog:
    """Puts the progress of one stage in its place within the whole."""

    GATHERING = 0.5  # share of a stage's time that goes into gathering its negatives

    def __init__(self, stage: int, start: float, end: float, report: Report) -> None:
        self._name, self._start, self._end, self._report = f"stage {stage}", start, end, report

    def say(self, text: str, done: float) -> None:
        """Pass on a line, with the share of the stage that is done."""
        self._report(f"{self._name}: {text}", self._start + (self._end - self._start) * done)

    def gathering(self, done: float) -> None:
        """Tell, without a line for the log, that a part of the negatives is there."""
        self._report("", self._start + (self._end - self._start) * self.GATHERING * done)

    def tree(self, step: BoostingStep, trees: int) -> None:
        """Tell how a tree came out."""
        if step.tree % REPORTED_TREES == 0:
            text = f"tree {step.tree}  vote {step.vote:.3f}  error {step.error:.3f}  loss {step.loss:.2e}"
            self.say(text, self.GATHERING + (1.0 - self.GATHERING) * step.tree / trees)


def _people(crops: list[Image], report: Report) -> tuple[Floats, tuple[float, float, float]]:
    """Return the people's features, (n, 5120), and the lambdas measured on them."""
    features = np.array([window_features(crop) for crop in crops])
    inner = slice(CROP_MARGIN, -CROP_MARGIN)
    lambdas = estimate_lambdas([np.ascontiguousarray(crop[inner, inner]) for crop in crops])
    report(f"{len(crops)} people, lambdas {lambdas}", 0.0)
    return features, lambdas


def _subset(samples: Floats, count: int, rng: np.random.Generator) -> Floats:
    """Return at most `count` of the samples, in their order, drawn at random."""
    if len(samples) <= count:
        return samples
    return samples[np.sort(rng.choice(len(samples), count, replace=False))]


def _train_stage(
    people: Floats,
    negatives: Floats,
    trees: int,
    lambdas: tuple[float, float, float],
    options: AcfTrainingOptions,
    rng: np.random.Generator,
    line: _StageLog,
) -> AcfModel:
    """Train one stage's classifier from scratch."""
    data = quantise(np.concatenate([people, negatives]))
    is_person: NDArray[np.bool_] = np.arange(len(people) + len(negatives)) < len(people)
    trained = boost(data, is_person, trees, options.depth, options.boosting, rng, lambda step: line.tree(step, trees))
    leaves = trained.leaves + np.float32(LEAF_CALIBRATION)
    return AcfModel(
        trained.features,
        trained.thresholds,
        leaves,
        lambdas,
        person_height=PERSON_HEIGHT,
        person_width=PERSON_WIDTH,
        window_height=WINDOW_HEIGHT,
        window_width=WINDOW_WIDTH,
    )
