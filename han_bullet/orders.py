"""The orders that a robot was given during a run, so that a reader knows why it went elsewhere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from han_bullet.episode import Hook, Tick
from han_bullet.messages import GoTo, HandOver, Order


@dataclass(frozen=True)
class GivenOrder:
    """An order that was given.

    Attributes:
        time: Of the first decision that knew of it [s].
        order: What was told.
    """

    time: float
    order: Order

    def as_json(self) -> dict[str, Any]:
        """Return it as result.json has it: places [m], yaw [rad], as they were given."""
        return {"time": round(self.time, 6), "order": self.order.name} | _task(self.order)


class GivenOrders(Hook):
    """Gather them tick by tick."""

    def __init__(self) -> None:
        self._given: list[GivenOrder] = []

    @property
    def orders(self) -> tuple[GivenOrder, ...]:
        """Return them in the order in which they were given."""
        return tuple(self._given)

    def record(self, tick: Tick) -> None:
        """Take note of the orders of a tick."""
        self._given += [GivenOrder(tick.decision.time, order) for order in tick.decision.orders]


def _task(order: Order) -> dict[str, Any]:
    if isinstance(order.task, GoTo):
        pose = order.task.pose_in_world
        return {"pose": [float(pose.x), float(pose.y), float(pose.yaw)]}
    if isinstance(order.task, HandOver):
        place, distance = order.task.place_in_world.tolist(), float(order.task.distance)
        return {"place": place, "distance": distance, "person": order.task.person}
    return {}
