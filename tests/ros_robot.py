"""A robot that stays on in real2's corridor and takes orders from ROS, and a rospy client beside it.

Its perception is true, so that whom it knows is certain.
"""

from __future__ import annotations

import contextlib
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mosquitto import until
from ros_master import PATIENCE, Client, Master, ros_client

from han_bullet.ros.topics import CURRENT_GOAL, ROBOT_POSE


@dataclass
class Robot:
    """The run's process, the client, and the run's folder, where `log` is what it said."""

    process: subprocess.Popen[bytes]
    client: Client
    folder: Path

    def message(self, topic: str, kind: str) -> dict[str, Any]:
        return self.client.wait_for_message(topic, kind)

    @property
    def position(self) -> tuple[float, float]:
        at = self.message(ROBOT_POSE, "geometry_msgs/PoseWithCovarianceStamped")["pose"]["pose"]["position"]
        return at["x"], at["y"]

    @property
    def odometry(self) -> tuple[float, float]:
        at = self.message("/odom", "nav_msgs/Odometry")["pose"]["pose"]["position"]
        return at["x"], at["y"]

    @property
    def goal(self) -> tuple[float, float]:
        at = self.message(CURRENT_GOAL, "geometry_msgs/PoseStamped")["pose"]["position"]
        return at["x"], at["y"]

    @property
    def speed(self) -> float:
        twist = self.message("/odom", "nav_msgs/Odometry")["twist"]["twist"]["linear"]
        return math.hypot(twist["x"], twist["y"])

    def send(self, topic: str, kind: str, message: dict[str, Any]) -> None:
        self.client.publish(topic, kind, message)

    def go_to(self, x: float, y: float, **more: Any) -> None:
        self.send("/move_base_simple/goal", "geometry_msgs/PoseStamped", stamped(x, y, **more))

    def cancel(self) -> None:
        self.send("/move_base/cancel", "actionlib_msgs/GoalID", {})


def stamped(x: float, y: float, frame: str = "map", w: float = 1.0) -> dict[str, Any]:
    pose = {"position": {"x": x, "y": y}, "orientation": {"w": w}}
    return {"header": {"frame_id": frame}, "pose": pose}


def run_command(folder: Path, *more: str, world: str = "real2") -> list[str]:
    options = ["--perception", "truth", "--no-video", "--out", str(folder)]
    return [sys.executable, "-m", "han_bullet.cli", "run", world, *options, *more]


@contextlib.contextmanager
def robot_on_ros(master: Master, folder: Path) -> Iterator[Robot]:
    """A robot that stands."""
    environment = {**os.environ, **master.variables}
    environment.pop("ROS_HOSTNAME", None)
    with (folder / "log").open("wb") as log:
        command = run_command(folder, "--ros", "--stay")
        process = subprocess.Popen(command, env=environment, stdout=log, stderr=subprocess.STDOUT)
    try:
        with ros_client(master) as client:
            robot = Robot(process, client, folder)
            robot.cancel()
            until(lambda: robot.speed < 0.01, PATIENCE)
            yield robot
    finally:
        process.kill()
        process.wait()
