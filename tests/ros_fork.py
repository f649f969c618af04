"""A process that has imported ROS and forks masters and clients, under the system's python3; see ros_process.py.

To import it takes longer than all that most of them do.
"""

from __future__ import annotations

import ctypes
import json
import os
import signal
import socket
import traceback

import ros_client
import rosmaster.main

PR_SET_PDEATHSIG = 1
USED = ("nav_msgs", "sensor_msgs", "tf2_msgs", "std_msgs", "rosgraph_msgs", "map_msgs")


def master(*arguments: str) -> None:
    rosmaster.main.rosmaster_main(["rosmaster", *arguments])


PROGRAMS = {"master": master, "client": ros_client.main}


def main() -> None:
    for package in USED:
        __import__(f"{package}.msg")
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # so that none remains as a zombie
    requests = socket.socket(fileno=0)
    while True:
        request, (*files,), _, _ = socket.recv_fds(requests, 65536, 2)
        if not request:
            return
        number = os.fork()
        if number == 0:
            become(json.loads(request), *files)
        for file in files:
            os.close(file)
        requests.send(b"%d" % number)


def become(request: dict[str, object], both: int, errors: int) -> None:
    """Go on as another program, as if it had been started with these files and variables."""
    try:
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)  # the tests are killed, or at their end
        os.setsid()
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        for number, file in enumerate((both, both, errors)):
            os.dup2(file, number)
        os.closerange(3, max(both, errors) + 1)
        os.environ.clear()
        os.environ.update(request["environment"])
        PROGRAMS[request["program"]](*request["arguments"])
        os._exit(0)
    except BaseException:
        traceback.print_exc()
        os._exit(1)


if __name__ == "__main__":
    main()
