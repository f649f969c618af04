"""Training crops for the CNN from the INRIA photographs [Dalal2005]: people, and what ACF takes for people."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.acf import AcfDetector
from han_bullet.detection.cnn import crop
from han_bullet.detection.inria import train_backgrounds, train_people
from han_bullet.detection.matching import ASPECT
from han_bullet.detection.pictures import Image, cut, read_picture
from han_bullet.detection.training.boxes import deformed, misplaced
from han_bullet.detection.training.recipe import Recipe
from han_bullet.errors import BadInputError

PERSON_HEIGHT = 96.0  # in the centre of an INRIA training crop [px]
# The "not fully trained" proposer: as few of the 2048 trees as the first of ACF's four training stages has.
TREES_OF_WEAK_PROPOSER = 32
CROP_MARGIN = 1.16  # times the network's input, so that a crop can be moved and scaled without running out of picture
SURROUNDINGS = 60  # [px] of repeated border around an INRIA crop, for boxes that reach beyond it

Report = Callable[[str], None]


@dataclass(frozen=True)
class Samples:
    """Crops with their class and origin.

    Attributes:
        crops: With their margin, shape (n, rows, columns, 3), RGB, uint8.
        labels: 1 for pedestrians, 0 for others, shape (n,), int64.
        sources: Number of the photograph behind each crop, shape (n,), int64.
    """

    crops: Image
    labels: NDArray[np.int64]
    sources: NDArray[np.int64]

    def select(self, rows: NDArray[np.bool_] | NDArray[np.int64]) -> Samples:
        """Return some of the samples."""
        return Samples(self.crops[rows], self.labels[rows], self.sources[rows])

    @classmethod
    def joined(cls, parts: Sequence[Samples]) -> Samples:
        """Return all samples of several parts."""
        crops, labels, sources = ([getattr(part, name) for part in parts] for name in ("crops", "labels", "sources"))
        return cls(np.concatenate(crops), np.concatenate(labels), np.concatenate(sources))


def collect_samples(
    data: Path,
    acf: AcfDetector,
    size: tuple[int, int],
    recipe: Recipe,
    generator: np.random.Generator,
    report: Report,
) -> Samples:
    """Cut all training crops.

    Args:
        data: Folder with the INRIA photographs.
        acf: Proposer that, and whose weakened form, finds the hard negatives.
        size: Height and width of the network's input [px].
        recipe: How many of each kind.
        generator: Draws deformed and misplaced boxes.
        report: Told what was found.

    Raises:
        BadInputError: The folders are missing or empty.
    """
    people = samples_around_people(train_people(data), size, recipe, generator)
    report(f"{np.count_nonzero(people.labels)} crops of people, {np.count_nonzero(people.labels == 0)} beside them")
    others = samples_of_background(train_backgrounds(data), acf, size, recipe)
    report(f"{len(others.labels)} hard negatives")
    return Samples.joined([people, replace(others, sources=others.sources + people.sources.max() + 1)])


def samples_around_people(
    paths: Sequence[Path], size: tuple[int, int], recipe: Recipe, generator: np.random.Generator
) -> Samples:
    """Return every INRIA crop as it is and deformed, as people, and boxes misplaced around it, as background."""
    photographs = sorted({_photograph(path) for path in paths})
    parts = []
    for path in paths:
        picture = read_picture(path)
        height, width = picture.shape[:2]
        sides = np.array([ASPECT * PERSON_HEIGHT, PERSON_HEIGHT])
        exact = np.concatenate([0.5 * (np.array([width, height]) - sides), sides])
        boxes = [exact, *(deformed(exact, generator) for _ in range(recipe.deformed))]
        people = len(boxes)
        boxes += [misplaced(exact, kind, generator) for kind in range(recipe.misplaced)]
        wider = cut(picture, -SURROUNDINGS, -SURROUNDINGS, width + SURROUNDINGS, height + SURROUNDINGS)
        crops = crop(wider, np.array(boxes) + np.array([SURROUNDINGS, SURROUNDINGS, 0, 0]), size, CROP_MARGIN)
        labels = (np.arange(len(boxes)) < people).astype(np.int64)
        parts.append(Samples(crops, labels, np.full(len(boxes), photographs.index(_photograph(path)))))
    return Samples.joined(parts)


def samples_of_background(paths: Sequence[Path], acf: AcfDetector, size: tuple[int, int], recipe: Recipe) -> Samples:
    """Return the best proposals that a weakened proposer and the proposer itself make in person-free photographs."""
    proposers = [
        (proposer, most)
        for proposer, most in ((acf, recipe.strong_negatives), (weakened(acf), recipe.weak_negatives))
        if most
    ]
    parts = []
    for number, path in enumerate(paths):
        picture = read_picture(path)
        boxes = np.concatenate([proposer.detect(picture).boxes[:most] for proposer, most in proposers])
        crops = crop(picture, boxes, size, CROP_MARGIN)
        parts.append(Samples(crops, np.zeros(len(crops), np.int64), np.full(len(crops), number)))
    return Samples.joined(parts)


def weakened(acf: AcfDetector, trees: int = TREES_OF_WEAK_PROPOSER) -> AcfDetector:
    """Return a proposer that uses only the first trees, and so lets more through."""
    model = acf.model
    return AcfDetector(
        replace(
            model, features=model.features[:trees], thresholds=model.thresholds[:trees], leaves=model.leaves[:trees]
        )
    )


def split(samples: Samples, part: float, generator: np.random.Generator) -> tuple[Samples, Samples]:
    """Split into training and validation, whole photographs at a time, so that no near copy is on both sides.

    Args:
        samples: To split.
        part: Of each class's photographs that go to validation, in (0, 1); at least one does, and one does not.
        generator: Draws which.

    Raises:
        BadInputError: A class has fewer than two photographs.
    """
    shows_people = np.unique(samples.sources[samples.labels == 1])
    background = np.setdiff1d(samples.sources, shows_people)
    held_out = []
    for photographs, name in ((background, "nobody"), (shows_people, "people")):
        if len(photographs) < 2:
            raise BadInputError(f"{len(photographs)} photographs show {name}; training and validation need one each")
        count = min(max(1, round(part * len(photographs))), len(photographs) - 1)
        held_out.append(generator.permutation(photographs)[:count])
    validation = np.isin(samples.sources, np.concatenate(held_out))
    return samples.select(~validation), samples.select(validation)


def _photograph(path: Path) -> str:
    """Return what the names of all crops from one photograph, mirror images too, share: all but the last letter."""
    return re.sub("[a-z]$", "", path.stem)
