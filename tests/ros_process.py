"""Processes of ROS, under the system's python3: forked from one that has imported rospy, once for all tests.

They are processes of their own all the same, with an environment of their own, to be frozen and killed. They die with
the tests, however these end.
"""

from __future__ import annotations

import contextlib
import functools
import json
import socket
import subprocess
from pathlib import Path

import psutil

PYTHON = "/usr/bin/python3"
FORK = Path(__file__).with_name("ros_fork.py")
DIES_WITH_US = ("setpriv", "--pdeathsig", "KILL")  # also where the tests are killed


def forked(program: str, *arguments: str, environment: dict[str, str], file: int, errors: int = 2) -> psutil.Process:
    """A new process.

    Args:
        program: "master" or "client".
        arguments: Of the program.
        environment: All its variables.
        file: Number of the open file that is its input and output.
        errors: And the one for what it complains of.
    """
    requests = _forking()
    text = json.dumps({"program": program, "arguments": arguments, "environment": environment})
    socket.send_fds(requests, [text.encode()], [file, errors])
    return psutil.Process(int(requests.recv(64)))


def has_ended(process: psutil.Process) -> bool:
    with contextlib.suppress(psutil.TimeoutExpired):
        process.wait(0)
        return True
    return False


def kill(process: psutil.Process) -> None:
    with contextlib.suppress(psutil.NoSuchProcess):
        process.kill()
    process.wait()


@functools.cache
def _forking() -> socket.socket:
    """Where to ask the process that forks; it ends when this one does."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with theirs:
        command = [*DIES_WITH_US, PYTHON, "-sE", str(FORK)]
        subprocess.Popen(command, stdin=theirs, start_new_session=True)
    return ours
