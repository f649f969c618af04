"""All sensors of the robot: what is wrong with them, which frames are of use, and how fast it may go."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from han_bullet.health.arrivals import SILENT_PERIODS
from han_bullet.health.camera_health import CameraHealth
from han_bullet.health.laser_health import LaserHealth
from han_bullet.health.wheel_health import WheelHealth
from han_bullet.messages import (
    Fault,
    FrameDetections,
    LegScan,
    Observation,
    PoseEstimate,
    Scan,
    Seat,
    TrackedPerson,
)
from han_bullet.world_schema import Slip

# [rad]: deviation of the robot's heading with which its camera may be judged; else the heading may be what is off. In
# the runs looked at, by laser, it was below 0.5 degrees.
SURE_OF_HEADING = math.radians(0.6)
BY_LASER_ALONE = 0.3  # part of its speed: legs show at 8 m, but not who walks where
BY_CAMERAS_ALONE = 0.5  # nothing brakes for what they do not show

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class HealthReport:
    """What is known of the sensors at one tick.

    Attributes:
        faults: All that is wrong now, in the order of the sensors.
        usable: Of each frame of the tick, whether its picture is of use; see `SensorHealth.aligned`, too.
        blind: Cameras that have given no frame of use for three periods, whatever the reason.
        speed_factor: How fast the robot may go, as a part of its usual speed; 0 where no sensor works.
    """

    faults: tuple[Fault, ...]
    usable: tuple[bool, ...]
    blind: tuple[str, ...]
    speed_factor: float


class SensorHealth:
    """Watch what the sensors send; name each fault, and its end, once in the log.

    A late frame is used at its own time if nothing newer has been used, as when all cameras are late alike: the tracker
    takes its scans in the order of their times, and one that comes after newer ones would be placed wrongly by as far
    as people walk meanwhile.

    Args:
        periods: Name of each camera -> between its frames [s].
        noisy: Whether images have noise.
        laser: Between its scans [s]; None: the robot has none, or nobody knows.
        slip: The usual one of the wheels; None: nobody watches them.
        seats: Where people may sit.
    """

    def __init__(
        self,
        periods: dict[str, float] | None = None,
        *,
        noisy: bool = True,
        laser: float | None = None,
        slip: Slip | None = None,
        seats: Sequence[Seat] = (),
    ) -> None:
        self._periods = dict(periods or {})
        self._cameras = {
            name: CameraHealth(name, period, noisy=noisy, seats=seats) for name, period in self._periods.items()
        }
        self._laser = None if laser is None else LaserHealth(laser)
        self._wheels = None if slip is None else WheelHealth(slip)
        self._faults: tuple[Fault, ...] = ()
        self._newest_used = -float("inf")  # exposure [s]
        self._used_at = dict.fromkeys(self._periods, 0.0)  # [s]
        self._sure_of_heading = True
        self._others: dict[str, Scan | LegScan] = {}  # the last of each fixed camera and of the laser

    def update(
        self, observation: Observation, estimate: PoseEstimate, detections: Sequence[FrameDetections]
    ) -> HealthReport:
        """Take in a tick: what the robot observes, where it believes to be, and the detections, one per image."""
        time = observation.time
        usable = [self._take(found, time) for found in detections]
        for camera in self._cameras.values():
            camera.close_tick(time)
        used = (found for found, use in zip(detections, usable, strict=True) if use and self._aligned(found.camera))
        self._sure_of_heading = bool(estimate.covariance[2, 2] <= SURE_OF_HEADING**2)
        self._newest_used = max([self._newest_used, *(found.time for found in used)])
        feels = self._laser is not None and self._laser.update(observation.laser, time)
        if self._wheels is not None:
            self._wheels.update(estimate, observation.odometry.pose_robot_in_odom)
        faults = tuple(fault for sensor in self._sensors() for fault in sensor.faults)
        _tell(self._faults, faults, time)
        self._faults = faults
        longest = {name: SILENT_PERIODS * period + 1e-6 for name, period in self._periods.items()}
        blind = tuple(name for name, used_at in self._used_at.items() if time - used_at > longest[name])
        return HealthReport(faults, tuple(usable), blind, self._speed_factor(blind, feels=feels))

    def aligned(self, scans: Sequence[Scan], legs: LegScan | None, people: Sequence[TrackedPerson]) -> tuple[Scan, ...]:
        """Return the scans of a tick, after `update`, without those of cameras that look elsewhere than they should.

        Args:
            scans: Of the frames that are of use.
            legs: What the laser says.
            people: Who is known.
        """
        self._others |= {scan.camera: scan for scan in scans if scan.frame.fixed}
        if legs is not None:
            self._others[legs.camera] = legs
        for scan in scans:
            if self._sure_of_heading and not scan.frame.fixed and scan.camera in self._cameras:
                self._cameras[scan.camera].alignment.compare(scan, tuple(self._others.values()), people)
        return tuple(scan for scan in scans if self._aligned(scan.camera))

    def _aligned(self, camera: str) -> bool:
        """Tell whether a camera looks where it should, as far as anybody knows."""
        return camera not in self._cameras or self._cameras[camera].alignment.fault is None

    def _sensors(self) -> Iterator[CameraHealth | LaserHealth | WheelHealth]:
        yield from self._cameras.values()
        if self._laser is not None:
            yield self._laser
        if self._wheels is not None:
            yield self._wheels

    def _speed_factor(self, blind: Sequence[str], *, feels: bool) -> float:
        """Return how fast the robot may go with the cameras that are not blind, and a laser that works or none."""
        if self._periods and len(blind) == len(self._periods):
            return BY_LASER_ALONE if feels else 0.0
        return 1.0 if feels or self._laser is None else BY_CAMERAS_ALONE

    def _take(self, found: FrameDetections, time: float) -> bool:
        """Take in a frame; tell whether it may be used."""
        camera = self._cameras.get(found.camera)
        usable = (camera is None or camera.take(found, time)) and found.time >= self._newest_used - 1e-6
        if usable and camera is not None and self._aligned(found.camera):
            self._used_at[found.camera] = time
        return usable


def _tell(before: Sequence[Fault], now: Sequence[Fault], time: float) -> None:
    for fault in now:
        if fault not in before:
            _log.warning("%s: %s, noticed at %.2f s", fault.sensor, fault.kind, fault.since)
    for fault in before:
        if fault not in now:
            _log.warning("%s: no longer %s, noticed at %.2f s", fault.sensor, fault.kind, time)
