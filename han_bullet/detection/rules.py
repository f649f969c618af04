"""How the scores of the two stages become one decision and one ranking."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array

# What a point of ACF score is worth beside the CNN's log-odds. Of the weights 0.01 to 1 it gave the smallest miss rate
# on a third of the training photographs that neither stage had seen; between 0.05 and 0.2 little changes.
# It is meant for `acf_inria`; other models' scores have other scales.
ACF_WEIGHT = 0.13
SURE = 1e-9  # probabilities are this far from 0 and 1 at least, so that their log-odds are finite

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


def mixed_rule(acf_weight: float = ACF_WEIGHT) -> Rule:
    """Return the one that drops nothing and ranks by both stages: weighted ACF score plus the CNN's log-odds."""

    def apply(scores: Array, probabilities: Array) -> tuple[NDArray[np.bool_], Array]:
        sure = np.clip(probabilities, SURE, 1.0 - SURE)
        return np.ones(len(scores), bool), acf_weight * scores + np.log(sure / (1.0 - sure))

    return Rule("both scores", apply)


def rules_of(classifier: Classifier) -> tuple[Rule, ...]:
    """Return the rules that join a first stage with this classifier."""
    return paper_rule(classifier.least_probability), mixed_rule()
