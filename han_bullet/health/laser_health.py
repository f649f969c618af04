"""Whether the laser scanner's scans come."""

from __future__ import annotations

from han_bullet.health.arrivals import Arrivals
from han_bullet.health.watch import Watch
from han_bullet.messages import Fault, LaserScan


class LaserHealth:
    """Watch the laser.

    Args:
        period: Between two scans [s].
    """

    def __init__(self, period: float) -> None:
        self._arrivals = Arrivals(period)
        self._dropped = Watch("laser", "dropped")

    @property
    def faults(self) -> tuple[Fault, ...]:
        """Return what is wrong now."""
        return () if self._dropped.fault is None else (self._dropped.fault,)

    def update(self, scan: LaserScan | None, time: float) -> bool:
        """Take in what a tick brings; tell whether scans have come of late."""
        if scan is not None:
            self._arrivals.note(scan.time, time)
        silent = self._arrivals.silent(time)
        self._dropped.update(silent or self._arrivals.lossy, time)
        return not silent
