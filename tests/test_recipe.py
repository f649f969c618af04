"""The numbers of a training, as the paper has them and beyond."""

import math
from dataclasses import replace

import pytest

from han_bullet.detection.training.recipe import EXTENDED, PAPER, Recipe
from han_bullet.errors import BadInputError


def test_the_paper_s_recipe_has_its_numbers() -> None:
    assert (PAPER.epochs, PAPER.learning_rate, PAPER.falling, PAPER.weight_decay) == (10, 0.001, False, 0.0)
    assert (PAPER.deformed, PAPER.misplaced, PAPER.augmented) == (1, 0, False)
    assert (PAPER.weak_negatives, PAPER.strong_negatives) == (18, 0)
    assert Recipe() == PAPER


def test_the_extended_recipe_shows_more_of_everything() -> None:
    assert EXTENDED.augmented and EXTENDED.falling
    assert EXTENDED.deformed > PAPER.deformed and EXTENDED.misplaced > 0
    assert EXTENDED.weak_negatives + EXTENDED.strong_negatives > PAPER.weak_negatives


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"epochs": 0}, "epochs=0.*at least one epoch"),
        ({"deformed": -1}, "deformed=-1"),
        ({"misplaced": -1}, "misplaced=-1"),
        ({"weak_negatives": 0}, "one negative per photograph"),
        ({"weak_negatives": 20, "strong_negatives": -1}, "strong_negatives=-1"),
        ({"learning_rate": 0.0}, r"learning rate 0\.0"),
        ({"learning_rate": -0.1}, r"learning rate -0\.1"),
        ({"learning_rate": math.nan}, "learning rate nan"),
        ({"learning_rate": math.inf}, "learning rate inf"),
        ({"weight_decay": -1e-4}, "weight decay -0.0001"),
        ({"weight_decay": math.inf}, "weight decay inf"),
    ],
)
def test_numbers_out_of_range_are_refused_with_their_value(change: dict[str, float], sentence: str) -> None:
    with pytest.raises(BadInputError, match=sentence):
        replace(PAPER, **change)


def test_strong_negatives_alone_are_enough() -> None:
    assert replace(PAPER, weak_negatives=0, strong_negatives=1).strong_negatives == 1
