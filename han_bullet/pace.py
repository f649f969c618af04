"""A loop no faster than the clock on the wall, for people who watch."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from han_bullet.episode import Hook, Tick
from han_bullet.errors import BadInputError
from han_bullet.world_schema import CONTROL_PERIOD


class Pace(Hook):
    """Let every tick take at least its time; what the loop has lost it does not hurry to make up for.

    Args:
        factor: So many times as fast as real time at most.
        clock: Returns the time [s].
        sleep: Waits for so long [s].
    """

    def __init__(
        self,
        factor: float = 1.0,
        *,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        if not 0.0 < factor < math.inf:
            raise BadInputError(f"pace is {factor!r} times real time; a positive number would be right")
        self._period = CONTROL_PERIOD / factor
        self._clock, self._sleep = clock, sleep
        self._due = -math.inf  # when this tick may end, by the clock [s]

    def record(self, tick: Tick) -> None:
        """Sleep off what is left of a tick; the first, before which nothing moved, takes no time."""
        now = self._clock()
        if self._due > now:
            self._sleep(self._due - now)
        self._due = max(self._due, now) + self._period
