"""OpenCV's people detector behind our contract."""

from pathlib import Path

import numpy as np
import pytest

from han_bullet.detection.hog_detector import HogDetector
from han_bullet.detection.inria import load_test_photographs
from han_bullet.detection.overlap import intersection_over_union
from han_bullet.detection.pictures import read_picture
from han_bullet.errors import BadInputError


@pytest.mark.parametrize("shape", [(0, 0), (5, 7), (90, 200), (200, 30)])
def test_an_image_smaller_than_the_window_holds_nobody(shape: tuple[int, int]) -> None:
    assert HogDetector(-9.0).detect(np.zeros((*shape, 3), np.uint8)).boxes.shape == (0, 4)


def test_a_hit_threshold_that_is_no_number_is_refused() -> None:
    with pytest.raises(BadInputError, match="nan"):
        HogDetector(float("nan"))


@pytest.mark.data
def test_people_on_photographs_are_found_without_the_windows_margin(data_folder: Path) -> None:
    overlaps, heights = [], []
    for labelled in load_test_photographs(data_folder)[:12]:
        found = HogDetector(-0.5).detect(read_picture(labelled.path))
        assert (np.diff(found.scores) <= 0.0).all() and found.scores.min() >= -0.5
        assert found.boxes[:, 2] == pytest.approx(0.41 * found.boxes[:, 3])
        for person, row in zip(labelled.boxes, intersection_over_union(labelled.boxes, found.boxes), strict=True):
            overlaps.append(row.max(initial=0.0))
            if overlaps[-1] > 0.5:
                heights.append(found.boxes[row.argmax(), 3] / person[3])
    assert np.mean(np.array(overlaps) > 0.5) > 0.6
    assert np.median(heights) == pytest.approx(1.0, abs=0.1)


@pytest.mark.data
def test_a_lower_hit_threshold_finds_the_same_and_more(data_folder: Path) -> None:
    picture = read_picture(load_test_photographs(data_folder)[0].path)
    strict, loose = (HogDetector(t).detect(picture) for t in (0.3, -0.3))
    assert len(loose.scores) > len(strict.scores) > 0
    assert set(strict.scores) <= set(loose.scores)
