"""Greedy suppression of overlapping boxes."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.detection.nms import LARGEST_OVERLAP, suppress

boxes = st.lists(
    st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(1, 60), st.floats(1, 60), st.floats(-9, 9)), max_size=25
).map(lambda rows: np.array(rows, float).reshape(-1, 5))


def overlap(a: np.ndarray, b: np.ndarray) -> float:
    across = min(a[0] + a[2], b[0] + b[2]) - max(a[0], b[0])
    down = min(a[1] + a[3], b[1] + b[3]) - max(a[1], b[1])
    return max(across, 0.0) * max(down, 0.0) / min(a[2] * a[3], b[2] * b[3])


@given(boxes)
def test_kept_boxes_do_not_overlap_and_every_lost_box_overlaps_a_stronger_kept_one(rows: np.ndarray) -> None:
    kept = suppress(rows[:, :4], rows[:, 4])
    assert np.all(np.diff(rows[kept, 4]) <= 0.0)
    for place, one in enumerate(kept):
        assert all(overlap(rows[one], rows[other]) <= LARGEST_OVERLAP + 1e-9 for other in kept[:place])
    for lost in set(range(len(rows))) - set(kept.tolist()):
        assert any(
            rows[other, 4] >= rows[lost, 4] and overlap(rows[lost], rows[other]) > LARGEST_OVERLAP - 1e-9
            for other in kept
        )


def test_a_small_box_inside_a_large_one_goes_though_their_union_is_large() -> None:
    rows = np.array([[0.0, 0.0, 100.0, 100.0], [10.0, 10.0, 20.0, 20.0]])
    assert suppress(rows, np.array([2.0, 1.0])).tolist() == [0]


def test_a_suppressed_box_suppresses_nothing() -> None:
    # The second shares 70 % with the first and with the third; the first and the third share 40 %.
    rows = np.array([[0.0, 0.0, 100.0, 10.0], [30.0, 0.0, 100.0, 10.0], [60.0, 0.0, 100.0, 10.0]])
    assert suppress(rows, np.array([3.0, 2.0, 1.0])).tolist() == [0, 2]


def test_of_equal_scores_the_first_stays() -> None:
    rows = np.array([[0.0, 0.0, 10.0, 10.0], [1.0, 0.0, 10.0, 10.0]])
    assert suppress(rows, np.array([1.0, 1.0])).tolist() == [0]


def test_no_boxes_give_no_boxes() -> None:
    assert suppress(np.empty((0, 4)), np.empty(0)).size == 0
