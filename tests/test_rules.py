"""How two scores become a decision and a ranking."""

import numpy as np
import pytest

from han_bullet.detection.rules import FIRST_STAGE_ALONE, mixed_rule, paper_rule

SCORES = np.array([90.0, 50.0, 45.0, 41.0])
PROBABILITIES = np.array([0.9, 0.2, 0.5, 0.0])


def test_the_paper_s_rule_drops_by_probability_and_ranks_by_acf_score() -> None:
    kept, ranking = paper_rule(0.5).apply(SCORES, PROBABILITIES)
    assert kept.tolist() == [True, False, True, False]
    assert np.array_equal(ranking, SCORES)


def test_the_first_stage_alone_keeps_everything_in_its_order() -> None:
    kept, ranking = FIRST_STAGE_ALONE.apply(SCORES, PROBABILITIES)
    assert kept.all()
    assert np.array_equal(ranking, SCORES)


def test_both_scores_drop_nothing_and_add_weighted_score_and_log_odds() -> None:
    kept, ranking = mixed_rule(0.1).apply(SCORES, PROBABILITIES)
    assert kept.all()
    assert ranking[0] == pytest.approx(9.0 + np.log(9.0))
    assert ranking[2] == pytest.approx(4.5)  # even odds add nothing
    assert np.isfinite(ranking).all()  # a probability of 0 too
    assert ranking.argsort()[::-1].tolist() == [0, 2, 1, 3]
