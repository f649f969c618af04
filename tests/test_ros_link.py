"""The link to the node, with a real master and real rospy clients, each test with its own."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from mosquitto import until
from ros_master import Master, ros_client

from han_bullet.ros.link import Incoming, Link
from han_bullet.ros.message_types import deserialize, header, make

pytestmark = pytest.mark.ros


@pytest.fixture
def link(ros_master: Master) -> Iterator[Link]:
    with Link() as link:
        yield link


def taken(link: Link) -> Incoming:
    """The next that comes from ROS."""
    found: list[Incoming] = []
    until(lambda: bool(found.extend(link.received()) or found))
    assert len(found) == 1
    return found[0]


def test_a_message_arrives_with_every_value(ros_master: Master, link: Link) -> None:
    link.advertise("/map", "nav_msgs/OccupancyGrid", latched=True)
    cells = np.arange(-1, 99, dtype=np.int8)
    info = make("nav_msgs/MapMetaData", resolution=0.5, width=10, height=10)
    link.publish("/map", make("nav_msgs/OccupancyGrid", header=header(1.25, "map"), info=info, data=cells))
    with ros_client(ros_master) as client:
        grid = client.wait_for_message("/map", "nav_msgs/OccupancyGrid")
    assert grid["header"]["stamp"] == 1.25 and grid["header"]["frame_id"] == "map"
    assert (grid["info"]["resolution"], grid["info"]["width"]) == (0.5, 10)
    assert grid["data"] == cells.tolist()


def test_a_long_message_arrives_with_every_value(ros_master: Master, link: Link) -> None:
    link.advertise("/image", "sensor_msgs/Image", latched=True)
    pixels = np.random.default_rng(0).integers(0, 256, 480 * 640 * 3, dtype=np.uint8)
    link.publish("/image", make("sensor_msgs/Image", height=480, width=640, step=1920, encoding="rgb8", data=pixels))
    with ros_client(ros_master) as client:
        image = client.wait_for_message("/image", "sensor_msgs/Image")
    assert image["data"] == pixels.tobytes() and image["encoding"] == "rgb8"


def test_a_type_that_the_machines_ros_does_not_have_explains_itself(ros_master: Master, link: Link) -> None:
    link.advertise("/people", "people_msgs/People", latched=True)
    person = make("people_msgs/Person", name="7", position=make("geometry_msgs/Point", x=2.0), tags=["standing"])
    link.publish("/people", make("people_msgs/People", people=[person]))
    with ros_client(ros_master) as client:
        (heard,) = client.wait_for_message("/people", "people_msgs/People")["people"]
    assert (heard["name"], heard["position"]["x"], heard["tags"]) == ("7", 2.0, ["standing"])


def test_what_ros_publishes_comes_in(ros_master: Master, link: Link) -> None:
    link.subscribe("/goal", "geometry_msgs/PoseStamped")
    with ros_client(ros_master) as client:
        position = {"x": 3.0, "y": -1.5, "z": 0.0}
        goal = {"header": {"frame_id": "map", "stamp": 2.5}, "pose": {"position": position}}
        client.publish("/goal", "geometry_msgs/PoseStamped", goal)
        incoming = taken(link)
    assert (incoming.name, incoming.request) == ("/goal", None)
    pose = deserialize("geometry_msgs/PoseStamped", incoming.raw)
    assert (pose.pose.position.x, pose.pose.position.y, pose.header.frame_id) == (3.0, -1.5, "map")
