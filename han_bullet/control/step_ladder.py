"""Steps in order, each for its time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from han_bullet.errors import check_not_negative
from han_bullet.messages import RecoveryStep


def _nothing() -> None:
    return None


@dataclass(frozen=True)
class Rung:
    """One step.

    Attributes:
        step: Its name.
        limit: How long it may take [s]; 0 leaves it out.
        begin: Called once, when it is taken.
    """

    step: RecoveryStep
    limit: float
    begin: Callable[[], None] = _nothing

    def __post_init__(self) -> None:
        """Raise BadInputError for a time that is negative or not finite."""
        check_not_negative(f"recovery step {self.step.name.lower()}", limit=self.limit)


class StepLadder:
    """Take the steps one after the other; after the last, give up.

    Attributes:
        taken: The steps so far, the present one included.
    """

    def __init__(self, *rungs: Rung) -> None:
        self._rungs = tuple(rung for rung in rungs if rung.limit > 0.0)
        self.taken: list[RecoveryStep] = []
        self._since: float | None = None
        self._until = 0.0

    def climb(self, time: float) -> RecoveryStep:
        """Return the step for a time [s], beginning it where it is due."""
        if self._since is None:
            self._since = self._until = time
        while time >= self._until - 1e-9:
            if len(self.taken) == len(self._rungs):
                return RecoveryStep.GIVE_UP
            rung = self._rungs[len(self.taken)]
            self.taken.append(rung.step)
            self._until = time + rung.limit
            rung.begin()
        return self.taken[-1]

    def stay(self, time: float) -> None:
        """Give the present step its whole time again, from now on [s]."""
        if self.taken:
            self._until = time + self._rungs[len(self.taken) - 1].limit

    def leave(self) -> None:
        """Begin anew at the next call."""
        self._since = None
        self.taken.clear()

    def elapsed(self, time: float) -> float:
        """Return for how long it has been climbed at a time [s]."""
        return 0.0 if self._since is None else time - self._since
