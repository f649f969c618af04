"""Bags and MCAP files: what is written is read again by others' libraries and by ROS itself, or there is no file."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import ros_master as ros
from mcap.reader import make_reader
from mosquitto import until
from rosbags.rosbag1 import Reader

from han_bullet.errors import BadInputError
from han_bullet.ros.bag import EARLIEST, open_bag
from han_bullet.ros.message_types import definition, deserialize, header, make
from han_bullet.ros.topics import Topic

MAP = Topic("/map", "nav_msgs/OccupancyGrid", "a map", latched=True)
ODOMETRY = Topic("/odom", "nav_msgs/Odometry", "odometry")
PEOPLE = Topic("/people", "people_msgs/People", "people")
NEVER = Topic("/never", "nav_msgs/Path", "nothing")
TOPICS = (MAP, ODOMETRY, PEOPLE, NEVER)
CELLS = np.random.default_rng(0).integers(-1, 101, 2_000_000, dtype=np.int8)  # more than a chunk of a file
READ_BY_ROS = Path(__file__).with_name("ros_bag_reader.py")


def grid() -> Any:
    return make("nav_msgs/OccupancyGrid", header=header(0.0, "map"), data=CELLS)


def odometry(time: float) -> Any:
    return make("nav_msgs/Odometry", header=header(time, "odom"), child_frame_id="base_link")


def write(path: Path, *, mcap: bool = False) -> Path:
    """A map, a hundred messages of odometry, one of people."""
    with open_bag(path, TOPICS, mcap=mcap) as bag:
        bag.write("/map", 0.0, grid())
        for number in range(100):
            bag.write("/odom", 0.05 * number, odometry(0.05 * number))
        bag.write("/people", 5.0, make("people_msgs/People", people=[make("people_msgs/Person", name="7")]))
    assert bag.counts == {"/map": 1, "/odom": 100, "/people": 1}
    return path


def test_a_bag_has_what_was_written_with_the_definitions_and_who_is_latched(tmp_path: Path) -> None:
    with Reader(write(tmp_path / "run.bag")) as reader:
        known = {connection.topic: connection for connection in reader.connections}
        messages = [(connection.topic, time, raw) for connection, time, raw in reader.messages()]
    assert set(known) == {"/map", "/odom", "/people"}
    assert [known[topic].ext.latching for topic in ("/map", "/odom", "/people")] == [1, 0, 0]
    assert all(known[topic.name].digest == definition(topic.type).md5 for topic in TOPICS[:3])
    (_, began, raw), *_ = (message for message in messages if message[0] == "/map")
    assert np.array_equal(deserialize("nav_msgs/OccupancyGrid", raw).data, CELLS)
    times = [time for topic, time, _ in messages if topic == "/odom"]
    assert times == [EARLIEST, *(round(5e7 * number) for number in range(1, 100))] and began == EARLIEST
    (raw,) = (raw for topic, _, raw in messages if topic == "/people")
    assert deserialize("people_msgs/People", raw).people[0].name == "7"


def test_an_mcap_file_has_what_was_written_as_a_viewer_wants_it(tmp_path: Path) -> None:
    with write(tmp_path / "run.mcap", mcap=True).open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_header().profile == "ros1"
        summary = reader.get_summary()
        messages = list(reader.iter_messages())
    assert summary is not None and summary.statistics is not None
    assert summary.statistics.message_count == len(messages) == 102
    assert {channel.topic: channel.metadata["latching"] for channel in summary.channels.values()} == {
        "/map": "1",
        "/odom": "0",
        "/people": "0",
    }
    for schema, channel, message in messages:
        assert schema is not None and (schema.encoding, channel.message_encoding) == ("ros1msg", "ros1")
        assert schema.data.decode() == definition(schema.name).text
        deserialize(schema.name, message.data)
    (data,) = (message.data for _, channel, message in messages if channel.topic == "/map")
    assert np.array_equal(deserialize("nav_msgs/OccupancyGrid", data).data, CELLS)
    assert [m.log_time for _, c, m in messages if c.topic == "/odom"] == [round(5e7 * number) for number in range(100)]


@pytest.fixture
def with_ros(request: pytest.FixtureRequest) -> None:
    if missing := ros.missing():
        (pytest.fail if request.config.getoption("--forbid-skips") else pytest.skip)(missing)


@pytest.mark.ros
@pytest.mark.usefixtures("with_ros")
def test_ros_itself_reads_a_bag(tmp_path: Path) -> None:
    """Compressed in several chunks, with the md5 sums that ROS has for its own types."""
    path = write(tmp_path / "run.bag")
    read = subprocess.run([ros.PYTHON, "-sE", READ_BY_ROS, path], capture_output=True, text=True)
    assert read.returncode == 0, read.stderr
    told = json.loads(read.stdout)
    assert told["counts"] == {"/map": 1, "/odom": 100, "/people": 1}
    assert told["compression"] == "lz4" and told["chunks"] > 1
    assert told["latching"] == {"/map": "1", "/odom": "0", "/people": "0"}
    assert told["foreign_md5"] == []
    last = told["last"]
    assert last["/map"]["data"] == zlib.crc32(CELLS.tobytes())
    assert (last["/odom"]["header"]["stamp"], last["/odom"]["child_frame_id"]) == (pytest.approx(4.95), "base_link")
    assert last["/people"]["people"][0]["name"] == "7"


@pytest.mark.ros
def test_rosbag_plays_a_bag_and_whoever_comes_late_gets_the_map(ros_master: ros.Master, tmp_path: Path) -> None:
    path = tmp_path / "run.bag"
    frames = make("geometry_msgs/TransformStamped", header=header(0.0, "map"), child_frame_id="odom")
    with open_bag(path, [MAP, Topic("/tf", "tf2_msgs/TFMessage", "frames")]) as bag:
        bag.write("/map", 0.0, grid())
        for number in range(2000):
            bag.write("/tf", 0.05 * number, make("tf2_msgs/TFMessage", transforms=[frames]))
    with ros.ros_client(ros_master) as client:
        client.subscribe("/tf", "tf2_msgs/TFMessage")
        command = [*ros.DIES_WITH_US, "/usr/bin/rosbag", "play", "--quiet", path]
        player = subprocess.Popen(command, stdin=subprocess.DEVNULL, env=ros_master.environment())
        try:
            heard: list[Any] = []
            until(lambda: bool(heard.extend(client.collected("/tf")) or len(heard) > 10), ros.PATIENCE)
            late = client.wait_for_message("/map", "nav_msgs/OccupancyGrid")
        finally:
            player.kill()
            player.wait()
    assert late["data"] == CELLS.tolist()
    assert heard[0]["transforms"][0]["child_frame_id"] == "odom"


@pytest.mark.parametrize("mcap", [False, True])
def test_what_breaks_off_leaves_the_old_file(mcap: bool, tmp_path: Path) -> None:
    path = tmp_path / "run"
    path.write_text("old")
    with pytest.raises(KeyboardInterrupt), open_bag(path, TOPICS, mcap=mcap) as bag:
        bag.write("/map", 0.0, grid())
        raise KeyboardInterrupt
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("mcap", [False, True])
def test_an_older_file_and_the_remains_of_a_killed_process_are_replaced(mcap: bool, tmp_path: Path) -> None:
    path = tmp_path / "run"
    for stale in (path, tmp_path / "run.tmp"):
        stale.write_text("old")
    assert write(path, mcap=mcap).stat().st_size > len(CELLS) // 2
    assert list(tmp_path.iterdir()) == [path]


@pytest.fixture
def little_space() -> Iterator[None]:
    """No file may become larger than 100 kB, as if the disk were full."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, hard))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.usefixtures("little_space")
@pytest.mark.parametrize("mcap", [False, True])
def test_a_full_disk_is_told_with_the_files_name_and_leaves_nothing(mcap: bool, tmp_path: Path) -> None:
    path = tmp_path / "run"
    with pytest.raises(OSError, match="File too large") as caught:
        write(path, mcap=mcap)
    assert caught.value.filename == str(path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("package", ["mcap.writer", "rosbags.rosbag1"])
def test_a_missing_package_is_named_with_what_brings_it(
    package: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(BadInputError, match=r"han_bullet\[ros\]"), open_bag(tmp_path / "run.bag", TOPICS):
        pass
    assert list(tmp_path.iterdir()) == []
