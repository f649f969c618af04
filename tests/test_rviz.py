"""rviz with the shipped configuration: it shows the robot, and sends it where one clicks."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
import ros_master as ros
from mosquitto import until
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
    def shows(name: str, place: tuple[float, float], empty: tuple[float, float]) -> bool:
        """Whether map, costmap and people are drawn, and the robot at one of two places."""
        floor = screen.floor(tmp_path / f"{name}.png")
        colours = floor.getcolors(floor.width * floor.height)
        return len(colours) > 100 and screen.has_robot_at(*place, floor) and not screen.has_robot_at(*empty, floor)

    (tmp_path / "robot").mkdir()
    with robot_on_ros(ros_master, tmp_path / "robot") as robot, rviz(ros_master, tmp_path) as screen:
        start = robot.position
        assert math.dist(start, GOAL) > 1.0
        until(lambda: shows("before", start, GOAL), ros.PATIENCE)
        screen.click_goal(*GOAL)
        until(lambda: math.dist(robot.goal, GOAL) < 0.05, ros.PATIENCE)  # two pixels
        until(lambda: math.dist(robot.position, GOAL) < 0.2 and robot.speed < 0.01, ros.PATIENCE)
        until(lambda: shows("after", robot.position, start), ros.PATIENCE)
