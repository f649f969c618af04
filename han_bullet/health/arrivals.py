"""Whether what a sensor sends at a steady rate arrives, and arrives in time."""

from __future__ import annotations

from collections import deque

SILENT_PERIODS = 3  # without anything is silence
LOOK_BACK = 2.0  # [s] over which the share of what is lost is counted
MOST_LOST = 0.2  # share of it that is a fault: more than one in five
FEW_LOST = 0.1  # share of it with which such a fault is over
LATE_AFTER = 0.15  # [s] between taking and arriving


class Arrivals:
    """Count what came and what should have come.

    Args:
        period: Between two of them [s].
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._taken: deque[float] = deque()  # times at which what came was taken, of the last `LOOK_BACK` [s]
        self._last: float | None = None  # arrival [s]; None: nothing yet
        self._late = self._lossy = False

    def note(self, taken: float, time: float) -> None:
        """Take note that something arrives at a time [s] that was taken at another [s]."""
        self._last = time
        self._late = time - taken > LATE_AFTER + 1e-6
        self._taken.append(taken)
        while self._taken[0] < self._taken[-1] - LOOK_BACK + 0.5 * self._period:
            self._taken.popleft()
        expected = max(min(LOOK_BACK, taken + self._period) / self._period, 1.0)  # it may be older than the run
        self._lossy = 1.0 - len(self._taken) / expected > (FEW_LOST if self._lossy else MOST_LOST) + 1e-6

    @property
    def late(self) -> bool:
        """Tell whether the last arrival was late."""
        return self._late

    def silent(self, time: float) -> bool:
        """Tell whether nothing has arrived for too long, at a time [s]; the run begins at 0."""
        return time - (self._last or 0.0) > SILENT_PERIODS * self._period - 1e-6

    @property
    def lossy(self) -> bool:
        """Tell whether too many of the last ones are missing; of late ones those count that were taken by then."""
        return self._lossy
