"""How much plans change."""

import numpy as np
import pytest
from ticks import tick

from han_bullet.messages import Path
from han_bullet.metrics.plans import PlanTally, path_change

STRAIGHT = np.array([[0.0, 0.0], [4.0, 0.0]])


def test_equal_ways_are_not_apart_wherever_their_points_lie() -> None:
    assert path_change(STRAIGHT, np.array([[0.0, 0.0], [1.3, 0.0], [4.0, 0.0]])) == pytest.approx(0.0)


def test_the_change_is_the_largest_distance_between_the_ways() -> None:
    # The new way leaves by 0.6 m to the side at x = 2; the point there is 0.6 m from the old one.
    bent = np.array([[0.0, 0.0], [2.0, 0.6], [4.0, 0.0]])
    assert path_change(STRAIGHT, bent) == pytest.approx(0.6, abs=0.03)
    assert path_change(bent, STRAIGHT) == pytest.approx(0.6, abs=0.03)


def test_what_lies_behind_the_robot_and_beyond_the_shorter_way_is_no_change() -> None:
    assert path_change(STRAIGHT, np.array([[1.05, 0.0], [4.0, 0.0]])) == pytest.approx(0.0, abs=1e-9)
    assert path_change(STRAIGHT, np.array([[1.0, 0.0], [2.0, 0.0]])) == pytest.approx(0.0, abs=1e-9)
    assert path_change(np.array([[0.0, 0.0], [2.0, 0.0]]), STRAIGHT) == pytest.approx(0.0, abs=1e-9)


def test_a_way_of_one_point_has_nothing_to_change() -> None:
    assert path_change(STRAIGHT, STRAIGHT[:1]) == pytest.approx(0.0)


def test_searches_are_counted_and_their_changes_and_the_large_ones() -> None:
    small, large = np.array([[0.0, 0.4], [4.0, 0.4]]), np.array([[0.0, 1.0], [4.0, 1.0]])
    tally = PlanTally()
    ways = [(STRAIGHT, 9), (large, 0), (small, 9), (None, 0), (large, 9)]  # the second was kept, not searched for
    for index, (way, expanded) in enumerate(ways):
        tally.record(tick(index, path=None if way is None else Path(way, 1.0, expanded)))
    values = tally.values()
    assert values["replans"] == 3
    assert values["path_change_mean"] == pytest.approx((0.4 + 0.6) / 2.0)
    assert values["path_switches"] == 1


def test_one_search_has_no_change() -> None:
    tally = PlanTally()
    tally.record(tick(0, path=Path(STRAIGHT, 1.0, 9)))
    assert tally.values() == {"replans": 1, "path_change_mean": None, "path_switches": 0}
