"""What the stack on a real robot says on ROS: all that it decides, and nothing that the robot says itself."""

from __future__ import annotations

import dataclasses
from typing import Any

from han_bullet.messages import Observation
from han_bullet.ros.dated import dated
from han_bullet.ros.frames import MAP
from han_bullet.ros.link import Link
from han_bullet.ros.publisher import Publisher
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
        of_robot = {*OF_ROBOT}
        of_robot |= {camera_topic(c.name, what) for c in world.cameras for what in ("image_raw", "camera_info")}
        self._publisher = Publisher(link, world, stack, left_out=of_robot, change=_from_map)

    def tell(self, observation: Observation, decision: Decision, epoch: float) -> None:
        """Publish what is due of a tick, stamped by the robot's clock, which the loop's began at [s]."""
        self._publisher.tell(observation, decision, lambda topic, message: dated(_from_map(topic, message), epoch))


def _from_map(topic: str, message: Any) -> Any:
    """Return a message with the transforms alone that begin at the map; the others are the robot's to tell."""
    if topic not in TRANSFORMS:
        return message
    return dataclasses.replace(message, transforms=[t for t in message.transforms if t.header.frame_id == MAP])
