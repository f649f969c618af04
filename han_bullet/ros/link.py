"""The link to the node: what waits for ROS and from ROS, and what a node that was started anew must be told again."""

from __future__ import annotations

import contextlib
import json
import logging
import socket
import threading
import time
from collections import deque
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from han_bullet.errors import BadInputError, HanError
from han_bullet.ros.master import master_uri, node_at, wait_for_master
from han_bullet.ros.message_types import definition, serialized_parts
from han_bullet.ros.node_process import ENDS_WITHIN, NodeProcess, check_ros
from ros1_bridge import wire

NODE_NAME = "/han_bullet"
SHORT_LIFE = 1.0  # [s]: a node that ended sooner is not started again at once
MOST_WAITING = 64  # requests and lines of the log that nobody has taken yet; older ones are dropped
LOG = "log"  # has a queue like a topic's, whose names begin with a slash

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Incoming:
    """Something that came from ROS.

    Attributes:
        name: Of the topic or the service.
        raw: The serialized message or request.
        request: Number of the request, to reply to; None for a message of a topic.
    """

    name: str
    raw: bytes
    request: int | None = None


class Link:
    """Publish, hear and serve through a process that has rospy, since this one has not.

    Messages wait in a queue per topic, whose oldest is dropped when it is full; nothing here ever waits for ROS. A node
    that dies is started again and told everything anew; one that was told to end is not.

    Args:
        name: Of the node.
        patient: Whether to wait for a master that is not there yet.

    Attributes:
        ended: Why the node will not come back; None while it lives, or is started again.
        restarts: How often it was started again.

    Raises:
        BadInputError: There is no ROS on this machine, no master, or the name is taken.
        HanError: The node does not start.
    """

    def __init__(self, *, name: str = NODE_NAME, patient: bool = False) -> None:
        self.name, self._uri = name, master_uri()
        check_ros()
        wait_for_master(self._uri, patient=patient)
        if node_at(self._uri, name) is not None:
            raise BadInputError(f"the ROS master at {self._uri} has a node {name} already; stop it first")
        self.ended: str | None = None
        self.restarts = 0
        self._wake = threading.Condition()  # guards the five that follow
        self._told: list[dict[str, Any]] = []  # what a new node must be told: topics, services, parameters
        self._control: deque[tuple[dict[str, Any], Any]] = deque()  # heads and messages, before all that waits
        self._waiting: dict[str, deque[tuple[dict[str, Any], Any]]] = {LOG: deque(maxlen=MOST_WAITING)}
        self._latched: dict[str, Any] = {}
        self._node = NodeProcess(name, self._uri)
        self._listeners: dict[str, int] = {}
        self._listened_before: dict[str, int] = {}  # to nodes that have died
        self._incoming: dict[str, deque[Incoming]] = {}
        self._unsendable: set[str] = set()
        self._closing = threading.Event()
        self._sender = threading.Thread(target=self._send, name="ros-send", daemon=True)
        self._receiver = threading.Thread(target=self._receive, name="ros-receive", daemon=True)
        self._sender.start()
        self._receiver.start()

    def advertise(self, topic: str, kind: str, *, latched: bool = False, size: int = 1) -> None:
        """Announce a topic of a type, such as "nav_msgs/Odometry"; at most `size` messages wait for ROS."""
        known = definition(kind)
        with self._wake:
            self._waiting[topic] = deque(maxlen=size)
            if latched:
                self._latched[topic] = None
        self._tell(op="advertise", topic=topic, kind=kind, md5=known.md5, text=known.text, latch=latched, size=size)

    def subscribe(self, topic: str, kind: str, *, size: int = 1) -> None:
        """Hear a topic from now on; see `received`. Of more than `size` messages at once the oldest are dropped."""
        self._incoming[topic] = deque(maxlen=size)
        known = definition(kind)
        self._tell(op="subscribe", topic=topic, kind=kind, md5=known.md5, text=known.text, size=size)

    def serve(self, service: str, kind: str) -> None:
        """Offer a service of a type that this machine's ROS knows; each request wants a `reply`."""
        self._incoming[service] = deque(maxlen=MOST_WAITING)
        self._tell(op="serve", service=service, kind=kind)

    def set_param(self, name: str, value: object) -> None:
        """Set a parameter at the master, and again at a new one; JSON must be able to write the value."""
        json.dumps(value)
        self._tell(op="param", name=name, value=value)

    def publish(self, topic: str, message: Any) -> None:
        """Send a message in an advertised topic; arrays in it must not change any more."""
        with self._wake:
            if topic in self._latched:
                self._latched[topic] = message
            if self.ended is None:
                self._waiting[topic].append(({"op": "publish", "topic": topic}, message))
                self._wake.notify()

    def log(self, level: str, text: str) -> None:
        """Say something in /rosout: level "info", "warn" or "error"."""
        with self._wake:
            self._waiting[LOG].append(({"op": "log", "level": level, "text": text}, None))
            self._wake.notify()

    def reply(self, request: int, message: Any = None, error: str | None = None) -> None:
        """Answer a service's request with a response or with why there is none."""
        with self._wake:
            self._control.append(({"op": "reply", "request": request, "error": error}, message))
            self._wake.notify()

    def listeners(self, topic: str) -> int:
        """Return 0 if nobody listens to a topic, else how many have ever begun to."""
        now = self._listeners.get(topic, 0)
        return now + self._listened_before.get(topic, 0) if now else 0

    def received(self) -> list[Incoming]:
        """Return what has come from ROS since the last call, per topic or service in order."""
        taken = []
        for waiting in self._incoming.values():
            while waiting:
                taken.append(waiting.popleft())
        return taken

    @property
    def process_id(self) -> int:
        """Return the operating system's number of the node's process."""
        return self._node.id

    def close(self) -> None:
        """Send what waits, and end the node."""
        self._closing.set()
        with self._wake:
            self._wake.notify()
        self._sender.join(ENDS_WITHIN)
        reads_nothing = self._sender.is_alive()
        with contextlib.suppress(OSError):
            self._node.socket.shutdown(socket.SHUT_RDWR)  # frees either thread from what it waits for
        self._receiver.join(ENDS_WITHIN)
        self._node.end(0.0 if reads_nothing else ENDS_WITHIN)

    def __enter__(self) -> Link:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _tell(self, **head: Any) -> None:
        """Tell the node something that a new one must be told as well; a parameter's new value replaces the old."""
        with self._wake:
            if head["op"] == "param":
                self._told = [one for one in self._told if (one["op"], one.get("name")) != ("param", head["name"])]
            self._told.append(head)
            self._control.append((head, None))
            self._wake.notify()

    def _send(self) -> None:
        """Send what waits until the link is closed and nothing waits: the body of a thread."""
        while (next_ones := self._next_ones()) is not None:
            node, waited = next_ones
            for head, message in waited:
                frame = self._frame(head, message)
                try:
                    if frame is not None:
                        wire.send(node.socket, *frame, slots=node.slots)
                except wire.Closed:  # the other thread notices, and starts a new node
                    break

    def _next_ones(self) -> tuple[NodeProcess, list[tuple[dict[str, Any], Any]]] | None:
        """Return the node and all that waits, as soon as something does; None when nothing will."""
        with self._wake:
            self._wake.wait_for(lambda: self._control or any(self._waiting.values()) or self._closing.is_set())
            waited = [*self._control]  # a topic that was announced a moment ago is in here: announcements go first
            self._control.clear()
            for queue in self._waiting.values():
                waited += queue
                queue.clear()
            return (self._node, waited) if waited else None

    def _frame(self, head: dict[str, Any], message: Any) -> tuple[Any, ...] | None:
        """Return what to send: a head, and a message in serialized pieces; None if the message has wrong values."""
        if message is None:
            return (head,)
        try:
            return (head, *serialized_parts(message))
        except Exception as error:  # whatever the values are: the thread must live
            if head["op"] == "reply":
                return (head | {"error": f"the response has a value that ROS cannot have: {error!r}"},)
            if head["topic"] not in self._unsendable:
                self._unsendable.add(head["topic"])
                _log.error("a message for %s has a value that ROS cannot have: %r", head["topic"], error)
            return None

    def _receive(self) -> None:
        """Take what comes, and start the node again when it ends: the body of a thread."""
        while not self._closing.is_set():
            started = time.monotonic()
            self._take_until_closed()
            if self._closing.is_set() or self.ended is not None:
                return
            _log.warning("the ROS node has died; it is started again")
            self._node.end(0.0)
            if time.monotonic() - started < SHORT_LIFE:
                self._closing.wait(SHORT_LIFE)
            self._restart()

    def _take_until_closed(self) -> None:
        with contextlib.suppress(wire.Closed):
            while True:
                head, raw = wire.receive(self._node.socket)
                operation = head["op"]
                if operation == "message":
                    self._incoming[head["topic"]].append(Incoming(head["topic"], raw))
                elif operation == "request":
                    self._incoming[head["service"]].append(Incoming(head["service"], raw, head["request"]))
                elif operation == "listeners":
                    self._listeners = head["topics"]
                elif operation == "master":
                    _log.warning("the ROS master is %s", "there again" if head["there"] else "gone")
                elif operation == "failed":
                    _log.error("the ROS node cannot %s %s: %s", head["what"], head["name"], head["why"])
                elif operation == "ended":
                    self._end(head["why"])

    def _end(self, why: str) -> None:
        with self._wake:
            self.ended = why
        self._listeners = {}
        _log.warning("the ROS node %s has ended: %s; the run goes on without it", self.name, why)

    def _restart(self) -> None:
        """Start a new node and tell it all that the old one knew."""
        for topic, count in self._listeners.items():
            self._listened_before[topic] = self._listened_before.get(topic, 0) + count
        self._listeners = {}
        while not self._closing.is_set():
            wait_for_master(self._uri, patient=True, stopped=self._closing.is_set)
            if node_at(self._uri, self.name) is not None:
                return self._end("another node has taken the name")
            try:
                node = NodeProcess(self.name, self._uri, given_up=self._closing.is_set)
            except HanError as error:
                if not self._closing.wait(SHORT_LIFE):
                    _log.warning("%s", error)
                continue
            self._take_up(node)
            return

    def _take_up(self, node: NodeProcess) -> None:
        with self._wake:
            self._node = node
            self._control = deque((head, None) for head in self._told)
            for topic, message in self._latched.items():
                if message is not None and not self._waiting[topic]:
                    self._waiting[topic].append(({"op": "publish", "topic": topic}, message))
            self._wake.notify()
        self.restarts += 1
