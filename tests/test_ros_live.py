"""A robot that is nothing but topics: the simulator on one side of ROS, the stack, without PyBullet, on the other."""

from __future__ import annotations

import contextlib
import csv
import math
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from live_robot import write_live_robot
from mosquitto import until
from ros_master import Client, Master, ros_client

pytestmark = [pytest.mark.ros, pytest.mark.scenario]

TOUCH = 0.3 + 0.25  # [m] between the centres of the robot and of somebody who stands
GOAL = (6.0, 0.0)  # [m]
PACE = "1"  # of real time, at most: a busy machine takes its time, by which the robot drives more slowly


@contextlib.contextmanager
def han_bullet(arguments: Sequence[str], log: Path, **variables: str) -> Iterator[subprocess.Popen[bytes]]:
    """The command line as a process of its own."""
    with log.open("wb") as file:
        process = subprocess.Popen(
            ["setpriv", "--pdeathsig", "KILL", sys.executable, "-m", "han_bullet.cli", *arguments],
            stdout=file,
            stderr=file,
            env={**os.environ, **variables},
        )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def trace(path: Path) -> list[dict[str, float]]:
    """Where robot and bystander truly were, tick by tick, in whole lines."""
    text = path.read_text() if path.is_file() else ""
    rows = csv.DictReader(text[: text.rfind("\n") + 1].splitlines())
    return [{name: float(value) for name, value in row.items() if "posture" not in name} for row in rows]


def is_at_goal(row: dict[str, float]) -> bool:
    standing = math.hypot(row["robot.vx"], row["robot.vy"]) < 0.01
    return standing and math.dist((row["robot.x"], row["robot.y"]), GOAL) < 0.25


def says(log: Path, words: str, process: subprocess.Popen[bytes]) -> bool:
    assert process.poll() is None, log.read_text()
    return words in log.read_text()


def test_the_stack_drives_a_robot_that_it_knows_by_topics_alone_to_its_goal_and_touches_nobody(
    ros_master: Master, tmp_path: Path
) -> None:
    config = write_live_robot(tmp_path)
    nowhere = tmp_path / "without"
    nowhere.mkdir()
    (nowhere / "pybullet.py").write_text("raise ImportError('a real robot has no PyBullet')\n")
    log, robot_log, file = tmp_path / "live.txt", tmp_path / "robot.txt", tmp_path / "robot" / "trace.csv"
    robot = ["ros-robot", str(tmp_path / "world.yaml"), "--pace", PACE, "--out", str(file.parent)]
    with (
        ros_client(ros_master) as client,
        han_bullet(["ros-live", str(config)], log, PYTHONPATH=str(nowhere)) as live,
    ):
        until(lambda: says(log, "waits for /odom", live), 120.0)
        listen(client)
        with han_bullet(robot, robot_log) as simulated:
            until(lambda: bool(trace(file)) and is_at_goal(trace(file)[-1]) and says(log, "arrived", live), 120.0)
            live.send_signal(signal.SIGTERM)
            assert live.wait(30.0) == 0, log.read_text()
            simulated.send_signal(signal.SIGINT)
            assert simulated.wait(30.0) == 0, robot_log.read_text()
        way = trace(file)
        check_topics(client, (way[0]["bystander.x"], way[0]["bystander.y"]))
    assert way[0]["robot.x"] < 2.0
    between = [math.dist((row["robot.x"], row["robot.y"]), (row["bystander.x"], row["bystander.y"])) for row in way]
    assert TOUCH + 0.1 < min(between) < 1.4  # it passes beside them, not through them


LISTENED = {
    "/cmd_vel": "geometry_msgs/Twist",
    "/people": "people_msgs/People",
    "/move_base/GlobalPlanner/plan": "nav_msgs/Path",
    "/tf": "tf2_msgs/TFMessage",
}


def listen(client: Client) -> None:
    for topic, kind in LISTENED.items():
        client.subscribe(topic, kind)


def check_topics(client: Client, bystander: tuple[float, float]) -> None:
    """What others heard: commands that end with a stop, the bystander where they are, plans, one tree of transforms."""
    commands = client.collected("/cmd_vel")
    assert max(twist["linear"]["x"] for twist in commands) > 0.3
    assert commands[-1]["linear"]["x"] == commands[-1]["linear"]["y"] == commands[-1]["angular"]["z"] == 0.0
    people = [person["position"] for message in client.collected("/people") for person in message["people"]]
    assert min(math.dist((place["x"], place["y"]), bystander) for place in people) < 0.2
    assert any(message["poses"] for message in client.collected("/move_base/GlobalPlanner/plan"))
    edges = {
        (transform["header"]["frame_id"], transform["child_frame_id"])
        for message in client.collected("/tf")
        for transform in message["transforms"]
    }
    assert {("map", "odom"), ("odom", "base_link")} <= edges
