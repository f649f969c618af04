"""The loop on a real robot, with a link that remembers what it was given in place of ROS."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from live_robot import CONFIG, write_live_robot

from han_bullet.device_channel import EmbeddedChannel
from han_bullet.errors import WorkerDiedError
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.messages import CameraImage, Frame, FrameDetections, GoTo, LaserScan, Odometry
from han_bullet.ros import live
from han_bullet.ros.link import Incoming
from han_bullet.ros.live import LiveLoop
from han_bullet.ros.live_setup import LiveSetup, load_live_setup
from han_bullet.ros.live_stack import build_live_stack
from han_bullet.ros.message_types import serialize
from han_bullet.ros.placing import pose_stamped
from han_bullet.ros.robot_messages import odometry_message, scan_message
from han_bullet.stack import NavigationStack
from han_bullet.world_schema import Slip

ODOM, COMMAND, GOAL = "/odom", "/cmd_vel", "/move_base_simple/goal"


class FakeLink:
    """What the loop needs of a link."""

    def __init__(self) -> None:
        self.ended: str | None = None
        self.commands: list[Twist2D] = []
        self.log_lines: list[tuple[str, str]] = []
        self.subscribed: dict[str, str] = {}
        self.waiting: list[Incoming] = []

    def advertise(self, topic: str, kind: str) -> None:
        assert (topic, kind) == (COMMAND, "geometry_msgs/Twist")

    def subscribe(self, topic: str, kind: str, *, size: int) -> None:
        self.subscribed[topic] = kind

    def serve(self, service: str, kind: str) -> None: ...

    def publish(self, topic: str, message: Any) -> None:
        self.commands.append(Twist2D(message.linear.x, message.linear.y, message.angular.z))

    def log(self, level: str, text: str) -> None:
        self.log_lines.append((level, text))

    def received(self) -> list[Incoming]:
        taken, self.waiting = self.waiting, []
        return taken

    def give(self, topic: str, message: Any) -> None:
        self.waiting.append(Incoming(topic, bytes(serialize(message))))


class NoEyes:
    """Cameras that show nobody."""

    def offer(self, image: CameraImage) -> None: ...

    def advance(self) -> None: ...

    def finished(self) -> tuple[CameraImage, ...]:
        return ()

    def detect(self, frames: list[Frame]) -> list[FrameDetections]:
        assert not frames
        return []


class NoTopics:
    """Nobody who listens to what was decided."""

    def __init__(self) -> None:
        self.epochs: list[float] = []

    def tell(self, _: object, __: object, epoch: float) -> None:
        self.epochs.append(epoch)


@pytest.fixture(scope="module")
def setup(tmp_path_factory: pytest.TempPathFactory) -> LiveSetup:
    """A robot with a laser that goes by its odometry."""
    text = CONFIG.replace("localization: lidar", "localization: odometry")
    return load_live_setup(write_live_robot(tmp_path_factory.mktemp("robot"), text))


class Robot:
    """A robot that does exactly what it is told, and the loop that drives it, turn by turn."""

    def __init__(self, setup: LiveSetup, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(live, "SENT_WITHIN", 0.0)
        self.link, self.topics, eyes = FakeLink(), NoTopics(), NoEyes()
        devices = EmbeddedChannel()
        self.stack: NavigationStack = build_live_stack(setup, eyes, devices)  # type: ignore[arg-type]
        self.loop = LiveLoop(setup, self.stack, eyes, self.link, self.topics, devices)  # type: ignore[arg-type]
        self.time, self.pose = 100.0, Pose2D(0.0, 0.0, 0.0)

    def turns(self, before: Callable[[int], None], count: int) -> None:
        """Let the loop turn so often."""
        done = 0

        def ended() -> bool:
            nonlocal done
            if done == count:
                return True
            before(done)
            done += 1
            return False

        self.loop.run(ended)

    def move(self, _: int = 0) -> None:
        """Obey the last command for a control period, and say where that led; nothing is near."""
        twist = self.link.commands[-1] if self.link.commands else Twist2D()
        self.pose = self.pose.compose(Pose2D(0.05 * twist.vx, 0.05 * twist.vy, 0.05 * twist.omega))
        self.time += 0.05
        self.link.give(ODOM, odometry_message(Odometry(self.time, self.pose, twist), Slip()))
        scan = LaserScan(self.time, np.full(541, np.inf), -2.36, 0.00873, 0.0, 8.0, Pose2D(0.2, 0.0, 0.0))
        self.link.give("/scan", scan_message(scan, 0.1))


def test_each_odometry_is_answered_by_a_command_and_the_last_one_is_to_stop(
    setup: LiveSetup, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = Robot(setup, monkeypatch)
    robot.turns(robot.move, 40)
    assert len(robot.link.commands) == 41
    assert robot.link.commands[-2].vx > 0.1 and robot.link.commands[-1] == Twist2D()
    assert robot.pose.x > 0.1
    assert set(robot.topics.epochs) == {100.05}
    assert robot.link.subscribed[ODOM] == "nav_msgs/Odometry"


def test_a_robot_whose_odometry_falls_silent_is_told_once_to_stop_and_goes_on_when_it_comes_back(
    setup: LiveSetup, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot, now = Robot(setup, monkeypatch), 0.0
    monkeypatch.setattr(live.time, "monotonic", lambda: now)
    robot.turns(robot.move, 20)
    moving = len(robot.link.commands)

    def wait(turn: int) -> None:
        nonlocal now
        now += 0.2

    robot.turns(wait, 10)
    assert robot.link.commands[moving:] == [Twist2D(), Twist2D()]  # for silence, and at the end
    errors = [text for level, text in robot.link.log_lines if level == "error"]
    assert errors == ["no odometry on /odom for 0.5 s: the robot is told to stop"]
    robot.turns(robot.move, 5)
    assert len(robot.link.commands) == moving + 2 + 6


def test_whatever_happens_the_robot_is_told_to_stop(setup: LiveSetup, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = Robot(setup, monkeypatch)

    def fail(turn: int) -> None:
        robot.move()
        robot.link.ended = "somebody ended it" if turn == 20 else None

    with pytest.raises(WorkerDiedError, match="somebody ended it"):
        robot.turns(fail, 30)
    assert robot.link.commands[-2].vx > 0.0 and robot.link.commands[-1] == Twist2D()


def test_messages_of_no_use_do_not_stop_the_loop(setup: LiveSetup, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = Robot(setup, monkeypatch)

    def disturb(turn: int) -> None:
        robot.move()
        robot.link.waiting.append(Incoming("/camera1/image_raw", b"nonsense"))
        robot.link.waiting.append(Incoming(ODOM, b""))

    robot.turns(disturb, 20)
    assert len(robot.link.commands) == 21 and robot.pose.x > 0.0
    warnings = [text for level, text in robot.link.log_lines if level == "warn" and "bytes are no" in text]
    assert len(warnings) == 2


def test_a_goal_from_ros_takes_the_place_of_the_world_files(setup: LiveSetup, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = Robot(setup, monkeypatch)
    goal = Pose2D(2.5, 0.8, 0.0)
    robot.link.give(GOAL, pose_stamped(goal, 0.0, "map"))
    robot.turns(robot.move, 200)
    assert ("info", "arrived") in robot.link.log_lines
    there = setup.world.robot.start_pose_in_world.compose(robot.pose)
    assert there.distance_to(goal.position) < 0.15


def test_a_robot_that_gave_up_stands_until_it_gets_a_new_goal(
    setup: LiveSetup, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = Robot(setup, monkeypatch)
    robot.stack.take(GoTo(Pose2D(8.0, 5.0, 0.0)))  # behind the wall
    robot.turns(robot.move, 700)
    told = [text for level, text in robot.link.log_lines if level == "error"]
    assert len(told) == 1 and told[0].startswith("gives up until it gets a new goal: no free way")
    before = robot.pose
    robot.turns(robot.move, 20)
    assert robot.pose == before
    robot.link.give(GOAL, pose_stamped(Pose2D(3.0, 0.0, 0.0), 0.0, "map"))
    robot.turns(robot.move, 40)
    assert robot.pose.x > before.x + 0.1


def test_a_loop_with_sparse_odometry_drives_slowly_and_still_stops_at_its_goal(
    setup: LiveSetup, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = Robot(setup, monkeypatch)
    robot.stack.take(GoTo(Pose2D(2.6, 0.0, 0.0)))

    def sparse(_: int) -> None:
        for _ in range(8):  # 0.4 s of which the loop hears once
            robot.link.waiting.clear()
            robot.move()

    robot.turns(sparse, 40)
    assert max(twist.speed for twist in robot.link.commands) <= 0.1 / 0.4 + 1e-6
    assert ("info", "arrived") in robot.link.log_lines
    assert [text for level, text in robot.link.log_lines if level == "warn"] == [
        "0.40 s between two ticks, 0.05 s would be right; more is not told"
    ]
