"""The node's process: started under the system's python3, at the other end of a socket, ended with it."""

from __future__ import annotations

import contextlib
import os
import select
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from han_bullet.errors import BadInputError, HanError
from ros1_bridge import wire

SYSTEM_PYTHON = "/usr/bin/python3"  # where Debian's and Ubuntu's packages put rospy
NODE = Path(wire.__file__).with_name("node.py")
CURE = "`make ros` installs it, or the packages in ros1_bridge/README.md; Debian 12 and Ubuntu 22.04 have them"
NOETIC = "/opt/ros/noetic/lib/python3/dist-packages"  # where ROS's own packages put it
OF_ROS = ("rospy", "rosgraph", "roslib", "genpy", "std_msgs")  # what the node needs of it
READY_WITHIN = 20.0  # [s]; usually 0.4
LOOKED_EVERY = 0.1  # [s]: whether the start was given up
ENDS_WITHIN = 3.0  # [s]


class NodeProcess:
    """A node that is ready.

    Args:
        name: Of the node, with a slash before it.
        uri: Of the master.
        given_up: Whether nobody wants it any more, asked while it starts.

    Raises:
        HanError: It does not become ready.
    """

    def __init__(self, name: str, uri: str, *, given_up: Callable[[], bool] = lambda: False) -> None:
        self.socket, theirs = socket.socketpair()
        self.slots = wire.Slots.create()
        files = theirs.fileno(), self.slots.file
        command = [SYSTEM_PYTHON, "-s", str(NODE), "--socket", str(files[0]), "--slots", str(files[1])]
        with theirs, tempfile.TemporaryFile() as complaints:
            self._process = subprocess.Popen(
                [*command, "--name", name.lstrip("/")],
                pass_fds=files,
                env=_environment(uri),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=complaints,
                start_new_session=True,  # the keyboard's Ctrl-C is for this process, which then ends that one
            )
            theirs.close()
            try:
                self._wait_until_ready(given_up)
            except wire.Closed as error:
                self.end(0.0)
                complaints.seek(0)
                said = complaints.read().decode(errors="replace").strip().splitlines()
                raise HanError(f"the ROS node does not start: {said[-1] if said else error}") from None
            except BaseException:  # Ctrl-C, for one
                self.end(0.0)
                raise

    @property
    def id(self) -> int:
        """Return the operating system's number of the process."""
        return self._process.pid

    def end(self, within: float = ENDS_WITHIN) -> None:
        """Close the socket, by which the node ends; kill it if it takes longer than `within` [s]."""
        with contextlib.suppress(OSError):
            self.socket.shutdown(socket.SHUT_RDWR)
        try:
            self._process.wait(within)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self.socket.close()

    def _wait_until_ready(self, given_up: Callable[[], bool]) -> None:
        deadline = time.monotonic() + READY_WITHIN
        while not select.select([self.socket], [], [], LOOKED_EVERY)[0]:
            if given_up() or time.monotonic() > deadline:
                raise wire.Closed(f"it was not ready within {READY_WITHIN:g} s")
        wire.receive(self.socket)


def check_ros() -> None:
    """Raise BadInputError unless the system's python3 has rospy."""
    look = f"import sys, importlib.util; sys.exit(not all(map(importlib.util.find_spec, {OF_ROS})))"
    command = [SYSTEM_PYTHON, "-s", "-c", look]
    try:
        subprocess.run(command, env=_without_python(), check=True, capture_output=True, timeout=READY_WITHIN)
    except (OSError, subprocess.SubprocessError):
        raise BadInputError(f"{SYSTEM_PYTHON} has no rospy; {CURE}") from None


def _environment(uri: str) -> dict[str, str]:
    """Return the environment of the node, to which only this machine may connect.

    Whoever sets ROS_IP or ROS_HOSTNAME lets others in.
    """
    environment = _without_python()
    if not (environment.get("ROS_IP") or environment.get("ROS_HOSTNAME")):
        environment["ROS_IP"] = "127.0.0.1"
    return environment | {"ROS_MASTER_URI": uri}


def _without_python() -> dict[str, str]:
    """Return the environment without this Python's settings; of its module path the folders of ROS remain."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "VIRTUAL_ENV"))}
    folders = [*os.environ.get("PYTHONPATH", "").split(os.pathsep), NOETIC]
    of_ros = [folder for folder in folders if folder and any(Path(folder, name).is_dir() for name in OF_ROS)]
    return environment | ({"PYTHONPATH": os.pathsep.join(of_ros)} if of_ros else {})
