"""The topics that the robot publishes: names, types and how often; docs/ros.md shows the same table."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from han_bullet.markdown import markdown_table

GLOBAL_COSTMAP = "/move_base/global_costmap"
COSTMAP, COSTMAP_UPDATES = f"{GLOBAL_COSTMAP}/costmap", f"{GLOBAL_COSTMAP}/costmap_updates"
FOOTPRINT = f"{GLOBAL_COSTMAP}/footprint"
DESCRIPTION = "robot_description"  # the name of the parameter
PLAN, CURRENT_GOAL = "/move_base/GlobalPlanner/plan", "/move_base/current_goal"
TELEOPERATION = "/cmd_vel_teleop"  # heard, not said
ROBOT_POSE, PEOPLE_MARKERS, DETECTION_MARKERS = "/amcl_pose", "/people_markers", "/detection_markers"


@dataclass(frozen=True)
class Topic:
    """What is published under one name.

    Attributes:
        name: With its namespace.
        type: Such as "nav_msgs/Odometry".
        about: One line on what it is.
        rate: How often at most [Hz]; None: with each tick, or whenever there is something new.
        latched: Whether who comes later gets the last message.
        queue_size: How many messages may wait for a slow subscriber.
    """

    name: str
    type: str
    about: str
    rate: float | None = None
    latched: bool = False
    queue_size: int = 1


@dataclass(frozen=True)
class Outgoing:
    """A message on its way to a topic."""

    topic: str
    message: Any


def topics(cameras: Sequence[str], layers: Sequence[str]) -> tuple[Topic, ...]:
    """Return every topic of a robot with some cameras and costmap layers, by their names."""
    return (*_of_robot(), *_of_navigation(), *_of_costmap(layers), *_of_people(), *_of_cameras(cameras))


def table(cameras: Sequence[str], layers: Sequence[str]) -> str:
    """Return all topics as a Markdown table."""
    rows = [(f"`{t.name}`", f"`{t.type}`", _how_often(t), t.about) for t in topics(cameras, layers)]
    return markdown_table(("topic", "type", "how often", "what"), rows)


def _how_often(topic: Topic) -> str:
    if topic.latched:
        return "latched"
    return "as it comes" if topic.rate is None else f"{topic.rate:g} Hz at most"


def layer_topic(layer: str) -> str:
    """Return the topic of what a costmap layer adds."""
    return f"{GLOBAL_COSTMAP}/{layer}/grid"


def camera_topic(camera: str, what: str) -> str:
    """Return a topic of a camera: image_raw, camera_info or image_boxes."""
    return f"/{camera}/{what}"


def _of_robot() -> Iterator[Topic]:
    yield Topic("/clock", "rosgraph_msgs/Clock", "simulation time")
    yield Topic("/tf", "tf2_msgs/TFMessage", "map -> odom -> base_link -> wheels", queue_size=100)
    yield Topic("/tf_static", "tf2_msgs/TFMessage", "head, laser and cameras", latched=True, queue_size=100)
    yield Topic("/odom", "nav_msgs/Odometry", "what the wheels tell; the twist in base_link", queue_size=10)
    yield Topic("/joint_states", "sensor_msgs/JointState", "head and wheels", queue_size=10)
    yield Topic("/cmd_vel", "geometry_msgs/Twist", "the command as executed", queue_size=10)
    yield Topic("/scan", "sensor_msgs/LaserScan", "each sweep of the scanner")
    yield Topic(ROBOT_POSE, "geometry_msgs/PoseWithCovarianceStamped", "where it believes itself to be", 10.0)
    yield Topic("/trajectory", "nav_msgs/Path", "where it has been, the last 1000 poses", 1.0)
    yield Topic("/diagnostics", "diagnostic_msgs/DiagnosticArray", "sensors and stages: level, rate, latency", 1.0)


def _of_navigation() -> Iterator[Topic]:
    yield Topic("/map", "nav_msgs/OccupancyGrid", "the building as the robot's map has it", latched=True)
    yield Topic(CURRENT_GOAL, "geometry_msgs/PoseStamped", "where the task leads", 5.0)
    yield Topic(PLAN, "nav_msgs/Path", "the way; empty where there is none", 5.0)


def _of_costmap(layers: Sequence[str]) -> Iterator[Topic]:
    yield Topic(COSTMAP, "nav_msgs/OccupancyGrid", "the whole, for new subscribers and every 5 s", 5.0)
    yield Topic(COSTMAP_UPDATES, "map_msgs/OccupancyGridUpdate", "the window that has changed", 5.0, queue_size=10)
    yield Topic(FOOTPRINT, "geometry_msgs/PolygonStamped", "the robot's outline on the map")
    for layer in layers:
        about = f"what the {layer} layer adds to those before it"
        yield Topic(layer_topic(layer), "nav_msgs/OccupancyGrid", about, 2.0)


def _of_people() -> Iterator[Topic]:
    yield Topic("/people", "people_msgs/People", "tracked people; yaw, posture and seat in the tags", 10.0)
    yield Topic(PEOPLE_MARKERS, "visualization_msgs/MarkerArray", "the same for rviz, with covariance", 10.0)
    yield Topic(DETECTION_MARKERS, "visualization_msgs/MarkerArray", "measurements on the floor, by camera and laser")


def _of_cameras(cameras: Sequence[str]) -> Iterator[Topic]:
    for name in cameras:
        yield Topic(camera_topic(name, "image_raw"), "sensor_msgs/Image", "each image, rgb8")
        yield Topic(camera_topic(name, "camera_info"), "sensor_msgs/CameraInfo", "calibration, with each image")
        yield Topic(camera_topic(name, "image_boxes"), "sensor_msgs/Image", "each image with the people found in it")
