"""What the stack says, to whoever listens on ROS: topics announced, new listeners greeted, messages sent when due."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any

from han_bullet.messages import Observation
from han_bullet.ros.link import Link
from han_bullet.ros.publications import Publications
from han_bullet.stack import Decision, NavigationStack
from han_bullet.world_schema import World

Change = Callable[[str, Any], Any]  # of a topic's message into the one that is sent


def _unchanged(topic: str, message: Any) -> Any:
    return message


class Publisher:
    """Announce a stack's topics, say what never changes, and tick by tick what somebody listens to.

    Args:
        link: To ROS.
        world: The stack's.
        stack: Its layers and stages are watched from now on.
        left_out: Topics that somebody else says.
        change: What becomes of a message that never changes before it is sent.

    Attributes:
        robot_description: The robot's URDF.
    """

    def __init__(
        self,
        link: Link,
        world: World,
        stack: NavigationStack,
        *,
        left_out: Collection[str] = (),
        change: Change = _unchanged,
    ) -> None:
        self._link = link
        self._publications = Publications(world, [layer.name for layer in stack.layers])
        self._publications.watch_layers(stack)
        self._publications.watch_times(stack)
        self.robot_description = self._publications.robot_description
        self._joined: dict[str, int] = {}  # topic: how many have ever listened; 0 while nobody does
        for topic in self._publications.topics:
            if topic.name not in left_out:
                link.advertise(topic.name, topic.type, latched=topic.latched, size=topic.queue_size)
                self._joined[topic.name] = 0
        for outgoing in self._publications.statics():
            link.publish(outgoing.topic, change(outgoing.topic, outgoing.message))

    def tell(self, observation: Observation, decision: Decision, change: Change = _unchanged) -> None:
        """Send what is due of a tick, each message as `change` makes it."""
        for topic, before in self._joined.items():
            now = self._joined[topic] = self._link.listeners(topic)
            if now > before:
                self._publications.greet(topic)
        for outgoing in self._publications.of(observation, decision, lambda topic: self._joined.get(topic, 0) > 0):
            self._link.publish(outgoing.topic, change(outgoing.topic, outgoing.message))
