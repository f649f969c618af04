"""Orders from ROS without ROS: what reaches the robot, what is refused, and what is told of it."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import pytest
from ticks import make_world, tick

from han_bullet.ablation import NoDetector, TrueLocalization, TruthTracker
from han_bullet.assembly import build_stack
from han_bullet.device_channel import EmbeddedChannel
from han_bullet.device_payload import read_payload
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.messages import GoTo, Truth
from han_bullet.ros.bridge import RosBridge
from han_bullet.ros.link import Incoming
from han_bullet.ros.message_types import deserialize, make, serialize
from han_bullet.ros.orders import RosOrders
from han_bullet.ros.placing import pose_stamped
from han_bullet.stack import Decision, NavigationStack

DOCUMENTATION = Path(__file__).parent.parent / "docs/ros.md"
TV = {"name": "tv", "position": [4.0, 1.0], "facing": 0.0}
WORLD = make_world(devices=[TV])
STILL = Truth(0.0, Pose2D(1.0, 0.0, 0.0), Twist2D(), ())
GOAL = Pose2D(3.0, 0.5, 1.0)
POSE = "geometry_msgs/PoseStamped"


class FakeLink:
    """A link that remembers what it was given in place of ROS."""

    def __init__(self) -> None:
        self.ended: str | None = None
        self.kinds: dict[str, str] = {}
        self.said: list[tuple[str, str]] = []
        self.replies: list[tuple[int, Any, str | None]] = []
        self.waiting: list[Incoming] = []

    def subscribe(self, topic: str, kind: str, *, size: int) -> None:
        self.kinds[topic] = kind

    def serve(self, service: str, kind: str) -> None:
        self.kinds[service] = kind

    def set_param(self, name: str, value: object) -> None: ...

    def log(self, level: str, text: str) -> None:
        self.said.append((level, text))

    def reply(self, request: int, message: Any = None, error: str | None = None) -> None:
        self.replies.append((request, message, error))

    def received(self) -> list[Incoming]:
        taken, self.waiting = self.waiting, []
        return taken


class Robot:
    """A robot that stands in a corridor, and who gives it the orders of a link."""

    def __init__(self) -> None:
        self.link, self.channel = FakeLink(), EmbeddedChannel()
        self.stack: NavigationStack = build_stack(
            WORLD,
            localization=TrueLocalization(lambda: STILL),
            detector=NoDetector(),
            tracker=TruthTracker(lambda: STILL, {}),
            sees=False,
        )
        self.orders = RosOrders(self.link)  # type: ignore[arg-type]
        self.orders.begin(WORLD, self.stack, self.channel)
        self.decision = self.step()

    def step(self) -> Decision:
        self.decision = self.stack.step(tick().observation)
        return self.decision

    def hear(self, name: str, message: Any, request: int | None = None) -> None:
        self.hear_raw(name, bytes(serialize(message)), request)

    def hear_raw(self, name: str, raw: bytes, request: int | None = None) -> None:
        self.link.waiting.append(Incoming(name, raw, request))
        self.orders.attend(self.decision)


@pytest.fixture
def robot() -> Robot:
    return Robot()


def test_a_goal_is_taken(robot: Robot) -> None:
    robot.hear("/move_base_simple/goal", pose_stamped(GOAL, 0.0, "map"))
    (order,) = robot.step().orders
    assert isinstance(order.task, GoTo)
    assert order.task.pose_in_world.distance_to(GOAL.position) < 1e-9
    assert order.task.pose_in_world.yaw == pytest.approx(GOAL.yaw)
    assert robot.link.said == []


def tilted(x: float) -> Any:
    pose = pose_stamped(GOAL, 0.0, "map")
    turn = dataclasses.replace(pose.pose.orientation, x=x, z=0.0, w=math.sqrt(1.0 - x * x))
    return dataclasses.replace(pose, pose=dataclasses.replace(pose.pose, orientation=turn))


@pytest.mark.parametrize(
    ("name", "message", "reason"),
    [
        ("/move_base_simple/goal", pose_stamped(GOAL, 0.0, "odom"), "frame 'odom'; 'map' would be right"),
        ("/move_base_simple/goal", pose_stamped(Pose2D(50.0, 0.0, 0.0), 0.0, "map"), "50.0"),
        ("/move_base_simple/goal", tilted(0.3), "tilts the robot"),
        ("/hand_over", make("std_msgs/Int32", data=77), "person 77 of the hand-over is not tracked"),
        (
            "/cmd_vel_teleop",
            make("geometry_msgs/Twist", linear=make("geometry_msgs/Vector3", x=math.nan)),
            "not finite",
        ),
        ("/initialpose", make("geometry_msgs/PoseWithCovarianceStamped"), "has its pose from the simulator"),
    ],
)
def test_what_cannot_be_done_is_refused_with_the_reason_on_rosout(
    robot: Robot, name: str, message: Any, reason: str
) -> None:
    robot.hear(name, message)
    ((level, text),) = robot.link.said
    assert level == "warn" and text.startswith(f"{name} refused: ") and reason in text
    assert robot.step().orders == ()


@pytest.mark.parametrize(("localization", "reason"), [("lidar", "by its laser"), ("odometry", "by its odometry")])
def test_a_pose_is_refused_with_how_the_robot_knows_its_own(
    robot: Robot, localization: str, reason: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(robot.stack.localization, "name", localization)
    robot.hear("/initialpose", make("geometry_msgs/PoseWithCovarianceStamped"))
    ((_, text),) = robot.link.said
    assert text.startswith("/initialpose refused: the robot") and reason in text
    assert "x 1.00 m, y 0.00 m in 'map'" in text


@pytest.mark.parametrize("name", ["/move_base_simple/goal", "/hand_over", "/cmd_vel_teleop", "/tv/state"])
def test_bytes_that_are_no_message_are_refused(robot: Robot, name: str) -> None:
    robot.hear_raw(name, b"")
    ((_, text),) = robot.link.said
    assert f"0 bytes are no {robot.link.kinds[name]}" in text


def test_a_refused_request_is_answered_with_the_reason(robot: Robot) -> None:
    nowhere = make("nav_msgs/GetPlanRequest", goal=pose_stamped(GOAL, 0.0, "odom"))
    robot.hear("/move_base/make_plan", nowhere, request=3)
    ((request, message, error),) = robot.link.replies
    assert (request, message) == (3, None) and error is not None and "'odom'" in error


def test_a_plan_without_a_start_begins_where_the_robot_is_and_is_no_order(robot: Robot) -> None:
    robot.hear("/move_base/make_plan", make("nav_msgs/GetPlanRequest", goal=pose_stamped(GOAL, 0.0, "map")), request=4)
    ((request, message, error),) = robot.link.replies
    plan = deserialize("nav_msgs/GetPlanResponse", bytes(serialize(message))).plan
    ends = [plan.poses[k].pose.position for k in (0, -1)]
    assert (request, error, plan.header.frame_id) == (4, None, "map")
    assert math.dist((ends[0].x, ends[0].y), (1.0, 0.0)) < 0.1
    assert math.dist((ends[1].x, ends[1].y), (3.0, 0.5)) < 0.1
    assert robot.step().orders == ()


def test_what_clears_costmaps_is_answered(robot: Robot) -> None:
    robot.hear_raw("/move_base/clear_costmaps", b"", request=5)
    assert robot.link.replies == [(5, None, None)]
    assert [order.name for order in robot.step().orders] == ["clear_obstacles"]


def test_a_devices_state_is_passed_on_at_once_and_again_each_second(robot: Robot) -> None:
    robot.hear("/tv/state", make("std_msgs/Bool", data=True))
    times = []
    for number in range(45):
        time = robot.decision.time + 0.05 * number
        robot.orders.repeat(dataclasses.replace(robot.decision, time=time))
        for payload in robot.channel.receive():
            message = read_payload(payload, ["tv"])
            assert message.on and message.session == "ros" and message.time == pytest.approx(time)
            times.append(0.05 * number)
    assert times == pytest.approx([0.0, 1.0, 2.0])


def test_the_documentation_has_every_order(robot: Robot) -> None:
    page = DOCUMENTATION.read_text()
    for name, kind in robot.link.kinds.items():
        assert f"| `{name.replace('/tv/', '/DEVICE/')}` | `{kind}` |" in page


def test_who_stays_leaves_when_told_to_or_when_the_node_was_ended_for_good() -> None:
    link = FakeLink()
    bridge = RosBridge(link, stays=True)  # type: ignore[arg-type]
    late = dataclasses.replace(tick().decision, time=100.0)
    assert not bridge.is_over(late, duration=20.0)
    link.ended = "somebody ended it"
    assert bridge.is_over(late, duration=20.0)
    assert not bridge.is_over(dataclasses.replace(late, time=10.0), duration=20.0)
    link.ended = None
    assert not bridge.is_over(late, duration=20.0)
    bridge.leave()
    assert bridge.is_over(late, duration=20.0)
