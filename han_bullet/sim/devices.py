"""Networked devices: a television that goes on and says so."""

from __future__ import annotations

from han_bullet.messages import DeviceMessage
from han_bullet.sim.trigger import RobotNow, StartSignal
from han_bullet.world_schema import TV


class Television:
    """A television; once its trigger has come it is on for good.

    Attributes:
        name: As in the world file.
        on: Whether it is on.
    """

    def __init__(self, tv: TV) -> None:
        self.name, self.on = tv.name, tv.on
        self._position = tv.position
        self._signal = StartSignal(tv.turns_on) if tv.turns_on is not None else None
        self._announced: bool | None = None

    def advance(self, robot: RobotNow) -> None:
        """Go on when it is time."""
        if self._signal is not None and self._signal.given(robot, self._position):
            self.on = True

    def messages(self, time: float) -> tuple[DeviceMessage, ...]:
        """Return what the device sends now: its state when that is new, else nothing."""
        if self.on == self._announced:
            return ()
        self._announced = self.on
        return (DeviceMessage(self.name, time, self.on),)
