"""What a run's loop loses to ROS 1 when somebody listens as rviz does: five images, grids, frames, people.

Usage: python -m benchmarks.ros_load [--rounds 7] [--images image_raw|image_boxes] [--world real2]

The same run alone and on ROS, in turn, no faster than real time, so that images come at their 10 Hz and grids at 5 Hz;
what the loop then works, without what it sleeps, is compared. No camera processes, so that on two cores the node and
the listener have one of their own; the first pair is not counted. Target: the loop works at most 5 % longer.
"""

import argparse
import json
import os
import socket
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

from benchmarks.provenance import provenance
from benchmarks.ros_bridge import master
from han_bullet.markdown import markdown_table
from han_bullet.pace import Pace
from han_bullet.ros.bridge import RosBridge
from han_bullet.ros.link import Link
from han_bullet.ros.node_process import SYSTEM_PYTHON
from han_bullet.ros.topics import COSTMAP, COSTMAP_UPDATES, PEOPLE_MARKERS, PLAN, camera_topic
from han_bullet.runner import RunOptions, run_world
from han_bullet.world_file import load_world

LISTENER = """
import sys, time, rospy
rospy.init_node("listener", disable_signals=True, disable_rostime=True)
for topic in sys.argv[1:]:
    rospy.Subscriber(topic, rospy.AnyMsg, lambda message: None, queue_size=1, buff_size=1 << 22)
sys.stdin.read()
"""
ALWAYS = ["/tf", "/odom", "/scan", "/map", COSTMAP, COSTMAP_UPDATES, PLAN, PEOPLE_MARKERS, "/trajectory"]


class Slept:
    """Sleeps, and keeps count [s]."""

    def __init__(self) -> None:
        self.total = 0.0

    def __call__(self, duration: float) -> None:
        """Sleep so long [s]."""
        before = time.perf_counter()
        time.sleep(duration)
        self.total += time.perf_counter() - before


def run(world: str, folder: Path, topics: list[str]) -> tuple[float, float]:
    """Return a run's work by the wall clock and by the processor's, per simulated second [s/s], with listeners."""
    options, slept, before = RunOptions(video=False, workers=1), Slept(), time.process_time()
    pace = Pace(sleep=slept)
    if not topics:
        run_world(world, options, folder, [pace])
    else:
        command = [SYSTEM_PYTHON, "-sE", "-c", LISTENER, *topics]
        with Link() as link, subprocess.Popen(command, stdin=subprocess.PIPE) as listener:
            bridge = RosBridge(link)
            run_world(world, options, folder, [bridge, pace], operator=bridge)
            assert all(link.listeners(topic) for topic in topics if topic != COSTMAP_UPDATES)
            listener.kill()
    used = time.process_time() - before
    timings = json.loads((folder / "result.json").read_text())["timings"]
    return (timings["loop_s"] - slept.total) / timings["simulated_s"], used / timings["simulated_s"]


def main() -> None:
    """Run in turn and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=7, help="pairs of runs that count (default 7)")
    parser.add_argument("--images", default="image_raw", choices=("image_raw", "image_boxes"), help="of each camera")
    parser.add_argument("--world", default="real2")
    options = parser.parse_args()
    topics = ALWAYS + [camera_topic(camera.name, options.images) for camera in load_world(options.world).cameras]
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    rows = []
    with tempfile.TemporaryDirectory() as name:
        os.environ |= {"ROS_MASTER_URI": f"http://127.0.0.1:{port}", "ROS_IP": "127.0.0.1", "ROS_HOME": name}
        with master(port):
            for _ in range(1 + options.rounds):
                rows.append(
                    (*run(options.world, Path(name, "alone"), []), *run(options.world, Path(name, "ros"), topics))
                )
    rows = rows[1:]
    print(provenance(), "\n")
    longer = [on_ros / alone - 1.0 for alone, _, on_ros, _ in rows]
    table = [
        (i + 1, f"{alone:.2f}", f"{on_ros:.2f}", f"{100 * more:+.1f}", f"{100 * (cpu_ros / cpu - 1):+.1f}")
        for i, ((alone, cpu, on_ros, cpu_ros), more) in enumerate(zip(rows, longer, strict=True))
    ]
    print(markdown_table(("pair", "work alone [s/s]", "on ROS [s/s]", "longer by [%]", "processor time by [%]"), table))
    print(
        f"\nmedian: the loop takes {100 * statistics.median(longer):+.1f} % longer; {options.images}, {options.world}"
    )


if __name__ == "__main__":
    main()
