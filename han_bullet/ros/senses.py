"""The senses of a real robot: messages as they come from ROS, made into one observation per control tick."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from typing import Any

from han_bullet.errors import BadInputError
from han_bullet.messages import CameraImage, LaserScan, Odometry
from han_bullet.ros.live_setup import LiveCamera, LiveSetup
from han_bullet.ros.message_types import deserialize, seconds
from han_bullet.ros.sensor_readings import read_image, read_odometry, read_scan
from han_bullet.world_schema import CONTROL_PERIOD

APART = 2.0  # [s] between a message's stamp and odometry's: more, and their clocks do not agree, or it comes too late
EARLY = 0.1  # of a period: stamps tremble by so much
_NUMBER = re.compile(r"[-+]?(\d[\d.]*(e[-+]?\d+)?|inf|nan)")


class Senses:
    """Take what comes in, refuse what cannot be used, and keep the newest of each sensor until a tick is due.

    The loop's clock begins at 0 with the first odometry; `epoch` is that moment on the robot's clock.

    Args:
        setup: The robot's.
        see: Takes an image that may be looked at.
        complain: Takes a sentence on what is wrong; each is said once.

    Attributes:
        topics: To listen to, with their types.
        epoch: [s]; None before the first odometry.
        refused: Topic -> how many of its messages were refused.
    """

    def __init__(self, setup: LiveSetup, see: Callable[[CameraImage], None], complain: Callable[[str], None]) -> None:
        self.epoch: float | None = None
        self.refused: Counter[str] = Counter()
        self._setup, self._see, self._complain = setup, see, complain
        self._said: set[tuple[str, str]] = set()
        self._cameras = {camera.topic: camera for camera in setup.cameras}
        self._last: dict[str, float] = {}  # topic -> stamp of the last message that was taken, on the loop's clock
        self._odometry: Odometry | None = None
        self._scan: LaserScan | None = None
        self._due = 0.0
        self.topics = {setup.odometry: "nav_msgs/Odometry"}
        self.topics |= dict.fromkeys(self._cameras, "sensor_msgs/Image")
        if setup.laser is not None:
            self.topics[setup.laser] = "sensor_msgs/LaserScan"

    def take(self, topic: str, raw: bytes) -> bool:
        """Take a message; tell whether it was of use."""
        try:
            message = deserialize(self.topics[topic], raw)
            return self._take(topic, message)
        except BadInputError as error:
            self.refused[topic] += 1
            reason = str(error)
            if (topic, _NUMBER.sub("#", reason)) not in self._said:
                self._said.add((topic, _NUMBER.sub("#", reason)))
                self._complain(f"{topic}: {reason}; such messages are not used")
            return False

    def tick(self) -> Odometry | None:
        """Return the newest odometry once it is a control period later than that of the last tick."""
        odometry = self._odometry
        if odometry is None or odometry.time < self._due - EARLY * CONTROL_PERIOD:
            return None
        late = odometry.time - self._due
        self._due = odometry.time + CONTROL_PERIOD if late > CONTROL_PERIOD else self._due + CONTROL_PERIOD
        self._odometry = None
        return odometry

    def scan(self) -> LaserScan | None:
        """Return the newest scan, once."""
        scan, self._scan = self._scan, None
        return scan

    def _take(self, topic: str, message: Any) -> bool:
        if topic == self._setup.odometry:
            return self._take_odometry(topic, message)
        if self.epoch is None:  # nothing has a time yet
            return False
        time = self._time(topic, message)
        if topic == self._setup.laser:
            self._scan = read_scan(message, time, self._setup.scanner_in_body)
            self._last[topic] = time
            return True
        return self._take_image(self._cameras[topic], message, time)

    def _take_odometry(self, topic: str, message: Any) -> bool:
        stamp = seconds(message.header.stamp)
        odometry = read_odometry(message, stamp - (stamp if self.epoch is None else self.epoch))
        last = self._last.get(topic)
        if last is not None and odometry.time <= last:
            raise BadInputError(
                f"odometry goes from {last:g} s back to {odometry.time:g} s; growing stamps would be right"
            )
        self.epoch = stamp if self.epoch is None else self.epoch
        self._last[topic] = odometry.time
        self._odometry = odometry
        return True

    def _take_image(self, camera: LiveCamera, message: Any, time: float) -> bool:
        mounted, last = camera.mounted, self._last.get(camera.topic)
        if last is not None and time - last < (1.0 - EARLY) * camera.period:
            return False  # more often than anybody looks
        image = read_image(message, mounted.intrinsics)
        if camera.calibration is not None:
            image = camera.calibration.undistort(image)
        self._last[camera.topic] = time
        self._see(CameraImage(mounted.name, time, image, mounted.intrinsics, mounted.mount, mounted.fixed))
        return True

    def _time(self, topic: str, message: Any) -> float:
        """Return when a sensor's message was taken, on the loop's clock [s]."""
        assert self.epoch is not None
        time = seconds(message.header.stamp) - self.epoch
        last, now = self._last.get(topic), self._last[self._setup.odometry]
        if abs(time - now) > APART:
            raise BadInputError(f"stamp is {time - now:+.3f} s from odometry's; at most {APART:g} s would be right")
        if last is not None and time <= last:
            raise BadInputError(f"stamp goes from {last:g} s back to {time:g} s; growing ones would be right")
        return time
