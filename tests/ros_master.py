"""A ROS 1 master and ROS 1 clients of the tests' own: on the loopback, a free port, files in the test's folder.

    def test_it(ros_master: Master) -> None:
        with ros_client(ros_master) as client:
            client.subscribe("/odom", "nav_msgs/Odometry")  # collects from now on
            grid = client.wait_for_message("/map", "nav_msgs/OccupancyGrid")  # a dictionary, as are all messages here
            client.publish("/goal", "geometry_msgs/PoseStamped", {"header": {"frame_id": "map"}})
            plan = client.call("/make_plan", "nav_msgs/GetPlan", {"tolerance": 0.5})
            until(lambda: len(client.collected("/odom")) > 10)

The clients are rospy's, in processes of their own: this Python has no rospy. Times are [s], `uint8[]` is bytes.
"""

from __future__ import annotations

import contextlib
import functools
import os
import shutil
import signal
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mosquitto import until
from ros_client import read_json, write_json

from han_bullet.ros.master import is_there

PYTHON = "/usr/bin/python3"
PROGRAM = shutil.which("rosmaster", path="/usr/bin")
CLIENT = Path(__file__).with_name("ros_client.py")
DIES_WITH_US = ("setpriv", "--pdeathsig", "KILL")  # also where the tests are killed
PATIENCE = 30.0  # [s]


@functools.cache
def missing() -> str | None:
    """What keeps this machine from having the tests of ROS, and the cure."""
    has_rospy = subprocess.run([PYTHON, "-sE", "-c", "import rospy"], capture_output=True).returncode == 0
    if PROGRAM and has_rospy:
        return None
    return f"there is no {'rospy' if PROGRAM else 'rosmaster'} on this machine; `make ros` gets it"


class Master:
    """A master that can die and come back on the same port.

    Args:
        folder: For what ROS writes.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._process: subprocess.Popen[bytes] | None = None
        self.port = free_port()

    @property
    def uri(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    @property
    def variables(self) -> dict[str, str]:
        """Environment variables by which a process finds this master, and writes into no other folder."""
        folders = {"ROS_HOME": str(self._folder), "ROS_LOG_DIR": str(self._folder / "log")}
        return {"ROS_MASTER_URI": self.uri, "ROS_IP": "127.0.0.1", **folders}

    def environment(self) -> dict[str, str]:
        """The whole environment of a process of ROS."""
        ours = {"PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV", "ROS_HOSTNAME"}
        return {key: value for key, value in os.environ.items() if key not in ours} | self.variables

    def start(self) -> None:
        assert PROGRAM is not None and self._process is None
        with (self._folder / "rosmaster.txt").open("ab") as log:
            self._process = subprocess.Popen(
                [*DIES_WITH_US, PROGRAM, "--core", "-p", str(self.port)],
                stdout=log,
                stderr=log,
                env=self.environment(),
                start_new_session=True,
            )
        until(self._answers, PATIENCE)

    def stop(self) -> None:
        """Let it die at once; its clients are not told."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None

    def _answers(self) -> bool:
        assert self._process is not None
        assert self._process.poll() is None, (self._folder / "rosmaster.txt").read_text()
        return is_there(self.uri)


@contextlib.contextmanager
def running(folder: Path) -> Iterator[Master]:
    """A master that answers."""
    master = Master(folder)
    try:
        master.start()
        yield master
    finally:
        master.stop()


class Client:
    """A rospy node in a process of its own; methods raise RuntimeError with what rospy said."""

    def __init__(self, master: Master, name: str) -> None:
        self.process = subprocess.Popen(
            [*DIES_WITH_US, PYTHON, "-sE", str(CLIENT), name],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=master.environment(),
            text=True,
        )
        self._answer()

    def wait_for_message(self, topic: str, kind: str, timeout: float = PATIENCE) -> dict[str, Any]:
        """The next message of a topic, or the one that it has latched."""
        return self._ask("wait_for_message", topic=topic, kind=kind, timeout=timeout)

    def subscribe(self, topic: str, kind: str) -> None:
        """Collect what comes in a topic; returns at once, maybe before the publisher knows."""
        self._ask("subscribe", topic=topic, kind=kind)

    def collected(self, topic: str) -> list[dict[str, Any]]:
        """All that a subscribed topic has brought until now; taken from there."""
        return self._ask("collected", topic=topic)

    def collect(self, topic: str, kind: str, seconds: float) -> list[dict[str, Any]]:
        """What a topic brings in so many seconds [s] of the clock on the wall."""
        return self._ask("collect", topic=topic, kind=kind, seconds=seconds)

    def advertise(self, topic: str, kind: str) -> None:
        """Announce a topic without sending anything yet."""
        self._ask("advertise", topic=topic, kind=kind)

    def publish(self, topic: str, kind: str, message: dict[str, Any], *, to: int = 1) -> None:
        """Send a message in a topic as soon as so many nodes listen."""
        self._ask("publish", topic=topic, kind=kind, message=message, to=to, timeout=PATIENCE)

    def call(self, service: str, kind: str, request: dict[str, Any] | None = None) -> dict[str, Any]:
        """A service's response."""
        return self._ask("call", service=service, kind=kind, request=request or {}, timeout=PATIENCE)

    def set_param(self, name: str, value: object) -> None:
        """Set a parameter at the master."""
        self._ask("set_param", name=name, value=value)

    def param(self, name: str) -> Any:
        """A parameter at the master; None where it has none."""
        return self._ask("param", name=name)

    def topics(self) -> dict[str, str]:
        """Types of all topics that somebody publishes, by name."""
        return dict(self._ask("topics"))

    def node(self, name: str) -> str | None:
        """Where the master says that a node is, if it knows one."""
        return self._ask("node", name=name)

    def freeze(self) -> None:
        """Stop this client as a debugger would: its connections stay and nobody reads them."""
        self.process.send_signal(signal.SIGSTOP)

    def thaw(self) -> None:
        self.process.send_signal(signal.SIGCONT)

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()

    def close(self) -> None:
        """End the node as it would itself: the master is told."""
        assert self.process.stdin and self.process.stdout
        with contextlib.suppress(OSError):
            self.process.stdin.close()
        try:
            self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.kill()
        self.process.stdout.close()

    def _ask(self, what: str, **arguments: object) -> Any:
        assert self.process.stdin
        self.process.stdin.write(write_json({"do": what, **arguments}) + "\n")
        self.process.stdin.flush()
        return self._answer()

    def _answer(self) -> Any:
        assert self.process.stdout
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError("the client's process has ended")
        answer = read_json(line)
        if "error" in answer:
            raise RuntimeError(answer["error"])
        return answer["value"]


@contextlib.contextmanager
def ros_client(master: Master, name: str = "") -> Iterator[Client]:
    """A rospy node of a name, or of one that nobody else has."""
    client = Client(master, name)
    try:
        yield client
    finally:
        client.thaw()
        client.close()


def free_port() -> int:
    with contextlib.closing(socket.socket()) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
