"""The pace of a loop, by a clock of the test's own."""

import pytest
from ticks import tick

from han_bullet.errors import BadInputError
from han_bullet.pace import Pace


class Clock:
    """Stands still but for sleep and work."""

    def __init__(self) -> None:
        self.now = 100.0
        self.slept: list[float] = []

    def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        self.now += seconds


def walked(work: list[float], factor: float = 1.0) -> Clock:
    """The clock after a loop whose ticks work for so long [s]."""
    clock = Clock()
    pace = Pace(factor, clock=lambda: clock.now, sleep=clock.sleep)
    for number, seconds in enumerate(work):
        clock.now += seconds
        pace.record(tick(number))
    return clock


def test_what_is_left_of_each_tick_is_slept_off() -> None:
    clock = walked([3.0, 0.01, 0.02, 0.0])
    assert clock.slept == pytest.approx([0.04, 0.03, 0.05])  # nothing moved before the first
    assert clock.now == pytest.approx(103.0 + 3 * 0.05)


def test_twice_as_fast_as_real_time_leaves_half_the_time() -> None:
    assert walked([0.0, 0.01, 0.02], factor=2.0).slept == pytest.approx([0.015, 0.005])


def test_what_a_slow_tick_lost_the_next_ones_do_not_hurry_to_make_up_for() -> None:
    clock = walked([0.0, 0.5, 0.01, 0.01])
    assert clock.slept == pytest.approx([0.04, 0.04])


@pytest.mark.parametrize("factor", [0.0, -1.0, float("nan"), float("inf")])
def test_a_pace_that_is_none_is_refused(factor: float) -> None:
    with pytest.raises(BadInputError, match=r"pace is .* times real time; a positive number"):
        Pace(factor)
