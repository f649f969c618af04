"""The network between devices and robot: what devices publish arrives as bytes; the default is inside the process."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque

SIMULATED = "simulator"  # sessions of simulated devices begin with this; nobody else's may
MOST_WAITING = 1000  # payloads between two ticks; of a flood the newest are kept


class DeviceChannel(ABC):
    """Carries payloads (`device_payload`) of devices to the robot.

    Attributes:
        session: What simulated devices on this channel sign with, to tell them from another run's.
        name: For results.
    """

    name: str
    session: str

    @abstractmethod
    def publish(self, device: str, payload: bytes) -> None:
        """Send a device's state; it may get lost."""

    @abstractmethod
    def receive(self) -> tuple[bytes, ...]:
        """Return what has arrived since the last call, oldest first, whoever sent it; never waits."""


class EmbeddedChannel(DeviceChannel):
    """A network without a server or delay: what is published is there at the next `receive`."""

    name, session = "embedded", SIMULATED

    def __init__(self) -> None:
        self._waiting: deque[bytes] = deque(maxlen=MOST_WAITING)

    def publish(self, device: str, payload: bytes) -> None:
        """Keep the payload until it is asked for."""
        self._waiting.append(payload)

    def receive(self) -> tuple[bytes, ...]:
        """Return and forget what was published."""
        payloads = tuple(self._waiting)
        self._waiting.clear()
        return payloads
