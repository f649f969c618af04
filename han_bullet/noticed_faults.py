"""What the robot noticed of its sensors during a run: each fault with its beginning and its end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from han_bullet.episode import Hook, Tick
from han_bullet.messages import Fault


@dataclass(frozen=True)
class NoticedFault:
    """A fault that was noticed.

    Attributes:
        fault: Which, and since when.
        until: When it was noticed to be over [s]; None: not before the end of the run.
    """

    fault: Fault
    until: float | None = None

    def as_json(self) -> dict[str, Any]:
        """Return it as result.json has it."""
        until = None if self.until is None else round(self.until, 6)
        since = round(self.fault.since, 6)
        return {"sensor": self.fault.sensor, "kind": self.fault.kind, "from": since, "until": until}


class NoticedFaults(Hook):
    """Gather them tick by tick."""

    def __init__(self) -> None:
        self._noticed: dict[Fault, float | None] = {}

    @property
    def faults(self) -> tuple[NoticedFault, ...]:
        """Return them in the order in which they were noticed."""
        return tuple(NoticedFault(fault, until) for fault, until in self._noticed.items())

    def record(self, tick: Tick) -> None:
        """Take note of what is wrong at a tick, and of what is no longer."""
        for fault, until in self._noticed.items():
            if until is None and fault not in tick.decision.faults:
                self._noticed[fault] = tick.decision.time
        for fault in tick.decision.faults:
            self._noticed.setdefault(fault, None)
