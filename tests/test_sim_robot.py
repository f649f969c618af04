"""The simulator as a robot behind ROS, with a link that remembers in place of ROS."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from live_robot import WORLD

from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.recorder import TraceRecorder
from han_bullet.ros.link import Incoming
from han_bullet.ros.message_types import seconds, serialize
from han_bullet.ros.robot_messages import twist_message
from han_bullet.ros.sensor_readings import read_image, read_odometry, read_scan
from han_bullet.ros.sim_robot import OBEYS_FOR, SimulatedRobot
from han_bullet.sim.renderer import InProcessRenderer
from han_bullet.sim.simulator import Simulator
from han_bullet.world_file import load_world
from han_bullet.world_schema import CeilingCamera, World

FAST = 1e6  # times real time


class FakeLink:
    """What the robot needs of a link; `before_taking` is called whenever it looks for commands."""

    def __init__(self) -> None:
        self.ended: str | None = None
        self.advertised: dict[str, str] = {}
        self.params: dict[str, object] = {}
        self.published: list[tuple[str, Any]] = []
        self.waiting: list[Incoming] = []
        self.before_taking: Callable[[], None] = lambda: None

    def advertise(self, topic: str, kind: str, *, latched: bool, size: int) -> None:
        self.advertised[topic] = kind

    def subscribe(self, topic: str, kind: str) -> None:
        assert (topic, kind) == ("/cmd_vel", "geometry_msgs/Twist")

    def set_param(self, name: str, value: object) -> None:
        self.params[name] = value

    def publish(self, topic: str, message: Any) -> None:
        assert topic in self.advertised
        self.published.append((topic, message))

    def received(self) -> list[Incoming]:
        self.before_taking()
        taken, self.waiting = self.waiting, []
        return taken

    def of(self, topic: str) -> list[Any]:
        return [message for name, message in self.published if name == topic]


def little_world(tmp_path: Path, duration: float) -> World:
    (tmp_path / "world.yaml").write_text(WORLD)
    world = load_world(tmp_path / "world.yaml")
    return world.model_copy(update={"duration": duration, "cameras": world.cameras[:1]})


@pytest.fixture
def run(tmp_path: Path) -> Iterator[Callable[..., FakeLink]]:
    """Runs a robot for so many simulated seconds; returns what it said."""

    def run(duration: float, link: FakeLink, ended: Callable[[], bool] = lambda: False) -> FakeLink:
        world = little_world(tmp_path, duration)
        trace, renderer = TraceRecorder(tmp_path / "trace.csv", world), InProcessRenderer(world, 0)
        with Simulator(world, renderer=renderer) as simulator:
            SimulatedRobot(world, simulator, link, trace).run(ended, FAST)  # type: ignore[arg-type]
        trace.close()
        renderer.close()
        return link

    yield run


def rows(tmp_path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader((tmp_path / "trace.csv").read_text().splitlines()))


def test_it_obeys_the_last_command_and_stops_half_a_second_after_it(
    run: Callable[..., FakeLink], tmp_path: Path
) -> None:
    link = FakeLink()

    def command_for_a_second() -> None:
        if len(link.of("/odom")) <= 20:
            link.waiting.append(Incoming("/cmd_vel", bytes(serialize(twist_message(Twist2D(0.4))))))

    link.before_taking = command_for_a_second
    run(3.0, link)
    speeds = [read_odometry(message, 0.0).twist_robot_in_body.vx for message in link.of("/odom")]
    assert len(speeds) == 61
    assert speeds[20] == pytest.approx(0.4, rel=0.1)
    last = round((0.95 + OBEYS_FOR) / 0.05)
    assert speeds[last] == pytest.approx(0.4, rel=0.1) and abs(speeds[last + 10]) < 0.01
    true = [float(row["robot.x"]) for row in rows(tmp_path)]
    assert true[-1] - true[0] == pytest.approx(0.4 * 1.5, rel=0.1)


def test_a_command_that_is_none_is_not_obeyed(
    run: Callable[..., FakeLink], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    link = FakeLink()
    link.waiting = [Incoming("/cmd_vel", bytes(serialize(twist_message(Twist2D(math.nan))))), Incoming("/cmd_vel", b"")]
    run(0.5, link)
    assert rows(tmp_path)[-1]["robot.x"] == rows(tmp_path)[0]["robot.x"]
    assert len([record for record in caplog.records if "/cmd_vel" in record.getMessage()]) == 2


def test_what_it_says_is_what_a_robot_knows_and_nothing_tells_where_anything_truly_is(
    run: Callable[..., FakeLink], tmp_path: Path
) -> None:
    link = run(0.5, FakeLink())
    assert set(link.advertised) == {
        "/clock",
        "/odom",
        "/tf",
        "/tf_static",
        "/joint_states",
        "/scan",
        "/camera1/image_raw",
        "/camera1/camera_info",
    }
    assert link.params["/use_sim_time"] is True and "<robot" in str(link.params["/robot_description"])
    edges = {
        (transform.header.frame_id, transform.child_frame_id)
        for message in link.of("/tf") + link.of("/tf_static")
        for transform in message.transforms
    }
    assert ("odom", "base_link") in edges and ("base_link", "laser") in edges
    assert "map" not in {parent for parent, _ in edges}
    assert read_odometry(link.of("/odom")[0], 0.0).pose_robot_in_odom == Pose2D(0.0, 0.0, 0.0)
    assert [seconds(message.clock) for message in link.of("/clock")] == pytest.approx(np.arange(11) * 0.05)


def test_its_camera_and_its_scanner_speak_at_their_own_rates(run: Callable[..., FakeLink], tmp_path: Path) -> None:
    link = run(1.0, FakeLink())
    camera = little_world(tmp_path, 1.0).cameras[0]
    assert isinstance(camera, CeilingCamera) and camera.rate == 5.0
    images = [read_image(message, camera.intrinsics) for message in link.of("/camera1/image_raw")]
    assert len(images) == len(link.of("/camera1/camera_info")) == 6
    assert images[0].std() > 10.0
    scans = [read_scan(message, 0.0, Pose2D(0.2, 0.0, 0.0)) for message in link.of("/scan")]
    assert len(scans) == 11
    assert np.isfinite(scans[0].ranges).any()


def test_it_ends_when_it_is_told_to_with_whole_lines_in_the_trace(run: Callable[..., FakeLink], tmp_path: Path) -> None:
    link = FakeLink()
    run(60.0, link, ended=lambda: len(link.of("/odom")) == 8)
    assert len(rows(tmp_path)) == 8
    assert {"robot.x", "bystander.x", "bystander.posture"} <= set(rows(tmp_path)[0])
