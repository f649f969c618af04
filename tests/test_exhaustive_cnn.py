"""The search of a whole image with the CNN, as the benchmark times it."""

import numpy as np
import pytest

from benchmarks.exhaustive_cnn import PAPER_SECONDS, Search, both_stages, lines, search
from han_bullet.detection.cnn import Classifier
from han_bullet.detection.stages import Stages
from han_bullet.messages import Detections

IMAGE = np.random.default_rng(0).integers(0, 256, (480, 640, 3), np.uint8)


class Witness(Classifier):
    """Remembers the first and the last pixel of each window it is shown."""

    def __init__(self) -> None:
        self.least_probability, self.size = 0.5, (112, 56)
        self.corners: list[tuple[int, ...]] = []
        self.boxes = 0

    def probabilities_of_crops(self, crops: np.ndarray) -> np.ndarray:
        assert crops.shape[1:] == (112, 56, 3)
        self.corners += [(*crop[0, 0], *crop[-1, -1]) for crop in crops]
        return np.zeros(len(crops))

    def probabilities(self, image: np.ndarray, boxes: np.ndarray) -> np.ndarray:
        self.boxes = len(boxes)
        return np.zeros(len(boxes))


def test_every_window_of_the_image_is_shown_once() -> None:
    witness = Witness()
    found = search(witness, IMAGE, most_seconds=np.inf)
    assert (found.rows, found.columns, found.measured) == (93, 147, 93 * 147)
    expected = {(*IMAGE[y, x], *IMAGE[y + 111, x + 55]) for y in range(0, 480 - 111, 4) for x in range(0, 640 - 55, 4)}
    shown = witness.corners[147:]  # the first row was a trial
    assert len(shown) == 93 * 147 and set(shown) == expected


def test_a_search_ends_with_the_row_in_which_its_time_is_over() -> None:
    assert search(Witness(), IMAGE, most_seconds=0.0).measured == 147


def test_the_table_has_the_paper_s_arithmetic_and_the_whole_image() -> None:
    table = lines(Search(93, 147, 1470, 2.94), proposals=3, seconds=0.025)
    assert [row[1] for row in table] == [250, 15225, 240, 13671, 3]
    assert table[0][2:] == pytest.approx((250 * PAPER_SECONDS, 0.1238), rel=1e-3)
    assert table[2][2:] == pytest.approx((0.48, 1 / 0.48))
    assert table[3][2:] == pytest.approx((27.342, 1 / 27.342))
    assert table[4][2:] == pytest.approx((0.025, 40.0))


def test_only_proposals_above_the_threshold_reach_the_network() -> None:
    witness = Witness()
    found = Detections(np.zeros((3, 4)), np.array([50.0, 40.0, 39.9]), np.ones(3))
    stages = Stages("ACF", "made up", lambda image: found, 40.0, witness)
    proposals, seconds = both_stages(stages, IMAGE)
    assert (proposals, witness.boxes) == (2, 2)
    assert seconds > 0.0
