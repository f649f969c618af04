"""How far one way lies beside another."""

import numpy as np
import pytest

from han_bullet.explain.beside import length_of, shift_between, side_of

STRAIGHT = np.array([[0.0, 0.0], [10.0, 0.0]])
DETOUR = np.array([[0.0, 0.0], [2.0, 0.0], [3.0, 1.0], [5.0, 1.0], [6.0, 0.0], [10.0, 0.0]])


def test_a_detour_to_the_left_is_a_positive_shift_of_its_width_with_its_mean() -> None:
    shift = shift_between(DETOUR, STRAIGHT)
    assert shift is not None
    assert shift.largest == pytest.approx(1.0)
    assert shift.place[1] == pytest.approx(1.0) and 3.0 <= shift.place[0] <= 5.0
    area, length = 3.0, 8.0 + 2.0 * np.sqrt(2.0)  # of the offsets along the detour, which climbs at 45 degrees
    assert shift.mean == pytest.approx((area + 2.0 * 0.5 * (np.sqrt(2.0) - 1.0)) / length, abs=0.01)


def test_a_detour_to_the_right_is_negative() -> None:
    shift = shift_between(DETOUR * [1.0, -1.0], STRAIGHT)
    assert shift is not None and shift.largest == pytest.approx(-1.0)


def test_left_is_that_of_somebody_who_goes_along_the_way() -> None:
    back = shift_between(DETOUR[::-1], STRAIGHT[::-1])
    assert back is not None and back.largest == pytest.approx(-1.0)


def test_a_way_that_is_only_shorter_or_longer_is_not_moved() -> None:
    for one, other in ((STRAIGHT, STRAIGHT[:, :] * 0.5), (STRAIGHT * 0.5, STRAIGHT)):
        shift = shift_between(one, other)
        assert shift is not None and shift.largest == pytest.approx(0.0, abs=1e-12)


def test_nothing_is_beside_a_missing_way_or_a_point() -> None:
    assert shift_between(None, STRAIGHT) is None
    assert shift_between(STRAIGHT, None) is None
    assert shift_between(STRAIGHT, np.zeros((1, 2))) is None


def test_lengths_are_those_of_polylines() -> None:
    assert length_of(DETOUR) == pytest.approx(8.0 + 2.0 * np.sqrt(2.0))
    assert length_of(None) == length_of(np.zeros((1, 2))) == 0.0


def test_the_side_of_a_person_is_the_ways_and_who_is_not_passed_has_none() -> None:
    assert side_of(STRAIGHT, np.array([5.0, 0.8])) == "left"
    assert side_of(STRAIGHT, np.array([5.0, -0.8])) == "right"
    assert side_of(STRAIGHT[::-1], np.array([5.0, -0.8])) == "left"
    assert side_of(STRAIGHT, np.array([11.0, 0.8])) is None
    assert side_of(STRAIGHT, np.array([5.0, 3.5])) is None
    assert side_of(None, np.array([5.0, 0.8])) is None
