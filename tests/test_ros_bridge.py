"""A run on ROS, seen and ordered about by rospy clients: `han-bullet run --ros`."""

from __future__ import annotations

import json
import math
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import ros_master as ros
from mosquitto import until
from ros_robot import Robot, robot_on_ros, run_command, stamped

from han_bullet.cli import main
from han_bullet.costmap.layers import layers_meant
from han_bullet.ros.topics import COSTMAP, COSTMAP_UPDATES
from han_bullet.runner import RunOptions, run_world

pytestmark = pytest.mark.ros


def stamp(message: dict[str, Any]) -> float:
    return float(message["header"]["stamp"])


def differing(one: list[int], other: list[int]) -> int:
    return sum(abs(a - b) for a, b in zip(one, other, strict=True))


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Iterator[Robot]:
    """One robot for all tests of this module; each leaves it standing."""
    if missing := ros.missing():
        (pytest.fail if request.config.getoption("--forbid-skips") else pytest.skip)(missing)
    folder = tmp_path_factory.mktemp("robot")
    with ros.running(tmp_path_factory.mktemp("ros"), program=True) as master, robot_on_ros(master, folder) as robot:
        robot.client.subscribe("/rosout", "rosgraph_msgs/Log")
        yield robot


def test_the_tree_of_frames_leads_from_the_map_to_the_wheels_and_cameras(robot: Robot) -> None:
    edges = {
        (t["header"]["frame_id"], t["child_frame_id"]) for t in robot.message("/tf", "tf2_msgs/TFMessage")["transforms"]
    }
    still = robot.message("/tf_static", "tf2_msgs/TFMessage")["transforms"]
    edges |= {(t["header"]["frame_id"], t["child_frame_id"]) for t in still}
    parents = {child: parent for parent, child in edges}
    assert len(parents) == len(edges)  # each frame has one parent
    assert {("map", "odom"), ("odom", "base_link")} <= edges

    def root(frame: str) -> str:
        return root(parents[frame]) if frame in parents else frame

    assert {root(frame) for frame in parents} == {"map"}
    assert {"camera1_optical_frame", "onboard_optical_frame", "laser"} <= parents.keys()


def test_the_map_is_latched_and_the_robot_described_where_rviz_looks(robot: Robot) -> None:
    grid = robot.message("/map", "nav_msgs/OccupancyGrid")
    assert len(grid["data"]) == grid["info"]["width"] * grid["info"]["height"]
    assert set(grid["data"]) <= {-1, 0, 100}
    assert robot.client.param("/use_sim_time") is True
    assert "<robot" in robot.client.param("/robot_description")


def test_a_subscriber_that_applies_the_updates_has_the_whole_costmap(robot: Robot) -> None:
    robot.go_to(robot.position[0] + 0.5, 0.0)  # whereupon the person walks
    robot.client.subscribe(COSTMAP, "nav_msgs/OccupancyGrid")
    robot.client.subscribe(COSTMAP_UPDATES, "map_msgs/OccupancyGridUpdate")
    grids: list[dict[str, Any]] = []
    windows: list[dict[str, Any]] = []

    def has_two_apart() -> bool:  # each new listener is greeted with a whole grid, so the first ones come at once
        grids.extend(robot.client.collected(COSTMAP))
        windows.extend(robot.client.collected(COSTMAP_UPDATES))
        two = len(grids) >= 2 and stamp(grids[-1]) - stamp(grids[-2]) > 4.0
        return two and bool(windows) and stamp(windows[-1]) > stamp(grids[-1])  # no earlier one is still on its way

    until(has_two_apart, ros.PATIENCE)
    first, second = grids[-2:]
    between = [one for one in windows if stamp(first) < stamp(one) < stamp(second)]
    without = differing(first["data"], second["data"])
    left = differing(applied(first, between), second["data"])
    assert without > 10_000  # percent, summed over cells: in these 5 s somebody has walked on
    assert left < 0.2 * without  # what moved since the last window, a fifth of a second before


def applied(grid: dict[str, Any], windows: list[dict[str, Any]]) -> list[int]:
    """Cells of a grid after updates."""
    width, cells = grid["info"]["width"], list(grid["data"])
    for window in windows:
        for row in range(window["height"]):
            start = (window["y"] + row) * width + window["x"]
            cells[start : start + window["width"]] = window["data"][row * window["width"] : (row + 1) * window["width"]]
    return cells


def test_people_come_as_people_msgs_with_what_its_fields_have_no_room_for(robot: Robot) -> None:
    (person,) = robot.message("/people", "people_msgs/People")["people"]
    tags = dict(zip(person["tagnames"], person["tags"], strict=True))
    assert tags["posture"] in {"standing", "walking"}
    assert math.isfinite(float(tags["yaw"]))


def test_a_plan_is_made_without_going_there_and_costmaps_are_cleared(robot: Robot) -> None:
    before = robot.position
    request = {"start": stamped(2.0, 0.0), "goal": stamped(9.0, 0.5), "tolerance": 0.1}
    poses = robot.client.call("/move_base/make_plan", "nav_msgs/GetPlan", request)["plan"]["poses"]
    end = poses[-1]["pose"]["position"]
    assert math.dist((end["x"], end["y"]), (9.0, 0.5)) < 0.1
    assert robot.client.call("/move_base/clear_costmaps", "std_srvs/Empty") == {}
    assert math.dist(robot.position, before) < 0.05


@pytest.mark.parametrize(
    ("goal", "reason"),
    [
        (stamped(math.nan, 0.0), "not finite"),
        (stamped(5.0, 0.0, frame="odom"), "'odom'"),
        (stamped(5.0, 0.0, w=0.0), "of length 0"),
        (stamped(5.0, 1.55), "5.0, 1.55"),
        (stamped(50.0, 0.0), "50.0"),
    ],
)
def test_a_malformed_goal_is_refused_on_rosout_and_nothing_moves(
    robot: Robot, goal: dict[str, Any], reason: str
) -> None:
    robot.client.collected("/rosout")
    before = robot.odometry
    robot.send("/move_base_simple/goal", "geometry_msgs/PoseStamped", goal)
    said: list[str] = []

    def refused() -> bool:
        said.extend(log["msg"] for log in robot.client.collected("/rosout"))
        return any(reason in text and "/move_base_simple/goal refused" in text for text in said)

    until(refused, ros.PATIENCE)
    assert robot.speed < 0.01 and math.dist(robot.odometry, before) < 0.001


def test_a_pose_is_refused_with_a_word_why(robot: Robot) -> None:
    robot.client.collected("/rosout")
    robot.send("/initialpose", "geometry_msgs/PoseWithCovarianceStamped", {})
    until(lambda: any("localizes itself" in log["msg"] for log in robot.client.collected("/rosout")), ros.PATIENCE)


def test_a_goal_is_gone_to_and_cancelled_on_the_way(robot: Robot) -> None:
    x, _ = robot.position
    goal = (x + 1.0, 0.0) if x < 8.0 else (x - 1.0, 0.0)
    robot.go_to(*goal)
    until(lambda: math.dist(robot.position, goal) < 0.15 and robot.speed < 0.01, 2 * ros.PATIENCE)
    assert math.dist(robot.goal, goal) < 0.01
    robot.go_to(goal[0] + (4.0 if x < 8.0 else -4.0), 0.0)
    until(lambda: math.dist(robot.position, goal) > 0.5, ros.PATIENCE)
    robot.cancel()
    until(lambda: robot.speed < 0.01, ros.PATIENCE)
    assert 0.5 < math.dist(robot.position, goal) < 3.0


def test_somebody_drives_and_the_robot_stops_when_they_let_go(robot: Robot) -> None:
    before = robot.position
    for _ in range(10):
        robot.send("/cmd_vel_teleop", "geometry_msgs/Twist", {"linear": {"x": 0.3}})
    until(lambda: math.dist(robot.position, before) > 0.03, ros.PATIENCE)
    until(lambda: robot.speed < 0.01, ros.PATIENCE)
    assert math.dist(robot.position, before) < 2.0


def test_a_hand_over_goes_to_the_person_with_that_id_and_to_nobody_else(robot: Robot) -> None:
    (person,) = robot.message("/people", "people_msgs/People")["people"]
    robot.client.collected("/rosout")
    robot.send("/hand_over", "std_msgs/Int32", {"data": 77})
    until(lambda: any("77" in log["msg"] for log in robot.client.collected("/rosout")), ros.PATIENCE)
    robot.send("/hand_over", "std_msgs/Int32", {"data": int(person["name"])})
    at = person["position"]
    until(lambda: math.dist(robot.goal, (at["x"], at["y"])) < 2.5, ros.PATIENCE)
    robot.cancel()


def test_at_the_end_its_orders_stand_in_the_result(robot: Robot) -> None:
    def tv_was_heard() -> bool:
        rows = (robot.folder / "messages.csv").read_text().splitlines()
        return any("ros" in row.split(",") and "tv" in row for row in rows)

    robot.go_to(robot.position[0] + 0.3, 0.0)
    robot.send("/cmd_vel_teleop", "geometry_msgs/Twist", {"linear": {"x": 0.1}})
    robot.client.call("/move_base/clear_costmaps", "std_srvs/Empty")
    robot.cancel()
    robot.send("/tv/state", "std_msgs/Bool", {"data": True})
    until(tv_was_heard, ros.PATIENCE)
    robot.process.send_signal(signal.SIGINT)
    assert robot.process.wait(ros.PATIENCE) == 0, (robot.folder / "log").read_text()
    result = json.loads((robot.folder / "result.json").read_text())
    assert {"go_to", "drive", "clear_obstacles", "cancel"} <= {order["order"] for order in result["orders"]}
    assert tv_was_heard()
    assert not {"/odom", "/map", "/tf"} & robot.client.topics().keys()


WORLD = """\
name: short_way
description: The beginning of real2, somebody walks off as the robot moves, with a goal near by
extends: building
people:
  - name: walker
    start: [4.5, -0.2, 0.0]
    behaviour: {kind: walk, waypoints: [[15.5, -0.2]], speed: 0.35, starts: {when: robot_moves}}
robot: {start: [1.5, 0.0, 0.0]}
task: {kind: go_to, pose: [5.0, 0.0, 0.0]}
duration: 60.0
"""


def test_a_run_to_which_nobody_says_anything_is_the_same_with_ros(ros_master: ros.Master, tmp_path: Path) -> None:
    world = tmp_path / "short_way.yaml"
    world.write_text(WORLD)
    options = RunOptions(perception="truth", video=False, without=layers_meant(("social",)))
    with ros.ros_client(ros_master) as client:
        client.subscribe(COSTMAP, "nav_msgs/OccupancyGrid")
        client.subscribe("/people", "people_msgs/People")
        command = run_command(tmp_path / "ros", "--ros", "--without", "social", world=str(world))
        with subprocess.Popen(command, stdout=subprocess.DEVNULL) as beside:
            run_world(world, options, tmp_path / "alone")
        assert beside.returncode == 0
        assert client.collected("/people")
    for name in ("trace.csv", "tracks.csv", "poses.csv"):
        assert (tmp_path / "alone" / name).read_bytes() == (tmp_path / "ros" / name).read_bytes(), name
    results = [json.loads((tmp_path / name / "result.json").read_text()) for name in ("alone", "ros")]
    for result in results:
        del result["timings"]
    assert results[0] == results[1] and results[0]["outcome"] == "arrived"


def test_without_a_master_a_run_ends_with_one_sentence(
    ros_master: ros.Master, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ros_master.stop()
    _, _, _, *arguments = run_command(tmp_path, "--ros")
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert said.startswith("han-bullet: no ROS master answers at http://127.0.0.1:")
    assert len(said.splitlines()) == 1
    assert not (tmp_path / "result.json").exists()
