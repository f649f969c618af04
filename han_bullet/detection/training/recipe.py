"""What a training of the second stage does: the paper's recipe, and one that goes beyond it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from han_bullet.errors import BadInputError


@dataclass(frozen=True)
class Recipe:
    """The numbers of a training.

    Attributes:
        epochs: Passes over the samples.
        learning_rate: Of stochastic gradient descent with momentum 0.9 in batches of 100.
        falling: Whether the rate rises over the first tenth of the steps and then falls as a cosine, with Nesterov's
            momentum, or stays.
        weight_decay: Of the weights.
        deformed: Copies of each person, moved and scaled a little.
        misplaced: Boxes beside, above, around and inside each person, taken as background: a box that is half a person
            off is a mistake, and without them a network never learns that.
        weak_negatives: Per person-free photograph at most, found by a not fully trained first stage.
        strong_negatives: The same, found by the whole first stage.
        augmented: Whether place, size, light, colour, sharpness and noise change anew in every epoch.
    """

    epochs: int = 10
    learning_rate: float = 0.001
    falling: bool = False
    weight_decay: float = 0.0
    deformed: int = 1
    misplaced: int = 0
    weak_negatives: int = 18
    strong_negatives: int = 0
    augmented: bool = False

    def __post_init__(self) -> None:
        """Check the ranges."""
        counts = (self.deformed, self.misplaced, self.weak_negatives, self.strong_negatives)
        if self.epochs < 1 or min(counts) < 0 or self.weak_negatives + self.strong_negatives < 1:
            raise BadInputError(f"{self}: at least one epoch and one negative per photograph are needed")
        if not (0.0 < self.learning_rate < math.inf and 0.0 <= self.weight_decay < math.inf):
            rates = f"learning rate {self.learning_rate}, weight decay {self.weight_decay}"
            raise BadInputError(f"{rates}: finite ones, above 0 and not below 0, would be right")


PAPER = Recipe()
"""[Mateus2019]: every crop once as it is and once deformed by 0 to 5 px, 18 hard negatives per photograph at most."""

EXTENDED = Recipe(
    epochs=6,
    learning_rate=0.003,
    falling=True,
    weight_decay=5e-4,  # as VGG was trained [Simonyan2015]
    deformed=3,
    misplaced=6,
    weak_negatives=10,
    strong_negatives=15,
    augmented=True,
)
"""What the shipped weights come from."""
