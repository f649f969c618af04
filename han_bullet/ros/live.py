"""The loop on a real robot: each odometry that is due is a tick, its decision a command; silence stops the robot."""

from __future__ import annotations

import logging
import time
from collections import deque
from collections.abc import Callable

from han_bullet.detection_workers import DetectionWorkers
from han_bullet.device_channel import DeviceChannel
from han_bullet.errors import WorkerDiedError
from han_bullet.geometry import Twist2D
from han_bullet.messages import Observation, Odometry, Status
from han_bullet.ros.link import Incoming, Link
from han_bullet.ros.live_setup import LiveSetup
from han_bullet.ros.live_topics import LiveTopics
from han_bullet.ros.orders import RosOrders
from han_bullet.ros.robot_messages import twist_message
from han_bullet.ros.senses import Senses
from han_bullet.ros.slow_loop import SlowLoop
from han_bullet.stack import Decision, NavigationStack
from han_bullet.world_schema import CONTROL_PERIOD

TWIST = "geometry_msgs/Twist"
SILENT = 0.5  # [s] by the wall clock without odometry until the robot is told to stop
GAP = 3.0 * CONTROL_PERIOD  # [s] between two ticks that is worth a word
POLLED_EVERY = 0.004  # [s]
SENT_WITHIN = 0.3  # [s] for the last command to leave the node, before that ends
ODOMETRIES = 10  # that may wait for this loop
MOST_ORDERS = 32  # between two ticks; older ones are forgotten

_log = logging.getLogger(__name__)


class LiveLoop:
    """Drive a robot by what comes from ROS.

    Args:
        setup: The robot's.
        stack: Its detector is `eyes`.
        eyes: Look for people while the loop goes on.
        link: To ROS.
        topics: Tell ROS what was decided.
        devices: Brings what devices say, by their own network or by ROS.
    """

    def __init__(
        self,
        setup: LiveSetup,
        stack: NavigationStack,
        eyes: DetectionWorkers,
        link: Link,
        topics: LiveTopics,
        devices: DeviceChannel,
    ) -> None:
        self._setup, self._stack, self._eyes, self._link, self._topics = setup, stack, eyes, link, topics
        self._devices = devices
        self._senses = Senses(setup, eyes.offer, lambda sentence: self._say("warn", sentence))
        self._slow_loop = SlowLoop(stack, setup.world.robot)
        self._orders = RosOrders(link, setup.goal)
        self._orders.begin(setup.world, stack, devices)
        self._ordered: deque[Incoming] = deque(maxlen=MOST_ORDERS)
        self._heard_at: float | None = None  # odometry, by the wall clock [s]
        self._ticked_at: float | None = None  # by the loop's clock [s]
        self._status: Status | None = None
        self._gave_up = self._said_gap = False
        link.advertise(setup.command, TWIST)
        for topic, kind in self._senses.topics.items():
            link.subscribe(topic, kind, size=ODOMETRIES if topic == setup.odometry else 1)

    def run(self, ended: Callable[[], bool]) -> None:
        """Drive until told to end; whatever happens, the robot is told to stop at last.

        Raises:
            WorkerDiedError: A worker has ended, or somebody has ended the ROS node.
        """
        self._say("info", f"waits for {self._setup.odometry}")
        try:
            while not ended():
                self._turn()
                time.sleep(POLLED_EVERY)
        finally:
            self._command(Twist2D())
            for topic, count in self._senses.refused.items():
                _log.warning("%s: %d messages were not used", topic, count)
            time.sleep(SENT_WITHIN)

    def _turn(self) -> None:
        """Take in what has come, and decide if a tick is due."""
        if self._link.ended is not None:
            raise WorkerDiedError(f"the ROS node was told to end ({self._link.ended})")
        for incoming in self._link.received():
            if incoming.name not in self._senses.topics:
                self._ordered.append(incoming)
            elif self._senses.take(incoming.name, incoming.raw) and incoming.name == self._setup.odometry:
                self._hear()
        self._eyes.advance()
        odometry = self._senses.tick()
        if odometry is not None:
            self._tick(odometry)
        elif self._heard_at is not None and time.monotonic() - self._heard_at > SILENT:
            self._heard_at = None
            self._command(Twist2D())
            self._say("error", f"no odometry on {self._setup.odometry} for {SILENT:g} s: the robot is told to stop")

    def _hear(self) -> None:
        if self._heard_at is None:
            self._say("info", f"odometry comes on {self._setup.odometry}")
        self._heard_at = time.monotonic()

    def _tick(self, odometry: Odometry) -> None:
        self._note_gap(odometry.time)
        images, spoken = self._eyes.finished(), self._devices.receive()
        observation = Observation(odometry.time, odometry, self._senses.scan(), images, spoken)
        decision = self._stack.step(observation)
        self._command(decision.command)
        self._note_status(decision)
        self._obey(decision)
        assert self._senses.epoch is not None
        self._topics.tell(observation, decision, self._senses.epoch)

    def _obey(self, decision: Decision) -> None:
        """Give the stack the orders that have come, for the next tick."""
        while self._ordered:
            self._orders.obey(self._ordered.popleft(), decision)
        self._orders.repeat(decision)

    def _command(self, twist: Twist2D) -> None:
        self._link.publish(self._setup.command, twist_message(twist))

    def _note_gap(self, now: float) -> None:
        """Drive by how far apart ticks are, and say once that it is too far, as by a slow odometry or machine."""
        gap = 0.0 if self._ticked_at is None else now - self._ticked_at
        self._ticked_at = now
        self._slow_loop.note(gap)
        if gap > GAP and not self._said_gap:
            self._said_gap = True
            self._say("warn", f"{gap:.2f} s between two ticks, {CONTROL_PERIOD:g} s would be right; more is not told")

    def _note_status(self, decision: Decision) -> None:
        if decision.gave_up is not None and not self._gave_up:
            self._say("error", f"gives up until it gets a new goal: {decision.gave_up}")
        elif decision.status is not self._status:
            self._say("info", decision.status.value)
        self._status, self._gave_up = decision.status, decision.gave_up is not None

    def _say(self, level: str, sentence: str) -> None:
        """Tell ROS and this process's own log."""
        self._link.log(level, sentence)
        _log.log(logging.getLevelName({"warn": "WARNING"}.get(level, level.upper())), "%s", sentence)
