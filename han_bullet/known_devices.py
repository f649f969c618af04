"""What the robot knows of networked devices: their last states, out of payloads that may be anything."""

from __future__ import annotations

import dataclasses
import logging
from collections import Counter
from collections.abc import Sequence

from han_bullet.device_channel import SIMULATED
from han_bullet.device_payload import read_payload
from han_bullet.errors import BadInputError
from han_bullet.messages import Device, DeviceMessage, Fault

SILENT_AFTER = 3.0  # [s]: devices repeat their state every second, so three messages in a row were lost

_log = logging.getLogger(__name__)


class KnownDevices:
    """Keep each device's last state; never raise over a payload.

    A device has one sender at a time. Its stamps may not go back; another session is another sender, which takes over
    with stamps of its own. Two exceptions: simulated devices of other runs are never listened to (a broker keeps their
    last words), and once a real device has spoken, this run's simulated one of that name is not listened to any more.

    Args:
        devices: Known devices with their assumed first states.
        session: What this run's simulated devices sign with.

    Attributes:
        counts: How many payloads were "new", "repeated", "late", "ignored" (of a sender not listened to), "refused".
    """

    def __init__(self, devices: Sequence[Device] = (), *, session: str = SIMULATED) -> None:
        self.counts = Counter(new=0, repeated=0, late=0, ignored=0, refused=0)
        self._session = session
        self._devices = {device.name: device for device in devices}
        self._last: dict[str, DeviceMessage] = {}
        self._heard_at: dict[str, float] = dict.fromkeys(self._devices, 0.0)
        self._silent: dict[str, Fault] = {}

    @property
    def states(self) -> tuple[Device, ...]:
        """Return every device as it was last heard of."""
        return tuple(self._devices.values())

    @property
    def faults(self) -> tuple[Fault, ...]:
        """Return which devices have been silent for too long."""
        return tuple(self._silent.values())

    def update(self, payloads: Sequence[bytes], time: float) -> bool:
        """Take in what arrived; tell whether some device's state is another now.

        Args:
            payloads: In the order of arrival.
            time: Now [s]; silence is measured by it.
        """
        before, refusals = self.states, list[str]()
        for payload in payloads:
            try:
                kind = self._take(read_payload(payload, self._devices.keys()), time)
            except BadInputError as error:
                kind, refusals = "refused", [*refusals, str(error)]
            self.counts[kind] += 1
        if refusals:  # one line per tick, however many there are
            _log.warning("device messages refused: %d; the first: %s", len(refusals), refusals[0])
        self._watch_for_silence(time)
        return any(old.on != new.on for old, new in zip(before, self.states, strict=True))

    def _take(self, message: DeviceMessage, time: float) -> str:
        """Follow a message unless it is late or not meant; return its kind."""
        last = self._last.get(message.device)
        if self._is_ignored(message, last):
            _log.debug("device %s: sender %r is not listened to", message.device, message.session)
            return "ignored"
        if last is not None and message.session == last.session and message.time < last.time:
            _log.info("device %s: stamp %g s is late, %g s came before", message.device, message.time, last.time)
            return "late"
        if last is not None and message.session != last.session:
            _log.warning("device %s: %s speaks for it now, not %s", message.device, _sender(message), _sender(last))
        self._last[message.device] = message
        self._hear(message.device, time)
        device = self._devices[message.device]
        if last is not None and device.on == message.on:
            _log.debug("device %s: still %s", message.device, _word(message.on))
            return "repeated"
        _log.info("device %s is %s", message.device, _word(message.on))
        if device.on != message.on:
            self._devices[message.device] = dataclasses.replace(device, on=message.on)
        return "new"

    def _is_ignored(self, message: DeviceMessage, last: DeviceMessage | None) -> bool:
        if not message.session.startswith(SIMULATED):
            return False
        taken_over = last is not None and last.session != self._session
        return message.session != self._session or taken_over

    def _hear(self, device: str, time: float) -> None:
        self._heard_at[device] = time
        if device in self._silent:
            del self._silent[device]
            _log.warning("device %s is heard again", device)

    def _watch_for_silence(self, time: float) -> None:
        for device, heard_at in self._heard_at.items():
            if time - heard_at > SILENT_AFTER and device not in self._silent:
                self._silent[device] = Fault(device, "silent", time)
                state = _word(self._devices[device].on)
                _log.warning("device %s is silent for more than %g s; taken to be %s", device, SILENT_AFTER, state)


def _sender(message: DeviceMessage) -> str:
    return repr(message.session) if message.session else "a sender without session"


def _word(on: bool) -> str:
    return "on" if on else "off"
