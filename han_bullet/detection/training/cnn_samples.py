"""Training crops for the CNN from the INRIA photographs [Dalal2005]: people, and what ACF takes for people."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.acf import AcfDetector
from han_bullet.detection.cnn import crop
from han_bullet.detection.pictures import Image, list_pictures, read_picture
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array

PERSON_HEIGHT = 96.0  # in the centre of an INRIA training crop [px]
LARGEST_JITTER = 5.0  # of translation and of scale [px], as the paper has it
HARD_NEGATIVES_PER_PHOTOGRAPH = 18  # at most, as the paper has it
# The "not fully trained" proposer: as few of the 2048 trees as the first of ACF's four training stages has. They give
# about the paper's number of hard negatives, 12 552, on our model; 24 trees give 14 500.
TREES_OF_WEAK_PROPOSER = 32

Report = Callable[[str], None]


@dataclass(frozen=True)
class Samples:
    """Crops with their class and origin.

    Attributes:
        crops: Shape (n, 64, 64, 3), RGB, uint8.
        labels: 1 for pedestrians, 0 for others, shape (n,), int64.
        sources: Number of the photograph behind each crop, shape (n,), int64.
    """

    crops: Image
    labels: NDArray[np.int64]
    sources: NDArray[np.int64]

    def select(self, rows: NDArray[np.bool_] | NDArray[np.int64]) -> Samples:
        """Return some of the samples."""
        return Samples(self.crops[rows], self.labels[rows], self.sources[rows])


def collect_samples(data: Path, acf: AcfDetector, generator: np.random.Generator, report: Report) -> Samples:
    """Cut all training crops.

    Args:
        data: Folder with inria/train_pos and inria/train_neg.
        acf: Proposer whose weakened form finds the hard negatives.
        generator: Draws the jitter.
        report: Told what was found.

    Raises:
        BadInputError: The folders are missing or empty.
    """
    people = positive_samples(data / "inria" / "train_pos", generator)
    report(f"{len(people.labels)} crops of people")
    others = negative_samples(data / "inria" / "train_neg", acf)
    report(f"{len(others.labels)} hard negatives")
    sources = np.concatenate([people.sources, others.sources + people.sources.max() + 1])
    return Samples(
        np.concatenate([people.crops, others.crops]), np.concatenate([people.labels, others.labels]), sources
    )


def positive_samples(folder: Path, generator: np.random.Generator) -> Samples:
    """Return every INRIA crop once as it is and once with its box moved and scaled by 0 to 5 px at random."""
    paths = list_pictures(folder)
    photographs = sorted({_photograph(path) for path in paths})
    crops = []
    for path in paths:
        picture = read_picture(path)
        height, width = picture.shape[:2]
        exact = np.array([0.5 * width, 0.5 * (height - PERSON_HEIGHT), 0.0, PERSON_HEIGHT])
        crops.append(crop(picture, np.stack([exact, _jittered(exact, generator)])))
    sources = np.repeat([photographs.index(_photograph(path)) for path in paths], 2)
    return Samples(np.concatenate(crops), np.ones(len(sources), np.int64), sources)


def negative_samples(folder: Path, acf: AcfDetector) -> Samples:
    """Return the best proposals, at most 18, that a weakened proposer makes in each person-free photograph."""
    weak = weakened(acf)
    crops = []
    for path in list_pictures(folder):
        picture = read_picture(path)
        boxes = weak.detect(picture).boxes
        crops.append(crop(picture, boxes[:HARD_NEGATIVES_PER_PHOTOGRAPH]))
    sources = np.repeat(np.arange(len(crops)), [len(part) for part in crops])
    return Samples(np.concatenate(crops), np.zeros(len(sources), np.int64), sources)


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
        part: Of each class's photographs that go to validation, in (0, 1); at least one does.
        generator: Draws which.

    Raises:
        BadInputError: A class has fewer than two photographs.
    """
    held_out = []
    for label, name in enumerate(("others", "people")):
        photographs = np.unique(samples.sources[samples.labels == label])
        if len(photographs) < 2:
            raise BadInputError(f"{len(photographs)} photographs show {name}; training and validation need one each")
        held_out.append(generator.permutation(photographs)[: max(1, round(part * len(photographs)))])
    validation = np.isin(samples.sources, np.concatenate(held_out))
    return samples.select(~validation), samples.select(validation)


def _jittered(box: Array, generator: np.random.Generator) -> Array:
    moved = box.copy()
    moved[:2] += generator.uniform(-LARGEST_JITTER, LARGEST_JITTER, 2)
    growth = generator.uniform(-LARGEST_JITTER, LARGEST_JITTER)
    moved[1] -= 0.5 * growth
    moved[3] += growth
    return moved


def _photograph(path: Path) -> str:
    """Return what the names of all crops from one photograph, mirror images too, share: all but the last letter."""
    return re.sub("[a-z]$", "", path.stem)
