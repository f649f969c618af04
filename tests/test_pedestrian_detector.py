"""The detector that joins ACF and CNN: order of the stages, what each drops, what is kept with it."""

import math

import numpy as np
import pytest
from bars import BLUE, RED, WHITE, RedNetwork, detector, found_at, image

from han_bullet.detection.cnn import Classifier
from han_bullet.errors import BadInputError


def test_bars_are_found_where_they_stand_by_falling_score():
    found = detector().detect(image((60, WHITE), (204, WHITE)))
    assert found_at(found) == [72, 216]
    assert found.boxes.shape == (len(found.scores), 4)
    assert (np.diff(found.scores) <= 0.0).all()
    assert (found.probabilities == 1.0).all()


def test_proposals_below_the_threshold_are_dropped():
    picture = image((60, WHITE))
    assert len(detector(threshold=49.0).detect(picture).scores) > 0
    assert len(detector(threshold=51.0).detect(picture).scores) == 0


def test_threshold_that_is_no_number_is_refused():
    with pytest.raises(BadInputError, match="nan"):
        detector(threshold=math.nan)


def test_cnn_keeps_or_drops_and_kept_boxes_keep_box_and_score():
    picture = image((60, RED), (204, BLUE))
    without = detector().detect(picture)
    found = detector(Classifier(RedNetwork())).detect(picture)
    assert found_at(without) == [72, 216]
    assert found_at(found) == [72]
    assert ((found.probabilities >= 0.5) & (found.probabilities <= 1.0)).all()
    kept = without.boxes[:, 0] < 140
    np.testing.assert_array_equal(found.boxes, without.boxes[kept])
    np.testing.assert_array_equal(found.scores, without.scores[kept])


def test_least_probability_of_the_classifier_decides():
    picture = image((204, BLUE))
    assert len(detector(Classifier(RedNetwork(), least_probability=0.0)).detect(picture).scores) > 0
    assert len(detector(Classifier(RedNetwork())).detect(picture).scores) == 0
