"""Orders from ROS, taken between two ticks: goals, cancelling, hand-overs, driving by hand, devices, two services."""

from __future__ import annotations

import functools
import logging
from collections.abc import Callable

import numpy as np

from han_bullet.checks import check_goal
from han_bullet.device_channel import DeviceChannel
from han_bullet.device_payload import write_payload
from han_bullet.errors import BadInputError
from han_bullet.messages import DeviceMessage, GoTo, HandOver
from han_bullet.ros.frames import MAP
from han_bullet.ros.link import Incoming, Link
from han_bullet.ros.message_types import deserialize, make
from han_bullet.ros.navigation_messages import plan_message
from han_bullet.ros.order_readings import pose_on_floor, twist_in_body
from han_bullet.ros.topics import TELEOPERATION
from han_bullet.stack import Decision, NavigationStack
from han_bullet.world_schema import World

GOAL = "/move_base_simple/goal"
SESSION = "ros"  # what states of devices that come from ROS are signed with
REPEATED_EVERY = 1.0  # [s]: a device that is not heard for 3 s counts as silent
POSE_IS_KNOWN = {
    "lidar": "localizes itself by its laser, and finds itself where it is lost",
    "odometry": "goes by its odometry from the world's start, and must be put there and started anew",
}
MOST_AT_ONCE = 8  # orders of one kind between two ticks

_log = logging.getLogger(__name__)


class RosOrders:
    """Pass on to the robot what ROS says; refuse, with the reason on /rosout, what it cannot do.

    Args:
        link: To ROS.
        goal: Topic of goals.
    """

    def __init__(self, link: Link, goal: str = GOAL) -> None:
        self._link, self._goal = link, goal
        self._told: dict[str, tuple[bool, float]] = {}  # of devices: state, and when it was last passed on [s]
        self._hears: dict[str, Callable[[Incoming, Decision], None]] = {}

    def begin(self, world: World, stack: NavigationStack, channel: DeviceChannel) -> None:
        """Subscribe and serve."""
        self._world, self._stack, self._channel = world, stack, channel
        self._hear(self._goal, "geometry_msgs/PoseStamped", self._go)
        self._hear("/move_base/cancel", "actionlib_msgs/GoalID", lambda incoming, decision: stack.cancel())
        self._hear("/hand_over", "std_msgs/Int32", self._hand_over)
        self._hear(TELEOPERATION, "geometry_msgs/Twist", self._drive)
        self._hear("/initialpose", "geometry_msgs/PoseWithCovarianceStamped", self._refuse_pose)
        for device in world.devices:
            take = functools.partial(self._device, device.name)
            self._hear(f"/{device.name}/state", "std_msgs/Bool", take)
        self._serve("/move_base/make_plan", "nav_msgs/GetPlan", self._plan)
        self._serve("/move_base/clear_costmaps", "std_srvs/Empty", self._clear)

    def attend(self, decision: Decision) -> None:
        """Carry out what has come since the last tick."""
        for incoming in self._link.received():
            self.obey(incoming, decision)
        self.repeat(decision)

    def obey(self, incoming: Incoming, decision: Decision) -> None:
        """Carry out an order, or refuse it."""
        try:
            self._hears[incoming.name](incoming, decision)
        except BadInputError as error:
            self._refuse(incoming, error)

    def repeat(self, decision: Decision) -> None:
        """Pass on the devices' states again, as often as devices do."""
        for device, (on, told_at) in self._told.items():
            if decision.time - told_at >= REPEATED_EVERY:
                self._tell(device, on, decision.time)

    def _hear(self, topic: str, kind: str, take: Callable[[Incoming, Decision], None]) -> None:
        self._hears[topic] = take
        self._link.subscribe(topic, kind, size=MOST_AT_ONCE)

    def _serve(self, service: str, kind: str, answer: Callable[[Incoming, Decision], None]) -> None:
        self._hears[service] = answer
        self._link.serve(service, kind)

    def _refuse(self, incoming: Incoming, error: BadInputError) -> None:
        text = f"{incoming.name} refused: {error}"
        _log.warning("%s", text)
        self._link.log("warn", text)
        if incoming.request is not None:
            self._link.reply(incoming.request, error=str(error))

    def _go(self, incoming: Incoming, decision: Decision) -> None:
        task = GoTo(pose_on_floor(deserialize("geometry_msgs/PoseStamped", incoming.raw)))
        check_goal(self._world, task)
        self._stack.take(task)

    def _hand_over(self, incoming: Incoming, decision: Decision) -> None:
        person = int(deserialize("std_msgs/Int32", incoming.raw).data)
        self._stack.take(HandOver(np.zeros(2), person=person))  # to them, wherever they are

    def _drive(self, incoming: Incoming, decision: Decision) -> None:
        self._stack.override(twist_in_body(deserialize("geometry_msgs/Twist", incoming.raw)))

    def _device(self, device: str, incoming: Incoming, decision: Decision) -> None:
        self._tell(device, bool(deserialize("std_msgs/Bool", incoming.raw).data), decision.time)

    def _tell(self, device: str, on: bool, time: float) -> None:
        """Pass a device's state on; it stands until ROS says another, so it is repeated as devices do."""
        self._told[device] = on, time
        self._channel.publish(device, write_payload(DeviceMessage(device, time, on, SESSION)))

    def _refuse_pose(self, incoming: Incoming, decision: Decision) -> None:
        pose, name = decision.estimate.pose_robot_in_world, self._stack.localization.name
        raise BadInputError(
            f"the robot {POSE_IS_KNOWN.get(name, f'has its pose from the {name}')}; it takes itself to be at "
            f"x {pose.x:.2f} m, y {pose.y:.2f} m in {MAP!r}"
        )

    def _plan(self, incoming: Incoming, decision: Decision) -> None:
        asked = deserialize("nav_msgs/GetPlanRequest", incoming.raw)
        here = decision.estimate.pose_robot_in_world
        start = pose_on_floor(asked.start) if asked.start.header.frame_id else here
        goal = pose_on_floor(asked.goal)
        path = self._stack.plan_between(start.position, goal.position)
        assert incoming.request is not None
        self._link.reply(incoming.request, make("nav_msgs/GetPlanResponse", plan=plan_message(path, decision.time)))

    def _clear(self, incoming: Incoming, decision: Decision) -> None:
        self._stack.clear_obstacles()
        assert incoming.request is not None
        self._link.reply(incoming.request)
