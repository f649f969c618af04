"""The link to the node: its process, the socket between, and what it must be told again when it was started anew."""

from __future__ import annotations

import contextlib
import logging
import os
import socket
import subprocess
import tempfile
import threading
import time
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from han_bullet.errors import BadInputError, HanError
from han_bullet.ros.master import master_uri, node_at, wait_for_master
from han_bullet.ros.message_types import definition, serialized_parts
from ros1_bridge import wire

SYSTEM_PYTHON = "/usr/bin/python3"  # where Debian's and Ubuntu's packages put rospy
NODE_NAME = "/han_bullet"
READY_WITHIN = 20.0  # [s]; usually 0.4
ENDS_WITHIN = 3.0  # [s]
SHORT_LIFE = 1.0  # [s]: a node that ended sooner is not started again at once
MOST_WAITING = 64  # messages of one topic from ROS that nobody has taken yet; older ones are dropped

NODE = Path(wire.__file__).with_name("node.py")
CURE = "`make ros` installs it, or the packages in docs/ros.md; Debian 12 and Ubuntu 22.04 have them"
PYTHON_SETTINGS = {"PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV"}

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
    that dies is started again and told everything anew.

    Args:
        name: Of the node.
        patient: Whether to wait for a master that is not there yet.

    Raises:
        BadInputError: There is no ROS on this machine, no master, or the name is taken.
    """

    def __init__(self, *, name: str = NODE_NAME, patient: bool = False) -> None:
        self.name, self._uri = name, master_uri()
        _check_ros()
        wait_for_master(self._uri, patient=patient)
        if node_at(self._uri, name) is not None:
            raise BadInputError(f"the ROS master at {self._uri} has a node {name} already; stop it first")
        self._told: list[dict[str, Any]] = []  # what a new node must be told: topics, services, parameters
        self._sizes: dict[str, int] = {}
        self._latched: dict[str, Any] = {}
        self._waiting: dict[str, deque[Any]] = {}
        self._control: deque[tuple[dict[str, Any], Any]] = deque()
        self._wake = threading.Condition()
        self._listeners: Mapping[str, int] = {}
        self._incoming: dict[str, deque[Incoming]] = {}
        self._closing = threading.Event()
        self.ended: str | None = None  # why the node will not come back
        self.restarts = 0
        self._process, self._socket = self._start()
        self._threads = [
            threading.Thread(target=self._send, name="ros-send", daemon=True),
            threading.Thread(target=self._receive, name="ros-receive", daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def advertise(self, topic: str, kind: str, *, latched: bool = False, size: int = 1) -> None:
        """Announce a topic of a type, such as "nav_msgs/Odometry"; at most `size` messages wait for ROS."""
        self._sizes[topic] = size
        self._waiting[topic] = deque(maxlen=size)
        known = definition(kind)
        self._tell(op="advertise", topic=topic, kind=kind, md5=known.md5, text=known.text, latch=latched, size=size)
        if latched:
            self._latched[topic] = None

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
        """Set a parameter at the master, and again at a new one."""
        self._tell(op="param", name=name, value=value)

    def publish(self, topic: str, message: Any) -> None:
        """Send a message in an advertised topic; arrays in it must not change any more."""
        if topic in self._latched:
            self._latched[topic] = message
        with self._wake:
            self._waiting[topic].append(message)
            self._wake.notify()

    def log(self, level: str, text: str) -> None:
        """Say something in /rosout: level "info", "warn" or "error"."""
        self._put({"op": "log", "level": level, "text": text})

    def reply(self, request: int, message: Any = None, error: str | None = None) -> None:
        """Answer a service's request with a response or with why there is none."""
        self._put({"op": "reply", "request": request, "error": error}, message)

    def listeners(self, topic: str) -> int:
        """Return 0 if nobody listens to a topic, else how many have ever begun to."""
        return self._listeners.get(topic, 0)

    def received(self) -> list[Incoming]:
        """Return what has come from ROS since the last call, per topic or service in order."""
        taken = []
        for waiting in self._incoming.values():
            while waiting:
                taken.append(waiting.popleft())
        return taken

    @property
    def process_id(self) -> int:
        """Return the operating system's id of the node's process."""
        return self._process.pid

    def close(self) -> None:
        """Send what waits, and end the node."""
        self._closing.set()
        with self._wake:
            self._wake.notify()
        self._threads[0].join(ENDS_WITHIN)
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._threads[1].join(ENDS_WITHIN)
        try:
            self._process.wait(ENDS_WITHIN)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._socket.close()

    def __enter__(self) -> Link:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _tell(self, **head: Any) -> None:
        """Tell the node something that a new one must be told as well."""
        self._told.append(head)
        self._put(head)

    def _put(self, head: dict[str, Any], message: Any = None) -> None:
        with self._wake:
            self._control.append((head, message))
            self._wake.notify()

    def _send(self) -> None:
        """Send what waits, as long as the link is open: the body of a thread."""
        while True:
            with self._wake:
                while not (self._control or any(self._waiting.values()) or self._closing.is_set()):
                    self._wake.wait()
                control, self._control = list(self._control), deque()
                # A topic announced a moment ago is in `control`; announcements go first.
                messages = [(topic, message) for topic, queue in self._waiting.items() for message in queue]
                for queue in self._waiting.values():
                    queue.clear()
                sock = self._socket
            try:
                for head, message in control:
                    wire.send(sock, head, *([] if message is None else serialized_parts(message)))
                for topic, message in messages:
                    wire.send(sock, {"op": "publish", "topic": topic}, *serialized_parts(message))
            except wire.Closed:
                pass  # the other thread notices, and starts a new node
            if self._closing.is_set() and not self._control:
                return

    def _receive(self) -> None:
        """Take what comes, and start the node again when it ends: the body of a thread."""
        while not self._closing.is_set():
            started = time.monotonic()
            self._take_until_closed()
            if self._closing.is_set() or self.ended is not None:
                return
            _log.warning("the ROS node has died; it is started again")
            if time.monotonic() - started < SHORT_LIFE:
                self._closing.wait(SHORT_LIFE)
            self._restart()

    def _take_until_closed(self) -> None:
        with contextlib.suppress(wire.Closed):
            while True:
                head, raw = wire.receive(self._socket)
                operation = head["op"]
                if operation == "message":
                    self._incoming[head["topic"]].append(Incoming(head["topic"], raw))
                elif operation == "request":
                    self._incoming[head["service"]].append(Incoming(head["service"], raw, head["request"]))
                elif operation == "listeners":
                    self._listeners = head["topics"]
                elif operation == "master":
                    _log.warning("the ROS master is %s", "there again" if head["there"] else "gone")
                elif operation == "ended":
                    self.ended = head["why"]
                    _log.warning("the ROS node was told to end (%s); the run goes on without it", self.ended)

    def _restart(self) -> None:
        """Start a new node and tell it all that the old one knew."""
        self._listeners = {}
        while not self._closing.is_set():
            wait_for_master(self._uri, patient=True, stopped=self._closing.is_set)
            try:
                process, sock = self._start()
            except HanError as error:
                _log.warning("%s", error)
                self._closing.wait(SHORT_LIFE)
                continue
            latched = [(topic, message) for topic, message in self._latched.items() if message is not None]
            with self._wake:
                self._process, self._socket = process, sock
                self._control = deque([(head, None) for head in self._told])
                for topic, message in latched:
                    self._waiting[topic].append(message)
                self._wake.notify()
            self.restarts += 1
            return

    def _start(self) -> tuple[subprocess.Popen[bytes], socket.socket]:
        """Return a node's process and the socket to it, once it is ready.

        Raises:
            HanError: It does not become ready.
        """
        ours, theirs = socket.socketpair()
        with theirs, tempfile.TemporaryFile() as complaints:
            process = subprocess.Popen(
                [SYSTEM_PYTHON, "-sE", str(NODE), "--socket", str(theirs.fileno()), "--name", self.name.lstrip("/")],
                pass_fds=[theirs.fileno()],
                env=_environment(self._uri),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=complaints,
                start_new_session=True,  # the keyboard's Ctrl-C is for this process, which then ends that one
            )
            theirs.close()
            ours.settimeout(READY_WITHIN)
            try:
                wire.receive(ours)
            except wire.Closed as error:
                ours.close()
                process.kill()
                process.wait()
                complaints.seek(0)
                said = complaints.read().decode(errors="replace").strip().splitlines()
                raise HanError(f"the ROS node does not start: {said[-1] if said else error}") from None
            ours.settimeout(None)
        return process, ours


def _check_ros() -> None:
    """Raise BadInputError unless the system's python3 has rospy."""
    try:
        command = [SYSTEM_PYTHON, "-sE", "-c", "import rospy"]
        subprocess.run(command, check=True, capture_output=True, timeout=READY_WITHIN)
    except (OSError, subprocess.SubprocessError):
        raise BadInputError(f"{SYSTEM_PYTHON} has no rospy; {CURE}") from None


def _environment(uri: str) -> dict[str, str]:
    """Return the environment of the node: none of this Python's settings, and only this machine may connect.

    Whoever sets ROS_IP or ROS_HOSTNAME lets others in.
    """
    environment = {key: value for key, value in os.environ.items() if key not in PYTHON_SETTINGS}
    if not (environment.get("ROS_IP") or environment.get("ROS_HOSTNAME")):
        environment["ROS_IP"] = "127.0.0.1"
    return environment | {"ROS_MASTER_URI": uri}
