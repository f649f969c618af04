"""What the stack on a real robot says on ROS, and what it leaves to the robot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from live_robot import write_live_robot

from han_bullet.device_channel import EmbeddedChannel
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.messages import Observation, Odometry
from han_bullet.ros.live_setup import load_live_setup
from han_bullet.ros.live_stack import build_live_stack
from han_bullet.ros.live_topics import LiveTopics
from han_bullet.ros.message_types import seconds

EPOCH = 1.7e9  # [s]
OF_ROBOT = {"/odom", "/scan", "/cmd_vel", "/clock", "/joint_states", "/camera1/image_raw", "/camera1/camera_info"}


class FakeLink:
    """A link with somebody who listens to everything."""

    def __init__(self) -> None:
        self.latched: dict[str, bool] = {}
        self.published: dict[str, list[Any]] = {}

    def advertise(self, topic: str, kind: str, *, latched: bool, size: int) -> None:
        self.latched[topic] = latched

    def publish(self, topic: str, message: Any) -> None:
        assert topic in self.latched
        self.published.setdefault(topic, []).append(message)

    def listeners(self, topic: str) -> int:
        return 1


class NoEyes:
    def detect(self, frames: list[Any]) -> list[Any]:
        return []


@pytest.fixture(scope="module")
def link(tmp_path_factory: pytest.TempPathFactory) -> FakeLink:
    """What was said in the first three ticks of a robot that was switched on long ago."""
    folder: Path = tmp_path_factory.mktemp("robot")
    setup, link = load_live_setup(write_live_robot(folder)), FakeLink()
    stack = build_live_stack(setup, NoEyes(), EmbeddedChannel())  # type: ignore[arg-type]
    topics = LiveTopics(setup.world, stack, link)  # type: ignore[arg-type]
    for tick in range(3):
        observation = Observation(0.05 * tick, Odometry(0.05 * tick, Pose2D(7.0, 8.0, 0.0), Twist2D()))
        topics.tell(observation, stack.step(observation), EPOCH)
    return link


def test_map_costmap_plan_and_people_are_said_and_nothing_that_the_robot_says_itself(link: FakeLink) -> None:
    said = {"/map", "/move_base/global_costmap/costmap", "/move_base/GlobalPlanner/plan", "/people", "/diagnostics"}
    assert said <= set(link.published)
    assert not OF_ROBOT & set(link.latched)
    assert link.latched["/map"]


def test_of_the_transforms_only_those_from_the_map_are_said(link: FakeLink) -> None:
    moving = [transform for message in link.published["/tf"] for transform in message.transforms]
    assert {(one.header.frame_id, one.child_frame_id) for one in moving} == {("map", "odom")}
    still = [transform for message in link.published["/tf_static"] for transform in message.transforms]
    assert {one.child_frame_id for one in still} == {"camera1_optical_frame", "camera2_optical_frame"}
    assert all(one.header.frame_id == "map" for one in still)


def test_map_to_odom_takes_odometry_to_where_the_robot_starts(link: FakeLink) -> None:
    translation = link.published["/tf"][0].transforms[0].transform.translation
    assert (translation.x + 7.0, translation.y + 8.0) == (pytest.approx(1.5), pytest.approx(0.0))


def test_stamps_are_on_the_robots_clock(link: FakeLink) -> None:
    stamps = [seconds(message.transforms[0].header.stamp) for message in link.published["/tf"]]
    np.testing.assert_allclose(stamps, EPOCH + 0.05 * np.arange(3), atol=1e-6)
    assert seconds(link.published["/people"][0].header.stamp) == pytest.approx(EPOCH)
