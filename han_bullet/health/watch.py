"""From a symptom, now and then there, to a fault with a beginning and an end."""

from __future__ import annotations

from han_bullet.messages import Fault

CLEAR_AFTER = 0.5  # [s] without the symptom until a fault is over: one that flickers is one fault


class Watch:
    """Wait until a symptom has lasted long enough to be a fault, and until it has been away long enough to be none.

    Args:
        sensor: Name, for the fault.
        kind: Of the fault.
        after: How long the symptom lasts before it is one [s].

    Attributes:
        fault: While there is one.
    """

    def __init__(self, sensor: str, kind: str, after: float = 0.0) -> None:
        self.fault: Fault | None = None
        self._sensor, self._kind, self._after = sensor, kind, after
        self._began: float | None = None  # the symptom [s]
        self._last = 0.0  # time of the symptom [s]

    def update(self, symptom: bool, time: float) -> None:
        """Take in whether the symptom shows at a time [s]."""
        if symptom:
            self._began = time if self._began is None else self._began
            self._last = time
            if self.fault is None and time - self._began >= self._after - 1e-9:
                self.fault = Fault(self._sensor, self._kind, time)
        else:
            self._began = None
            if time - self._last >= CLEAR_AFTER - 1e-9:
                self.fault = None
