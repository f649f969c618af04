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
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import psutil
from mosquitto import until
from ros_json import read_json, write_json
from ros_process import DIES_WITH_US, PYTHON, forked, has_ended, kill

from han_bullet.ros.master import is_there

PROGRAMS = ("rosmaster", "roslaunch", "rosrun")
PATIENCE = 30.0  # [s]


@functools.cache
def missing() -> str | None:
    """What keeps this machine from having the tests of ROS, and the cure."""
    absent = [program for program in PROGRAMS if shutil.which(program, path="/usr/bin") is None]
    if subprocess.run([PYTHON, "-sE", "-c", "import rospy"], capture_output=True).returncode:
        absent.append("rospy")
    return f"there is no {absent[0]} on this machine; `make ros` gets it" if absent else None


class Master:
    """A master that can die and come back on the same port.

    Args:
        folder: For what ROS writes.
        program: Whether it is ROS's own command, not a fork that does the same.
    """

    def __init__(self, folder: Path, *, program: bool = False) -> None:
        self._folder, self._program = folder, program
        self._process: psutil.Process | None = None
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
        assert self._process is None
        arguments, environment = ["--core", "-p", str(self.port)], self.environment()
        with (self._folder / "rosmaster.txt").open("ab") as log:
            if self._program:
                command = [*DIES_WITH_US, "/usr/bin/rosmaster", *arguments]
                self._process = psutil.Popen(command, stdout=log, stderr=log, env=environment, start_new_session=True)
            else:
                file = log.fileno()
                self._process = forked("master", *arguments, environment=environment, file=file, errors=file)
        until(self._answers, PATIENCE)

    def stop(self) -> None:
        """Let it die at once; its clients are not told."""
        if self._process is not None:
            kill(self._process)
            self._process = None

    def freeze(self) -> None:
        """Make it mute: it takes connections and answers nothing."""
        assert self._process is not None
        self._process.suspend()

    def thaw(self) -> None:
        assert self._process is not None
        self._process.resume()

    def _answers(self) -> bool:
        assert self._process is not None
        assert not has_ended(self._process), (self._folder / "rosmaster.txt").read_text()
        return is_there(self.uri)


@contextlib.contextmanager
def running(folder: Path, *, program: bool = False) -> Iterator[Master]:
    """A master that answers; see `Master`."""
    master = Master(folder, program=program)
    try:
        master.start()
        yield master
    finally:
        master.stop()


class Client:
    """A rospy node in a process of its own; methods raise RuntimeError with what rospy said."""

    def __init__(self, master: Master, name: str) -> None:
        self._socket, theirs = socket.socketpair()
        self._lines = self._socket.makefile("rw")
        with theirs:
            self._process = forked("client", name, environment=master.environment(), file=theirs.fileno())
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

    def advertise(self, topic: str, kind: str) -> None:
        """Announce a topic without sending anything yet."""
        self._ask("advertise", topic=topic, kind=kind)

    def publish(self, topic: str, kind: str, message: dict[str, Any], timeout: float = PATIENCE) -> None:
        """Send a message in a topic as soon as somebody listens."""
        self._ask("publish", topic=topic, kind=kind, message=message, timeout=timeout)

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
        self._process.suspend()

    def thaw(self) -> None:
        with contextlib.suppress(psutil.NoSuchProcess):
            self._process.resume()

    def kill(self) -> None:
        kill(self._process)

    def close(self) -> None:
        """End the node as it would itself: the master is told."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_WR)
        try:
            self._process.wait(PATIENCE)
        except psutil.TimeoutExpired:
            self.kill()
        self._lines.close()
        self._socket.close()

    def _ask(self, what: str, **arguments: object) -> Any:
        self._lines.write(write_json({"do": what, **arguments}) + "\n")
        self._lines.flush()
        return self._answer()

    def _answer(self) -> Any:
        line = self._lines.readline()
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
