"""What it costs a run's loop to be heard on ROS 1 as by rviz: five images at 10 Hz, grids at 5 Hz, frames, people.

Usage: python -m benchmarks.ros_load [--rounds 4] [--images image_raw|image_boxes] [--world real2] [--count-listener]

In one run the bridge is heard in every other second and takes everybody for gone in those between; a second run has it
the other way round, so that neither a slower machine nor a busier second of the world is taken for the bridge's doing.
Runs go no faster than real time; what the loop works, without what it sleeps, is compared. The listener does not count:
while it hears nothing, a process beside it is as busy as it was, in bursts at 10 Hz, too, in which it copies memory. No
camera processes, so that on two cores node and listener have one of their own. Target: at most 5 % longer.
"""

import argparse
import contextlib
import math
import os
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import psutil

from benchmarks.provenance import provenance
from benchmarks.ros_bridge import master
from han_bullet.episode import Hook, Tick
from han_bullet.markdown import markdown_table
from han_bullet.pace import Pace
from han_bullet.ros.bridge import RosBridge
from han_bullet.ros.link import Link
from han_bullet.ros.node_process import SYSTEM_PYTHON
from han_bullet.ros.topics import COSTMAP, COSTMAP_UPDATES, PEOPLE_MARKERS, PLAN, camera_topic
from han_bullet.runner import RunOptions, run_world
from han_bullet.world_file import load_world
from han_bullet.world_schema import CONTROL_PERIOD

LISTENER = """
import sys, rospy
rospy.init_node("listener", disable_signals=True, disable_rostime=True)
for topic in sys.argv[1:]:
    rospy.Subscriber(topic, rospy.AnyMsg, lambda message: None, queue_size=1, buff_size=1 << 22)
sys.stdin.read()
"""
DOUBLE = """
import sys, time
share, here, there = float(sys.argv[1]), bytearray(1 << 20), bytearray(1 << 20)
while True:
    began = time.process_time()
    while time.process_time() - began < 0.1 * share:
        here[:] = there
    time.sleep(0.1 * (1.0 - share))
"""
ALWAYS = ["/tf", "/odom", "/scan", "/map", COSTMAP, COSTMAP_UPDATES, PLAN, PEOPLE_MARKERS, "/trajectory"]
FIRST = 2.0  # [s] of a run that do not count: kernels are loaded
SETTLING = 0.15  # [s] after each turn that do not count: new listeners are greeted with whole grids


class Turns(Hook):
    """Let the bridge be heard in every other second, and keep how long the loop works in either kind.

    Args:
        link: The bridge's.
        heard_first: Whether it is heard in seconds 0, 2, 4, ...
        listener: Process number of who listens.
        double: Process number of who is as busy while nobody is heard.
    """

    def __init__(self, link: Link, *, heard_first: bool, listener: int, double: int) -> None:
        self.listeners, self._heard_first, self._double = link.listeners, heard_first, double
        link.listeners = self._listening  # type: ignore[method-assign]
        self._listener = psutil.Process(listener)
        self._heard, self._listener_used = False, 0.0
        self.slept = 0.0  # [s] since the last tick
        self._began = math.inf
        self.work: dict[bool, list[float]] = {False: [], True: []}  # [s] per tick, by whether the bridge was heard
        self.used: dict[bool, float] = {False: 0.0, True: 0.0}  # processor time of this thread and all others [s]
        self.listened: list[float] = []  # processor time of the listener in each second in which it heard [s]
        self._clock = time.process_time()

    def sleep(self, duration: float) -> None:
        """Sleep so long [s]."""
        before = time.perf_counter()
        time.sleep(duration)
        self.slept += time.perf_counter() - before

    def record(self, tick: Tick) -> None:
        """Note the work of a tick; to be called after the sleep at its end."""
        now, clock, at = time.perf_counter(), time.process_time(), tick.decision.time
        if at > FIRST and at % 1.0 > SETTLING:
            self.work[self._heard].append(now - self._began - self.slept)
            self.used[self._heard] += clock - self._clock
        second = math.floor(at + CONTROL_PERIOD + 1e-6)  # of the next tick
        self._turn((second % 2 == 0) == self._heard_first, at)
        self._began, self._clock, self.slept = time.perf_counter(), time.process_time(), 0.0

    def _turn(self, heard: bool, at: float) -> None:
        if heard != self._heard:
            used = sum(self._listener.cpu_times()[:2])
            if self._heard and at > FIRST:
                self.listened.append(used - self._listener_used)
            self._listener_used, self._heard = used, heard
            os.kill(self._double, signal.SIGSTOP if heard else signal.SIGCONT)

    @property
    def longer(self) -> tuple[float, float]:
        """Return by what share ticks take longer on the wall's clock and the processor's while the bridge is heard."""
        wall = np.mean(self.work[True]) / np.mean(self.work[False])
        processor = self.used[True] / len(self.work[True]) / (self.used[False] / len(self.work[False]))
        return float(wall), float(processor)

    def _listening(self, topic: str) -> int:
        return self.listeners(topic) if self._heard else 0


def run(world: str, folder: Path, topics: list[str], share: float, *, heard_first: bool) -> Turns:
    """Return what a run's loop worked with and without listeners, whose double takes a share of a core."""
    listener = [SYSTEM_PYTHON, "-sE", "-c", LISTENER, *topics]
    double = [sys.executable, "-c", DOUBLE, str(share)]
    with Link() as link, running(listener) as hears, running(double) as busy:
        bridge = RosBridge(link)
        turns = Turns(link, heard_first=heard_first, listener=hears, double=busy)
        pace = Pace(sleep=turns.sleep)
        run_world(world, RunOptions(video=False, workers=1), folder, [bridge, pace, turns], operator=bridge)
        assert all(turns.listeners(topic) for topic in topics)
    return turns


@contextlib.contextmanager
def running(command: list[str]) -> Iterator[int]:
    """Have a program beside; its process number."""
    with subprocess.Popen(command, stdin=subprocess.PIPE) as process:
        try:
            yield process.pid
        finally:
            process.kill()


def rounds(options: argparse.Namespace) -> tuple[list[tuple[Turns, Turns]], float]:
    """Return the two runs of each round, and the share of a core that the listener's double took."""
    topics = ALWAYS + [camera_topic(camera.name, options.images) for camera in load_world(options.world).cameras]
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with tempfile.TemporaryDirectory() as name:
        os.environ |= {"ROS_MASTER_URI": f"http://127.0.0.1:{port}", "ROS_IP": "127.0.0.1", "ROS_HOME": name}

        def one(share: float, heard_first: bool) -> Turns:
            return run(options.world, Path(name, "run"), topics, share, heard_first=heard_first)

        with master(port):
            first = one(0.01, True)
            share = 0.0 if options.count_listener else statistics.mean(first.listened)
            return [(one(share, True), one(share, False)) for _ in range(options.rounds)], share


def row(one: Turns, other: Turns) -> tuple[float, ...]:
    """Return a round's numbers: ticks alone and heard [ms], longer by, processor time by, listener [%]."""
    longer = [100 * math.sqrt(a * b) - 100 for a, b in zip(one.longer, other.longer, strict=True)]
    ticks = [1e3 * statistics.mean(one.work[heard] + other.work[heard]) for heard in (False, True)]
    return (*ticks, *longer, 100 * statistics.mean(one.listened + other.listened))


def main() -> None:
    """Run in turn and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=4, help="of two runs each that count (default 4)")
    parser.add_argument("--images", default="image_raw", choices=("image_raw", "image_boxes"), help="of each camera")
    parser.add_argument("--world", default="real2")
    parser.add_argument(
        "--count-listener", action="store_true", help="nobody is as busy as the listener while it hears nothing"
    )
    options = parser.parse_args()
    runs, share = rounds(options)
    rows = [row(*both) for both in runs]
    table = [
        (f"{i + 1}", f"{alone:.2f}", f"{heard:.2f}", f"{longer:+.1f}", f"{processor:+.1f}", f"{listener:.1f}")
        for i, (alone, heard, longer, processor, listener) in enumerate(rows)
    ]
    headings = (
        "round",
        "tick alone [ms]",
        "heard [ms]",
        "longer by [%]",
        "processor time by [%]",
        "listener [% of a core]",
    )
    double = "counted" if options.count_listener else f"has a double that takes {100 * share:.1f} % of a core"
    print(provenance(), "\n")
    print(markdown_table(headings, table))
    median = statistics.median(longer for _, _, longer, _, _ in rows)
    print(f"\nmedian: {median:+.1f} %; {options.images}, {options.world}; the listener {double}")


if __name__ == "__main__":
    main()
