"""How much boxes overlap."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.detection.overlap import intersection_over_union

SIDES = st.floats(1.0, 300.0)


def test_overlap_of_known_boxes() -> None:
    first = np.array([[0.0, 0.0, 10.0, 20.0]])
    second = np.array([[0.0, 0.0, 10.0, 20.0], [5.0, 0.0, 10.0, 20.0], [2.0, 4.0, 5.0, 8.0], [10.0, 20.0, 5.0, 5.0]])
    assert intersection_over_union(first, second) == pytest.approx(np.array([[1.0, 1.0 / 3.0, 0.2, 0.0]]))


@given(st.tuples(SIDES, SIDES, SIDES, SIDES), st.tuples(SIDES, SIDES, SIDES, SIDES))
def test_overlap_is_symmetric_and_at_most_one(first: tuple[float, ...], second: tuple[float, ...]) -> None:
    a, b = np.array([first]), np.array([second])
    assert intersection_over_union(a, b)[0, 0] == intersection_over_union(b, a)[0, 0]
    assert 0.0 <= intersection_over_union(a, b)[0, 0] <= 1.0 + 1e-12


def test_no_boxes_overlap_nothing_and_two_without_area_not_each_other() -> None:
    box = np.array([[0.0, 0.0, 10.0, 20.0]])
    assert intersection_over_union(np.empty((0, 4)), box).shape == (0, 1)
    assert intersection_over_union(np.zeros((1, 4)), np.zeros((1, 4))).tolist() == [[0.0]]
