"""All sensors of the robot: what is wrong with them, which frames are of use, and how fast it may go."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass

from han_bullet.health.arrivals import SILENT_PERIODS
from han_bullet.health.camera_health import CameraHealth
from han_bullet.messages import Fault, FrameDetections, Observation

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class HealthReport:
    """What is known of the sensors at one tick.

    Attributes:
        faults: All that is wrong now, in the order of the sensors.
        usable: Of each frame of the tick, whether it may be used.
        speed_factor: How fast the robot may go, as a part of its usual speed; 0 where no sensor works.
    """

    faults: tuple[Fault, ...]
    usable: tuple[bool, ...]
    speed_factor: float


class SensorHealth:
    """Watch what the sensors send; name each fault, and its end, once in the log.

    A late frame is used at its own time if nothing newer has been used, as when all cameras are late alike: the tracker
    takes its scans in the order of their times, and one that comes after newer ones would be placed wrongly by as far
    as people walk meanwhile.

    Args:
        periods: Name of each camera -> between its frames [s].
        noisy: Whether images have noise.
    """

    def __init__(self, periods: dict[str, float] | None = None, *, noisy: bool = True) -> None:
        self._periods = dict(periods or {})
        self._cameras = {name: CameraHealth(name, period, noisy=noisy) for name, period in self._periods.items()}
        self._faults: tuple[Fault, ...] = ()
        self._newest_used = -float("inf")  # exposure [s]
        self._used_at = dict.fromkeys(self._periods, 0.0)  # [s]

    def update(self, observation: Observation, detections: Sequence[FrameDetections]) -> HealthReport:
        """Take in a tick: what the robot observes, and the detections, one per frame of it."""
        time = observation.time
        usable = [self._take(found, time) for found in detections]
        for camera in self._cameras.values():
            camera.close_tick(time)
        used = [found.time for found, use in zip(detections, usable, strict=True) if use]
        self._newest_used = max([self._newest_used, *used])
        faults = tuple(fault for camera in self._cameras.values() for fault in camera.faults)
        _tell(self._faults, faults, time)
        self._faults = faults
        return HealthReport(faults, tuple(usable), self._speed_factor(time))

    def _speed_factor(self, time: float) -> float:
        """Return 0 where cameras are needed and none has given a frame of use of late."""
        sees = any(time - self._used_at[name] <= SILENT_PERIODS * p + 1e-6 for name, p in self._periods.items())
        return 1.0 if sees or not self._periods else 0.0

    def _take(self, found: FrameDetections, time: float) -> bool:
        """Take in a frame; tell whether it may be used."""
        camera = self._cameras.get(found.camera)
        usable = (camera is None or camera.take(found, time)) and found.time >= self._newest_used - 1e-6
        if usable:
            self._used_at[found.camera] = time
        return usable


def _tell(before: Sequence[Fault], now: Sequence[Fault], time: float) -> None:
    for fault in now:
        if fault not in before:
            _log.warning("%s is %s, noticed at %.2f s", fault.sensor, fault.kind, fault.since)
    for fault in before:
        if fault not in now:
            _log.warning("%s is no longer %s, noticed at %.2f s", fault.sensor, fault.kind, time)
