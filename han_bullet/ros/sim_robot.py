"""The simulator as a robot behind ROS: it senses and obeys as a real one would, and knows nothing of any stack."""

from __future__ import annotations

import dataclasses
import logging
import math
import time
from collections.abc import Callable, Iterator
from typing import Any

from han_bullet.errors import BadInputError, WorkerDiedError
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.messages import Observation, PoseEstimate
from han_bullet.recorder import TraceRecorder
from han_bullet.ros.camera_messages import calibration_message, image_message
from han_bullet.ros.frames import MAP
from han_bullet.ros.link import Link
from han_bullet.ros.message_types import deserialize, make, stamp
from han_bullet.ros.order_readings import twist_in_body
from han_bullet.ros.robot_description import RobotDescription
from han_bullet.ros.robot_messages import Joints, odometry_message, scan_message
from han_bullet.ros.topics import DESCRIPTION, Outgoing, camera_topic, topics
from han_bullet.ros.transforms import Transforms
from han_bullet.sim.simulator import Simulator
from han_bullet.world_schema import CONTROL_PERIOD, World

COMMAND = "/cmd_vel"
OBEYS_FOR = 0.5  # [s] of simulation time: the robot stops when no command has come for longer
SIMULATED_TIME = "/use_sim_time"
BEHIND = 1.0  # [s] by the wall clock behind its pace that is worth a word
ALL_STILL = Pose2D(0.0, 0.0, 0.0)

_log = logging.getLogger(__name__)


class SimulatedRobot:
    """A robot in a simulated world, seen from ROS.

    Args:
        world: The concrete world.
        simulator: Of that world.
        link: To ROS.
        trace: Notes the truth, which ROS never hears of.
    """

    def __init__(self, world: World, simulator: Simulator, link: Link, trace: TraceRecorder) -> None:
        self._world, self._simulator, self._link, self._trace = world, simulator, link, trace
        robot = RobotDescription(world.robot.urdf)
        self._transforms = Transforms(world, robot)
        self._joints = Joints(robot.wheel_geometry)
        self._command, self._commanded_at = Twist2D(), -math.inf
        own = {"/clock", "/odom", "/tf", "/tf_static", "/joint_states", "/scan"}
        own |= {camera_topic(c.name, what) for c in world.cameras for what in ("image_raw", "camera_info")}
        for topic in topics([camera.name for camera in world.cameras], ()):
            if topic.name in own:
                link.advertise(topic.name, topic.type, latched=topic.latched, size=topic.queue_size)
        link.subscribe(COMMAND, "geometry_msgs/Twist")
        link.set_param(f"/{DESCRIPTION}", robot.text)
        link.set_param(SIMULATED_TIME, True)
        link.publish("/tf_static", _without_map(self._transforms.static()))

    def run(self, ended: Callable[[], bool], pace: float) -> None:
        """Live until told to end, or to the world's duration.

        Args:
            ended: Tells whether to end.
            pace: Simulated seconds per second, at most; a machine that is too slow for it is not made up for.

        Raises:
            WorkerDiedError: Somebody has ended the ROS node.
        """
        observation, due, behind = self._simulator.reset(), time.monotonic(), False
        while True:
            self._trace.note(self._simulator.truth)
            for outgoing in self._messages(observation):
                self._link.publish(outgoing.topic, outgoing.message)
            if observation.time >= self._world.duration or ended():
                return
            due = max(due + CONTROL_PERIOD / pace, time.monotonic() - BEHIND)
            ahead = due - time.monotonic()
            if ahead < -0.9 * BEHIND and not behind:
                behind = True
                _log.warning(
                    "this machine is too slow for pace %g; a smaller one, or fewer cameras, would be right", pace
                )
            time.sleep(max(ahead, 0.0))
            observation = self._simulator.step(self._heard(observation.time))

    def _heard(self, now: float) -> Twist2D:
        """Return the command to obey at a simulation time [s]."""
        if self._link.ended is not None:
            raise WorkerDiedError(f"the ROS node was told to end ({self._link.ended})")
        for incoming in self._link.received():
            try:
                self._command = twist_in_body(deserialize("geometry_msgs/Twist", incoming.raw))
                self._commanded_at = now
            except BadInputError as error:
                _log.warning("%s: %s", COMMAND, error)
        return self._command if now - self._commanded_at <= OBEYS_FOR else Twist2D()

    def _messages(self, seen: Observation) -> Iterator[Outgoing]:
        """Return what the robot says of an observation; the clock first, for those who live by it."""
        robot, now = self._world.robot, seen.time
        self._joints.advance(seen.odometry)
        nowhere = PoseEstimate(now, ALL_STILL)
        yield Outgoing("/clock", make("rosgraph_msgs/Clock", clock=stamp(now)))
        yield Outgoing("/tf", _without_map(self._transforms.moving(nowhere, seen.odometry, self._joints.angles)))
        yield Outgoing("/joint_states", self._joints.message(now))
        for image in seen.images:
            yield Outgoing(camera_topic(image.camera, "image_raw"), image_message(image))
            info = calibration_message(image.intrinsics, image.camera, image.time)
            yield Outgoing(camera_topic(image.camera, "camera_info"), info)
        if seen.laser is not None and robot.laser is not None:
            yield Outgoing("/scan", scan_message(seen.laser, robot.laser.ticks_per_scan * CONTROL_PERIOD))
        yield Outgoing("/odom", odometry_message(seen.odometry, robot.slip))


def _without_map(message: Any) -> Any:
    """Return a tf2_msgs/TFMessage without what only the truth tells: where things are on the map."""
    return dataclasses.replace(message, transforms=[t for t in message.transforms if t.header.frame_id != MAP])
