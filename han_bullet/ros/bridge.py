"""A run on ROS: it publishes what the robot sees and decides, and takes orders."""

from __future__ import annotations

from han_bullet.device_channel import DeviceChannel
from han_bullet.episode import Hook, Operator, Tick
from han_bullet.ros.link import Link
from han_bullet.ros.orders import RosOrders
from han_bullet.ros.publisher import Publisher
from han_bullet.ros.topics import DESCRIPTION
from han_bullet.stack import Decision, NavigationStack
from han_bullet.world_schema import World


class RosBridge(Operator, Hook):
    """Look on at every tick, publish what somebody listens to, and give the robot the orders that come from ROS.

    Args:
        link: To ROS.
        stays: Whether to stay on after the task's end, waiting for the next order.
    """

    def __init__(self, link: Link, *, stays: bool = False) -> None:
        self._link, self._stays = link, stays
        link.set_param("/use_sim_time", True)  # others read it when they start, which they may do now
        self._orders = RosOrders(link)
        self._leaves = False

    def begin(self, world: World, stack: NavigationStack, channel: DeviceChannel) -> None:
        """Advertise, subscribe, and say what never changes."""
        self._publisher = Publisher(self._link, world, stack)
        self._link.set_param(f"/{DESCRIPTION}", self._publisher.robot_description)
        self._orders.begin(world, stack, channel)

    def record(self, tick: Tick) -> None:
        """Publish what a tick has come to, as far as somebody listens."""
        self._publisher.tell(tick.observation, tick.decision)

    def attend(self, decision: Decision) -> None:
        """Give the orders that have come."""
        self._orders.attend(decision)

    def is_over(self, decision: Decision, duration: float) -> bool:
        """Tell whether the episode is over: for who stays, not before they leave or nobody can reach them any more."""
        stays = self._stays and self._link.ended is None
        return self._leaves or (not stays and super().is_over(decision, duration))

    def leave(self) -> None:
        """Let the episode end after this tick."""
        self._leaves = True
