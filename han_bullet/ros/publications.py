"""All that the robot says on ROS: observation and decision to messages, and only those that are wanted."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from han_bullet.costmap.layers import STANDARD
from han_bullet.messages import CameraImage, Detections, Observation
from han_bullet.ros.camera_messages import calibration_message, image_message, image_with_boxes
from han_bullet.ros.costmap_stream import CostmapStream
from han_bullet.ros.diagnostics import Diagnostics
from han_bullet.ros.layer_grids import WatchedLayer
from han_bullet.ros.message_types import make, stamp
from han_bullet.ros.navigation_messages import Trajectory, goal_message, plan_message
from han_bullet.ros.occupancy import grid_message, occupancy
from han_bullet.ros.people_markers import PeopleMarkers, detection_markers
from han_bullet.ros.people_messages import people_message
from han_bullet.ros.robot_description import RobotDescription
from han_bullet.ros.robot_messages import (
    Footprint,
    Joints,
    estimate_message,
    odometry_message,
    scan_message,
    twist_message,
)
from han_bullet.ros.stage_times import StageTimes
from han_bullet.ros.topics import (
    COSTMAP,
    COSTMAP_UPDATES,
    CURRENT_GOAL,
    DETECTION_MARKERS,
    FOOTPRINT,
    PEOPLE_MARKERS,
    PLAN,
    ROBOT_POSE,
    Outgoing,
    camera_topic,
    layer_topic,
    topics,
)
from han_bullet.ros.transforms import Transforms
from han_bullet.stack import Decision, NavigationStack
from han_bullet.static_map import building_map
from han_bullet.world_schema import CONTROL_PERIOD, Camera, World

Source = Callable[[Observation, Decision], Any]  # the message of a topic, or None where there is nothing to say
STANDARD_LAYERS = tuple(layer.name for layer in STANDARD)


class Publications:
    """Know every topic, and make its messages when they are due and wanted.

    Nothing here changes what it is shown, so a run is the same with and without.

    Attributes:
        topics: All of them.
        robot_description: The robot's URDF, for the parameter of that name.
    """

    def __init__(self, world: World, layers: Sequence[str] = STANDARD_LAYERS) -> None:
        """Get ready for a world's robot and cameras.

        Args:
            world: The concrete world, with the cameras in use.
            layers: Names of the costmap's layers.
        """
        robot = RobotDescription(world.robot.urdf)
        self.topics = topics([camera.name for camera in world.cameras], layers)
        self.robot_description = robot.text
        self._world = world
        self._transforms = Transforms(world, robot)
        self._joints = Joints(robot.wheel_geometry)
        self._trajectory = Trajectory()
        self._times = StageTimes()
        self._diagnostics = Diagnostics(world, self._times)
        self._costmap = CostmapStream()
        self._layers: dict[str, WatchedLayer] = {}
        self._rates = {topic.name: topic.rate for topic in self.topics}
        self._sent_at: dict[str, float] = {}  # topic -> [s]
        self._sources = {**self._of_robot(), **self._of_people(), **_of_cameras(world), **self._of_layers(layers)}

    def watch_layers(self, stack: NavigationStack) -> None:
        """Let a stack's layers note what each adds while its grid is wanted; without this, layers have no grids."""
        layers = [WatchedLayer(layer) if layer_topic(layer.name) in self._rates else layer for layer in stack.layers]
        self._layers = {layer.name: layer for layer in layers if isinstance(layer, WatchedLayer)}
        stack.layers = tuple(layers)

    def watch_times(self, stack: NavigationStack) -> None:
        """Measure a stack's stages for the diagnostics, by the wall clock."""
        self._times.watch(stack)

    def statics(self) -> list[Outgoing]:
        """Return what never changes; all of it is latched."""
        grid = building_map(self._world)
        message = grid_message(grid.cells, grid.origin_in_world, grid.resolution, 0.0)
        return [Outgoing("/map", message), Outgoing("/tf_static", self._transforms.static())]

    def greet(self, topic: str) -> None:
        """Take note that somebody new listens to a topic: it is due at once, and a costmap as a whole."""
        self._sent_at.pop(topic, None)
        if topic in (COSTMAP, COSTMAP_UPDATES):
            self._sent_at.pop(COSTMAP, None)
            self._costmap.forget()

    def of(self, observation: Observation, decision: Decision, wanted: Callable[[str], bool]) -> Iterator[Outgoing]:
        """Return the messages of a tick that are due and wanted, each made when it is asked for.

        To be called at every tick in turn, also while nobody listens: wheels turn on, and the way grows longer.

        Args:
            observation: Of the tick.
            decision: On it.
            wanted: Tells whether anybody listens to a topic.
        """
        self._joints.advance(observation.odometry)
        self._trajectory.add(decision.estimate)
        self._diagnostics.note(observation)
        return self._messages(observation, decision, wanted)

    def _messages(
        self, observation: Observation, decision: Decision, wanted: Callable[[str], bool]
    ) -> Iterator[Outgoing]:
        for topic, source in self._sources.items():
            if wanted(topic) and self._is_due(topic, decision.time):
                message = source(observation, decision)
                if message is not None:
                    self._sent_at[topic] = decision.time
                    yield Outgoing(topic, message)
        yield from self._costmaps(decision, wanted)
        for name, layer in self._layers.items():
            topic = layer_topic(name)
            layer.wanted = wanted(topic) and self._is_due(topic, decision.time + CONTROL_PERIOD)

    def _is_due(self, topic: str, time: float) -> bool:
        """Tell whether it is long enough since a topic's last message; also where the time has been set back."""
        rate = self._rates[topic]
        passed = time - self._sent_at.get(topic, -math.inf)
        return rate is None or not 0.0 <= passed < 1.0 / rate - 1e-6

    def _costmaps(self, decision: Decision, wanted: Callable[[str], bool]) -> Iterator[Outgoing]:
        whole, windows = wanted(COSTMAP), wanted(COSTMAP_UPDATES)
        if not whole and not windows:
            self._costmap.forget()
        elif self._is_due(COSTMAP, decision.time):
            self._sent_at[COSTMAP] = decision.time
            outgoing = self._costmap.next(decision.costmap, decision.time, windows=windows)
            if outgoing is not None and (whole or outgoing.topic == COSTMAP_UPDATES):
                yield outgoing

    def _of_robot(self) -> Mapping[str, Source]:
        robot, laser = self._world.robot, self._world.robot.laser
        footprint = Footprint(robot.radius)
        period = 0.0 if laser is None else laser.ticks_per_scan * CONTROL_PERIOD
        return {
            "/clock": lambda _, decision: make("rosgraph_msgs/Clock", clock=stamp(decision.time)),
            "/tf": lambda seen, decision: self._transforms.moving(
                decision.estimate, seen.odometry, self._joints.angles
            ),
            "/odom": lambda seen, _: odometry_message(seen.odometry, robot.slip),
            "/joint_states": lambda _, decision: self._joints.message(decision.time),
            "/cmd_vel": lambda _, decision: twist_message(decision.command),
            "/scan": lambda seen, _: None if seen.laser is None else scan_message(seen.laser, period),
            ROBOT_POSE: lambda _, decision: estimate_message(decision.estimate),
            "/trajectory": lambda _, decision: self._trajectory.message(decision.time),
            "/diagnostics": lambda _, decision: self._diagnostics.message(decision),
            CURRENT_GOAL: lambda _, decision: goal_message(decision.scene),
            PLAN: lambda _, decision: plan_message(decision.path, decision.time),
            FOOTPRINT: lambda _, decision: footprint.at(decision.estimate.pose_robot_in_world, decision.time),
        }

    def _of_people(self) -> Mapping[str, Source]:
        markers = PeopleMarkers()
        return {
            "/people": lambda _, decision: people_message(decision.people, decision.time),
            PEOPLE_MARKERS: lambda _, decision: markers.message(decision.people, decision.time),
            DETECTION_MARKERS: lambda _, decision: detection_markers(decision.scans, decision.legs, decision.time),
        }

    def _of_layers(self, layers: Sequence[str]) -> Mapping[str, Source]:
        return {layer_topic(name): self._of_layer(name) for name in layers}

    def _of_layer(self, name: str) -> Source:
        def grid(_: Observation, decision: Decision) -> Any | None:
            layer, costmap = self._layers.get(name), decision.costmap
            if layer is None or layer.added is None:
                return None
            return grid_message(occupancy(layer.added), costmap.origin_in_world, costmap.resolution, decision.time)

        return grid


def _of_cameras(world: World) -> Mapping[str, Source]:
    return {topic: source for camera in world.cameras for topic, source in _of_camera(camera).items()}


def _of_camera(camera: Camera) -> Mapping[str, Source]:
    """Return the sources of a camera's topics; images of a replayed run have no pixels and are not sent."""

    def raw(seen: Observation, _: Decision) -> Any | None:
        image = _image(seen, camera.name)
        return image_message(image) if image is not None and image.image.size else None

    def info(seen: Observation, _: Decision) -> Any | None:
        image = _image(seen, camera.name)
        return None if image is None else calibration_message(image.intrinsics, camera.name, image.time)

    def boxes(seen: Observation, decision: Decision) -> Any | None:
        image = _image(seen, camera.name)
        if image is None or not image.image.size:
            return None
        found = (f for f in decision.detections if f.camera == camera.name and f.time == image.time)
        return image_with_boxes(image, next(found, Detections.none()))

    topics_ = (camera_topic(camera.name, what) for what in ("image_raw", "camera_info", "image_boxes"))
    return dict(zip(topics_, (raw, info, boxes), strict=True))


def _image(seen: Observation, camera: str) -> CameraImage | None:
    return next((image for image in seen.images if image.camera == camera), None)
