"""Somebody drives the robot: what they want counts until it is too old."""

from __future__ import annotations

import math

from han_bullet.errors import BadInputError
from han_bullet.geometry import Twist2D

HOLD = 0.5  # [s]: senders of 10 Hz may lose a few; who lets go of the stick is obeyed soon enough


class Teleoperation:
    """Keep the last command of somebody who drives; without another it ends by itself."""

    def __init__(self) -> None:
        self._wanted: Twist2D | None = None
        self._hold = 0.0
        self._until: float | None = None  # None: not asked for yet

    @property
    def active(self) -> bool:
        """Tell whether somebody drives, as of the last command or question."""
        return self._wanted is not None

    def take(self, wanted: Twist2D, hold: float = HOLD) -> None:
        """Take a command, for the next control period and so much longer [s].

        Raises:
            BadInputError: A number is not finite, or the time is negative.
        """
        numbers = (wanted.vx, wanted.vy, wanted.omega)
        if not all(map(math.isfinite, numbers)):
            raise BadInputError(f"command to drive is {numbers}; three finite numbers, m/s and rad/s, would be right")
        if not 0.0 <= hold < math.inf:
            raise BadInputError(f"hold of a command to drive is {hold!r} s; a number >= 0 would be right")
        self._wanted, self._hold, self._until = wanted, hold, None

    def at(self, time: float) -> Twist2D | None:
        """Return what is wanted at a time [s]; None where nobody drives."""
        if self._until is None:
            self._until = time + self._hold
        if time > self._until + 1e-9:
            self.release()
        return self._wanted

    def release(self) -> None:
        """Let nobody drive."""
        self._wanted = None
