"""How late messages reach a ROS 1 subscriber, and how soon after a start, a killed node and a master's return.

Usage: python -m benchmarks.ros_bridge [--messages 200] [--rounds 5]

The subscriber is rospy's in a process of its own; a message's stamp is the wall clock's when it is handed to the link.
Targets: a median of 6 ms for an image and 5 ms for a grid, 2 s for the rest.
"""

import argparse
import contextlib
import os
import signal
import socket
import subprocess
import tempfile
import threading
import time
import xmlrpc.client
from collections import defaultdict
from collections.abc import Callable, Iterator

import numpy as np

from benchmarks.provenance import provenance
from han_bullet.markdown import markdown_table
from han_bullet.ros.link import Link
from han_bullet.ros.master import is_there
from han_bullet.ros.message_types import header, make
from han_bullet.ros.node_process import SYSTEM_PYTHON

SUBSCRIBER = """
import sys, time, rospy
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import Image
def heard(message, topic):
    now = time.time()
    sys.stdout.write("%s %.6f %.6f\\n" % (topic, message.header.stamp.to_sec(), now))
    sys.stdout.flush()
rospy.init_node("subscriber", disable_signals=True)
for topic, kind in (("/image", Image), ("/grid", OccupancyGrid)):
    rospy.Subscriber(topic, kind, heard, topic, queue_size=1, buff_size=1 << 24)
sys.stdin.read()
"""
EVERY = 0.05  # [s]
PATIENCE = 30.0  # [s]
PIXELS = np.random.default_rng(0).integers(0, 256, 640 * 480 * 3, dtype=np.uint8)
CELLS = np.random.default_rng(0).integers(-1, 101, 400 * 400).astype(np.int8)


class Subscriber:
    """Notes stamps and times of arrival [s] per topic."""

    def __init__(self) -> None:
        self.heard: dict[str, list[tuple[float, float]]] = defaultdict(list)
        self._process = subprocess.Popen(
            [SYSTEM_PYTHON, "-sE", "-c", SUBSCRIBER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stdout
        for line in self._process.stdout:
            topic, stamp, arrived = line.split()
            self.heard[topic].append((float(stamp), float(arrived)))

    def first_since(self, start: float) -> float | None:
        """Return when the first grid came that was sent after a time [s]."""
        return next((arrived for stamp, arrived in self.heard["/grid"] if stamp > start), None)

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.wait()


@contextlib.contextmanager
def master(port: int) -> Iterator[None]:
    """A master of the benchmark's own."""
    command = ["/usr/bin/rosmaster", "--core", "-p", str(port)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        until(lambda: is_there(os.environ["ROS_MASTER_URI"]))
        yield
    finally:
        process.kill()
        process.wait()


def until(condition: Callable[[], object]) -> None:
    """Wait for something."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError("it did not happen")
        time.sleep(0.002)


@contextlib.contextmanager
def opened() -> Iterator[Link]:
    """A link with both topics."""
    with Link() as link:
        link.advertise("/image", "sensor_msgs/Image")
        link.advertise("/grid", "nav_msgs/OccupancyGrid")
        yield link


def send_image(link: Link) -> None:
    """Publish 640 x 480 pixels of now."""
    now = header(time.time(), "camera")
    link.publish("/image", make("sensor_msgs/Image", header=now, height=480, width=640, step=1920, data=PIXELS))


def send_grid(link: Link) -> None:
    """Publish 400 x 400 cells of now."""
    info = make("nav_msgs/MapMetaData", resolution=0.05, width=400, height=400)
    link.publish("/grid", make("nav_msgs/OccupancyGrid", header=header(time.time(), "map"), info=info, data=CELLS))


def first_after(link: Link, subscriber: Subscriber, start: float) -> float:
    """Return how long after `start` the first message that was sent since then arrived [s], sending all the time."""

    def arrived() -> float | None:
        send_grid(link)
        time.sleep(0.01)
        return subscriber.first_since(start)

    until(arrived)
    return (subscriber.first_since(start) or start) - start


def latencies(link: Link, subscriber: Subscriber, messages: int) -> dict[str, list[float]]:
    """Return the time from stamp to callback of each message [s], by topic; the two take turns."""
    until(lambda: link.listeners("/image") and link.listeners("/grid"))
    subscriber.heard.clear()
    for _ in range(messages):
        send_image(link)
        time.sleep(EVERY)
        send_grid(link)
        time.sleep(EVERY)
    return {topic: [arrived - stamp for stamp, arrived in heard] for topic, heard in subscriber.heard.items()}


def after_start(subscriber: Subscriber, rounds: int) -> list[float]:
    """Return the time from making a link to the first message, of each round [s]."""
    times = []
    for _ in range(rounds):
        start = time.time()
        with opened() as link:
            times.append(first_after(link, subscriber, start))
    return times


def after_kill(subscriber: Subscriber, rounds: int) -> list[float]:
    """Return the time from killing the node to the first message, of each round [s]."""
    times = []
    with opened() as link:
        for _ in range(rounds):
            until(lambda: link.listeners("/grid"))
            time.sleep(1.5)  # a node that lived less is not started again at once
            start = time.time()
            os.kill(link.process_id, signal.SIGKILL)
            times.append(first_after(link, subscriber, start))
    return times


def after_return(port: int, rounds: int) -> list[float]:
    """Return the time from the answer of a new master to its knowing both topics, of each round [s]."""
    proxy, times = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"]), []

    def known() -> bool:
        topics = [topic for topic, _ in proxy.getPublishedTopics("/benchmark", "")[2]]
        return {"/image", "/grid"} <= set(topics)

    with contextlib.ExitStack() as stack:
        with master(port):
            stack.enter_context(opened())
            until(known)
        for _ in range(rounds):
            time.sleep(1.0)
            with master(port):
                start = time.time()
                until(known)
                times.append(time.time() - start)
    return times


def main() -> None:
    """Print two Markdown tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--messages", type=int, default=200, help="of each kind")
    parser.add_argument("--rounds", type=int, default=5, help="of starting, killing and the master's return")
    options = parser.parse_args()
    with contextlib.closing(socket.socket()) as probe, tempfile.TemporaryDirectory() as folder:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
        probe.close()
        os.environ |= {"ROS_MASTER_URI": f"http://127.0.0.1:{port}", "ROS_IP": "127.0.0.1", "ROS_HOME": folder}
        os.environ["ROS_LOG_DIR"] = folder
        with master(port):
            subscriber = Subscriber()
            try:
                with opened() as link:
                    late = latencies(link, subscriber, options.messages)
                times = {"start": after_start(subscriber, options.rounds)}
                times["the node was killed"] = after_kill(subscriber, options.rounds)
            finally:
                subscriber.close()
        times["the master is back"] = after_return(port, options.rounds)
    print("## ROS 1 bridge\n")
    print(provenance() + "\n")
    names = {"/image": "image 640 x 480", "/grid": "grid 400 x 400"}
    print(
        markdown_table(
            ("stamp to callback", "messages", "median [ms]", "95 % [ms]"),
            [
                (names[topic], len(late[topic]), *(f"{1e3 * np.quantile(late[topic], q):.1f}" for q in (0.5, 0.95)))
                for topic in names
            ],
        )
    )
    print()
    print(
        markdown_table(
            ("first message after", "rounds", "median [s]", "longest [s]"),
            [(what, len(of), f"{np.median(of):.2f}", f"{max(of):.2f}") for what, of in times.items()],
        )
    )


if __name__ == "__main__":
    main()
