"""rviz with the shipped configuration: it shows the robot, and sends it where one clicks."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import ros_master as ros
from mosquitto import until
from numpy.typing import NDArray
from PIL import Image
from ros_robot import robot_on_ros
from rviz_screen import CONFIG, rviz

from han_bullet.ros.topics import topics

pytestmark = [pytest.mark.ros, pytest.mark.rviz]
GOAL = (3.0, 0.3)  # [m]


def test_the_configuration_shows_only_what_the_robot_publishes() -> None:
    names = {topic.name for topic in topics([f"camera{i}" for i in (1, 2, 3, 4)] + ["onboard"], ["static"])}
    lines = [line.split(":", 1) for line in CONFIG.read_text().splitlines() if "Topic: /" in line]
    shown = {value.strip() for _, value in lines} - {"/move_base_simple/goal"}
    assert len(shown) > 10 and shown <= names


def test_a_goal_clicked_in_rviz_sends_the_robot_there(ros_master: ros.Master, tmp_path: Path) -> None:
    (tmp_path / "robot").mkdir()
    with robot_on_ros(ros_master, tmp_path / "robot") as robot, rviz(ros_master, tmp_path) as screen:
        robot.client.collect("/clock", "rosgraph_msgs/Clock", 3.0)  # until everything is drawn
        screen.screenshot(tmp_path / "before.png")
        start = robot.position
        screen.click_goal(*GOAL)
        until(lambda: math.dist(robot.goal, GOAL) < 0.05, ros.PATIENCE)  # two pixels
        until(lambda: math.dist(robot.position, GOAL) < 0.2 and robot.speed < 0.01, ros.PATIENCE)
        robot.client.collect("/clock", "rosgraph_msgs/Clock", 1.0)
        screen.screenshot(tmp_path / "after.png")
        assert math.dist(start, GOAL) > 1.0
        left, top, width, height = screen.view or (0, 0, 0, 0)
    floor = np.s_[top : top + height, left : left + width]
    before, after = (_picture(tmp_path / f"{name}.png")[floor] for name in ("before", "after"))
    assert len(np.unique(before.reshape(-1, 3), axis=0)) > 100  # costmap, robot and people are drawn
    assert (before != after).any(axis=2).sum() > 500  # [px]: the robot is elsewhere


def _picture(path: Path) -> NDArray[np.uint8]:
    return np.asarray(Image.open(path).convert("RGB"))
