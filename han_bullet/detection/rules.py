"""How the scores of the two stages become one decision and one ranking."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array

if TYPE_CHECKING:  # torch is slow to import
    from han_bullet.detection.cnn import Classifier


@dataclass(frozen=True)
class Rule:
    """A decision about proposals.

    Attributes:
        name: As a table shows it.
        apply: From ACF scores and CNN probabilities, (n,) each, to which proposals stay and the scores that rank them.
    """

    name: str
    apply: Callable[[Array, Array], tuple[NDArray[np.bool_], Array]]


FIRST_STAGE_ALONE = Rule("-", lambda scores, probabilities: (np.ones(len(scores), bool), scores))


def paper_rule(least_probability: float) -> Rule:
    """Return the paper's: the CNN keeps or drops a proposal, which keeps its ACF score [Mateus2019]."""
    return Rule("paper rule", lambda scores, probabilities: (probabilities >= least_probability, scores))


def rules_of(classifier: Classifier) -> tuple[Rule, ...]:
    """Return the rules that join a first stage with this classifier."""
    return (paper_rule(classifier.least_probability),)
