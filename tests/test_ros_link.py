"""The link to the node, with a real master and real rospy clients, each test with its own."""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest
from mosquitto import until
from ros_master import Client, Master, ros_client

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


def listening(process_id: int) -> list[str]:
    """Addresses of this machine at which a process takes connections."""
    connections = psutil.Process(process_id).net_connections("inet")
    return [connection.laddr.ip for connection in connections if connection.status == psutil.CONN_LISTEN]


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


def test_a_service_is_answered_with_a_response_or_with_why_there_is_none(ros_master: Master, link: Link) -> None:
    link.serve("/make_plan", "nav_msgs/GetPlan")
    with ros_client(ros_master) as client, answering(link) as questions:
        plan = client.call("/make_plan", "nav_msgs/GetPlan", {"tolerance": 0.5})
        assert len(plan["plan"]["poses"]) == 3
        with pytest.raises(RuntimeError, match="no way leads there"):
            client.call("/make_plan", "nav_msgs/GetPlan", {"tolerance": 0.0})
    assert [question.tolerance for question in questions] == [0.5, 0.0]


@contextlib.contextmanager
def answering(link: Link) -> Iterator[list[Any]]:
    """A thread that answers as long as one may stray from the goal."""
    over, questions = threading.Event(), []

    def answer() -> None:
        while not over.wait(0.01):
            for incoming in link.received():
                assert incoming.request is not None
                questions.append(deserialize("nav_msgs/GetPlanRequest", incoming.raw))
                if questions[-1].tolerance == 0.0:
                    link.reply(incoming.request, error="no way leads there")
                else:
                    poses = [make("geometry_msgs/PoseStamped")] * 3
                    link.reply(
                        incoming.request, make("nav_msgs/GetPlanResponse", plan=make("nav_msgs/Path", poses=poses))
                    )

    thread = threading.Thread(target=answer)
    thread.start()
    try:
        yield questions
    finally:
        over.set()
        thread.join()


def test_a_service_of_a_type_that_no_package_has_is_told(link: Link, caplog: pytest.LogCaptureFixture) -> None:
    link.serve("/guess", "no_such_msgs/Guess")
    until(lambda: any("no_such_msgs/Guess" in line for line in caplog.messages))
    assert link.restarts == 0


def test_a_parameter_is_set_and_a_value_that_ros_cannot_have_is_told(
    ros_master: Master, link: Link, caplog: pytest.LogCaptureFixture
) -> None:
    link.set_param("/too_large", 2**40)
    link.set_param("/robot_description", "<robot/>")
    with ros_client(ros_master) as client:
        until(lambda: client.param("/robot_description") == "<robot/>")
    until(lambda: any("/too_large" in line for line in caplog.messages))
    with pytest.raises(TypeError):
        link.set_param("/no_json", object())


def test_the_log_is_heard_in_rosout(ros_master: Master, link: Link) -> None:
    with ros_client(ros_master) as client:
        client.subscribe("/rosout", "rosgraph_msgs/Log")
        until(lambda: link.log("warn", "the way is blocked") or said(client, "the way is blocked", level=4))
        link.close()
        assert client.node("/han_bullet") is None


def said(client: Client, text: str, level: int) -> bool:
    heard = client.collected("/rosout")
    return any((line["msg"], line["level"], line["name"]) == (text, level, "/han_bullet") for line in heard)


def test_listeners_are_counted_as_they_come_and_go(ros_master: Master, link: Link) -> None:
    link.advertise("/odom", "nav_msgs/Odometry")
    assert link.listeners("/odom") == 0
    with ros_client(ros_master) as client:
        client.subscribe("/odom", "nav_msgs/Odometry")
        until(lambda: link.listeners("/odom") == 1)
        with ros_client(ros_master) as other:
            other.subscribe("/odom", "nav_msgs/Odometry")
            until(lambda: link.listeners("/odom") == 2)
    until(lambda: link.listeners("/odom") == 0)
    with ros_client(ros_master) as client:
        client.subscribe("/odom", "nav_msgs/Odometry")
        until(lambda: link.listeners("/odom") == 3)


def test_the_newest_is_heard_of_more_than_the_queue_holds(ros_master: Master, link: Link) -> None:
    link.subscribe("/numbers", "std_msgs/Int32", size=3)
    with ros_client(ros_master) as client:
        for number in range(50):
            client.publish("/numbers", "std_msgs/Int32", {"data": number})
        found: list[int] = []

        def last_is_there() -> bool:
            waiting = [deserialize("std_msgs/Int32", incoming.raw).data for incoming in link.received()]
            assert len(waiting) <= 3
            found.extend(waiting)
            return found[-1:] == [49]

        until(last_is_there)
    assert found == sorted(found)


def test_a_value_that_ros_cannot_have_is_told_and_the_next_message_goes(
    ros_master: Master, link: Link, caplog: pytest.LogCaptureFixture
) -> None:
    link.advertise("/number", "std_msgs/Int32", latched=True)
    link.publish("/number", make("std_msgs/Int32", data="seven"))
    until(lambda: any("/number has a value" in line for line in caplog.messages))
    link.publish("/number", make("std_msgs/Int32", data=7))
    with ros_client(ros_master) as client:
        assert client.wait_for_message("/number", "std_msgs/Int32") == {"data": 7}


def test_what_waits_is_sent_before_the_link_closes(ros_master: Master) -> None:
    with ros_client(ros_master) as client:
        with Link() as link:
            link.advertise("/numbers", "std_msgs/Int32", size=100)
            client.subscribe("/numbers", "std_msgs/Int32")
            until(lambda: link.listeners("/numbers") == 1)
            for number in range(100):
                link.publish("/numbers", make("std_msgs/Int32", data=number))
        heard: list[int] = []
        until(lambda: heard.extend(one["data"] for one in client.collected("/numbers")) or len(heard) == 100)
        until(lambda: client.node("/han_bullet") is None)
    assert heard == list(range(100))


def test_a_publisher_of_another_type_is_not_heard(ros_master: Master, link: Link) -> None:
    link.subscribe("/number", "std_msgs/Int32")
    with ros_client(ros_master) as wrong, ros_client(ros_master) as right:
        wrong.advertise("/number", "std_msgs/String")
        right.publish("/number", "std_msgs/Int32", {"data": 7})
        assert deserialize("std_msgs/Int32", taken(link).raw).data == 7  # by now the node knows of both
        with pytest.raises(RuntimeError, match="nobody listens"):
            wrong.publish("/number", "std_msgs/String", {"data": "seven"}, timeout=0.5)


def test_only_this_machine_may_connect(ros_master: Master, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_IP")
    with Link() as link:
        link.advertise("/odom", "nav_msgs/Odometry")
        until(lambda: len(listening(link.process_id)) == 2)  # one for the master and nodes to ask, one for messages
        assert set(listening(link.process_id)) == {"127.0.0.1"}


def test_whoever_names_an_address_lets_others_in(ros_master: Master, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_IP")
    monkeypatch.setenv("ROS_HOSTNAME", socket.gethostname())
    with Link() as link:
        assert "0.0.0.0" in listening(link.process_id)


def test_the_node_inherits_nothing_of_this_python(ros_master: Master, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", "/nowhere")
    with Link() as link:
        environment = Path(f"/proc/{link.process_id}/environ").read_text().split("\0")
    assert not any(line.startswith(("PYTHONPATH=", "VIRTUAL_ENV=", "PYTHONHOME=")) for line in environment)
    assert f"ROS_MASTER_URI={ros_master.uri}" in environment
