"""Networked devices: a television that goes on and says so."""

from __future__ import annotations

from han_bullet.device_channel import DeviceChannel
from han_bullet.device_payload import write_payload
from han_bullet.messages import DeviceMessage
from han_bullet.sim.trigger import RobotNow, StartSignal
from han_bullet.world_schema import TV

REPEAT_PERIOD = 1.0  # [s]: a state that got lost is known at most this much later


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
        self._told: bool | None = None
        self._told_at = 0.0

    def advance(self, robot: RobotNow) -> None:
        """Go on when it is time."""
        if self._signal is not None and self._signal.given(robot, self._position):
            self.on = True

    def tell(self, time: float, channel: DeviceChannel, *, lost: bool = False) -> None:
        """Publish the state when it is new, and again every second; what is lost on the way, it does not know."""
        if self.on != self._told or time >= self._told_at + REPEAT_PERIOD - 1e-9:
            self._told, self._told_at = self.on, time
            if lost:
                return
            channel.publish(self.name, write_payload(DeviceMessage(self.name, time, self.on, channel.session)))
