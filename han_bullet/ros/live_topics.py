"""What the stack on a real robot says on ROS: all that it decides, and nothing that the robot says itself."""

from __future__ import annotations

import dataclasses
from typing import Any

from han_bullet.messages import Observation
from han_bullet.ros.dated import dated
from han_bullet.ros.frames import MAP
from han_bullet.ros.link import Link
from han_bullet.ros.publications import Publications
from han_bullet.ros.topics import camera_topic
from han_bullet.stack import Decision, NavigationStack
from han_bullet.world_schema import World

OF_ROBOT = ("/clock", "/odom", "/joint_states", "/scan", "/cmd_vel")
TRANSFORMS = ("/tf", "/tf_static")


class LiveTopics:
    """Publish map, plan, costmap, people, transforms from the map and so on, to whoever listens.

    Args:
        world: The robot's.
        stack: Whose layers and stages are watched.
        link: To ROS.
    """

    def __init__(self, world: World, stack: NavigationStack, link: Link) -> None:
        self._link = link
        self._publications = Publications(world, [layer.name for layer in stack.layers])
        self._publications.watch_layers(stack)
        self._publications.watch_times(stack)
        of_robot = {*OF_ROBOT}
        of_robot |= {camera_topic(c.name, what) for c in world.cameras for what in ("image_raw", "camera_info")}
        self._listeners: dict[str, int] = {}
        for topic in self._publications.topics:
            if topic.name not in of_robot:
                link.advertise(topic.name, topic.type, latched=topic.latched, size=topic.queue_size)
                self._listeners[topic.name] = 0
        for outgoing in self._publications.statics():
            link.publish(outgoing.topic, _from_map(outgoing.topic, outgoing.message))

    def tell(self, observation: Observation, decision: Decision, epoch: float) -> None:
        """Publish what is due of a tick, stamped by the robot's clock, which the loop's began at [s]."""
        for topic, before in self._listeners.items():
            now = self._link.listeners(topic)
            if now > before:
                self._publications.greet(topic)
            self._listeners[topic] = now
        for outgoing in self._publications.of(observation, decision, lambda name: self._listeners.get(name, 0) > 0):
            message = dated(_from_map(outgoing.topic, outgoing.message), epoch)
            self._link.publish(outgoing.topic, message)


def _from_map(topic: str, message: Any) -> Any:
    """Return a message with the transforms alone that begin at the map; the others are the robot's to tell."""
    if topic not in TRANSFORMS:
        return message
    return dataclasses.replace(message, transforms=[t for t in message.transforms if t.header.frame_id == MAP])
