"""Orders to a running robot, in whole episodes with perfect perception: where it goes and stands, what it says."""

import json
import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from orders import Script, episode
from ticks import make_world, tick

from han_bullet.checks import check_goal
from han_bullet.cli import main
from han_bullet.costmap.grid import INSCRIBED, LETHAL
from han_bullet.device_payload import write_payload
from han_bullet.episode import Operator
from han_bullet.errors import BadInputError
from han_bullet.explain.recorded_run import read_run
from han_bullet.explain.replay import replay
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.messages import DeviceMessage, GoTo, HandOver, Order, RecoveryStep, Status
from han_bullet.metrics import Metrics
from han_bullet.report.run_page import write_run_page
from han_bullet.runner import RunOptions, run_world
from han_bullet.stack import Decision, NavigationStack
from han_bullet.world_schema import CONTROL_PERIOD

OPTIONS = RunOptions(perception="truth", video=False)
BACK = GoTo(Pose2D(2.0, 0.5, math.pi))
WALLS = [{"start": [0.0, y], "end": [20.0, y], "thickness": 0.2} for y in (-2.1, 2.1)]
BARRIER = {"start": [5.0, -2.0], "end": [5.0, 2.0], "thickness": 0.2}
SHORT_STEPS = {"wait": 1.0, "clear": 0.0, "ask": 1.0}


def place(decision: Decision) -> Pose2D:
    return decision.estimate.pose_robot_in_world


def to(task: GoTo | HandOver) -> Callable[[NavigationStack], object]:
    return lambda stack: stack.take(task)


def driven(start: float, end: float, command: Twist2D) -> list[tuple[float, Callable[[NavigationStack], object]]]:
    """Somebody drives from one time to another [s], at 10 Hz."""
    return [(time, lambda stack: stack.override(command)) for time in np.arange(start, end - 1e-9, 0.1)]


def test_a_new_goal_midway_is_reached_and_the_old_one_is_not() -> None:
    operator = Script(10.0, (3.0, to(BACK)))
    end = episode(make_world(), operator).pose_robot_in_world
    assert max(place(decision).x for decision in operator.decisions) < 5.0
    assert end.distance_to((2.0, 0.5)) < 0.15
    assert operator.decisions[-1].status is Status.ARRIVED


def test_a_new_goal_is_planned_for_at_once() -> None:
    operator = Script(3.0, (2.05, to(BACK)))
    episode(make_world(), operator)
    before, after = operator.at(2.05), operator.at(2.1)
    assert before.path is not None and before.path.points_in_world[-1, 0] == pytest.approx(18.0, abs=0.1)
    assert after.path is not None and after.path.points_in_world[-1, 0] == pytest.approx(2.0, abs=0.1)
    assert after.scene.task == BACK
    assert (before.orders, after.orders) == ((), (Order("go_to", BACK),))


def test_a_new_goal_beside_the_old_one_is_planned_for_at_once_too() -> None:
    operator = Script(2.2, (2.05, to(GoTo(Pose2D(18.0, 0.3, 0.0)))))
    episode(make_world(), operator)
    searched = [operator.at(time).path for time in (2.0, 2.05, 2.1, 2.15)]
    assert [path is not None and path.expanded > 0 for path in searched] == [True, False, True, False]


def test_another_yaw_at_the_same_place_is_turned_to() -> None:
    world = make_world(task={"kind": "go_to", "pose": [3.0, 0.0, 0.0]})
    operator = Script(10.0, (6.0, to(GoTo(Pose2D(3.0, 0.0, 1.5)))))
    end = episode(world, operator).pose_robot_in_world
    assert operator.at(6.0).status is Status.ARRIVED and operator.at(6.05).status is Status.MOVING
    assert end.yaw == pytest.approx(1.5, abs=0.2) and operator.decisions[-1].status is Status.ARRIVED


def test_a_cancelled_robot_that_somebody_drives_brakes_at_once() -> None:
    operator = Script(4.0, *driven(0.0, 3.0, Twist2D(0.8, 0.0, 0.0)), (3.0, lambda stack: stack.cancel()))
    episode(make_world(), operator)
    assert operator.at(3.0).command.speed == pytest.approx(0.8)
    assert operator.at(3.05).command.speed == pytest.approx(0.75)
    assert (operator.at(3.05).status, operator.at(4.0).command.speed) == (Status.IDLE, 0.0)


def test_a_cancelled_robot_stops_within_its_braking_distance_and_stays_there() -> None:
    world = make_world()
    operator = Script(12.0, (3.0, lambda stack: stack.cancel()))
    end = episode(world, operator)
    then, speed = place(operator.at(3.0)), operator.at(3.0).command.speed
    assert speed == pytest.approx(1.0, abs=0.05)
    braking = speed**2 / (2.0 * world.robot.max_acceleration) + 2.0 * speed * CONTROL_PERIOD
    stood = place(operator.at(4.5))
    assert 0.3 < stood.x - then.x < braking
    assert end.pose_robot_in_world.distance_to(stood.position) < 0.01
    assert end.twist_robot_in_body.speed < 0.01
    assert {decision.status for decision in operator.decisions if decision.time > 3.0} == {Status.IDLE}
    assert operator.decisions[-1].path is None and operator.decisions[-1].scene.task is None


def test_a_robot_that_is_driven_towards_a_person_when_it_is_cancelled_does_not_touch_them() -> None:
    world = make_world("somebody", people=[{"name": "s", "start": [5.0, 0.0, 0.0], "behaviour": {"kind": "stand"}}])
    operator = Script(8.0, *driven(0.0, 6.0, Twist2D(1.0, 0.0, 0.0)), (6.0, lambda stack: stack.cancel()))
    end = episode(world, operator)
    assert 3.5 < end.pose_robot_in_world.x < 5.0 - world.robot.radius - 0.25


def test_after_arrival_it_stands_there_and_takes_a_second_goal() -> None:
    world = make_world(task={"kind": "go_to", "pose": [3.0, 0.0, 0.0]})
    operator = Script(14.0, (8.0, to(BACK)))
    end = episode(world, operator).pose_robot_in_world
    waiting = [decision for decision in operator.decisions if 6.0 < decision.time <= 8.0]
    assert {decision.status for decision in waiting} == {Status.ARRIVED}
    assert all(place(decision).distance_to((3.0, 0.0)) < 0.15 for decision in waiting)
    assert operator.at(8.05).status is Status.MOVING
    assert end.distance_to((2.0, 0.5)) < 0.15 and operator.decisions[-1].status is Status.ARRIVED


def test_after_a_hand_over_it_does_not_follow_the_person_who_leaves() -> None:
    leaves = {"kind": "walk", "waypoints": [[15.0, 0.0]], "speed": 1.0, "starts": {"when": "time", "delay": 9.0}}
    world = make_world(
        people=[{"name": "taker", "start": [5.0, 0.0, 3.1416], "behaviour": leaves}],
        task={"kind": "hand_over", "place": [5.0, 0.0]},
    )
    operator = Script(14.0)
    end = episode(world, operator)
    assert operator.at(9.0).status is Status.ARRIVED
    assert end.people[0].pose_in_world.x > 8.0
    assert end.pose_robot_in_world.distance_to(place(operator.at(9.0)).position) < 0.01


def test_after_giving_up_it_stands_still_and_takes_an_order() -> None:
    world = make_world(walls=[*WALLS, BARRIER], recovery=SHORT_STEPS)
    operator = Script(14.0, (6.0, to(BACK)))
    end = episode(world, operator).pose_robot_in_world
    gave_up = operator.at(6.0)
    assert (gave_up.status, gave_up.step) == (Status.BLOCKED, RecoveryStep.GIVE_UP)
    assert gave_up.gave_up == "no free way to the goal for 2 s; waited, asked people to make way"
    assert operator.at(3.0).gave_up == gave_up.gave_up  # said once and for all
    assert place(gave_up).distance_to((1.0, 0.0)) < 0.05
    after = operator.at(6.05)
    assert (after.status, after.step, after.gave_up) == (Status.MOVING, None, None)
    assert end.distance_to((2.0, 0.5)) < 0.15


def test_a_robot_that_gave_up_does_not_go_on_by_itself_when_the_way_is_free_again() -> None:
    box = {"name": "box", "position": [5.0, 0.0], "size": [0.4, 4.0, 0.5], "until": {"when": "time", "delay": 6.0}}
    world = make_world(walls=WALLS, furniture=[box | {"known": False}], recovery=SHORT_STEPS)
    operator = Script(16.0)
    end = episode(world, operator)
    stood = next(decision for decision in operator.decisions if decision.gave_up)
    assert end.taken_away == ("box",) and stood.time < 16.0 - 2.0
    assert end.pose_robot_in_world.distance_to(place(stood).position) < 0.01


def test_a_hand_over_by_id_goes_to_that_person_wherever_they_are() -> None:
    def standing(name: str, x: float, y: float) -> dict[str, object]:
        return {"name": name, "start": [x, y, 0.0], "behaviour": {"kind": "stand", "turns_to_robot": True}}

    world = make_world(people=[standing("a", 5.0, 1.2), standing("b", 8.0, -1.0), standing("c", 5.5, -1.0)])
    operator = Script(20.0, (1.0, to(HandOver(np.zeros(2), person=1))))
    end = episode(world, operator)
    task = operator.decisions[-1].scene.task
    assert isinstance(task, HandOver) and task.person == 1
    ordered = operator.at(1.05).orders[0].task
    assert isinstance(ordered, HandOver) and ordered.place_in_world == pytest.approx([8.0, -1.0], abs=0.01)
    assert operator.decisions[-1].status is Status.ARRIVED
    assert end.pose_robot_in_world.distance_to((8.0, -1.0)) == pytest.approx(0.9, abs=0.2)


def test_a_hand_over_to_nobody_who_is_tracked_is_refused_and_nothing_changes() -> None:
    def refused(stack: NavigationStack) -> None:
        with pytest.raises(BadInputError, match="person 7 of the hand-over is not tracked; one of 0 would be right"):
            stack.take(HandOver(np.zeros(2), person=7))

    operator = Script(2.0, (1.0, refused))
    episode(make_world("anna"), operator)
    assert operator.at(1.05).scene.task == operator.at(0.95).scene.task
    assert all(decision.orders == () for decision in operator.decisions)


ROOM = make_world(
    walls=WALLS,
    furniture=[
        {"name": "table", "position": [10.0, 0.0], "size": [1.0, 1.0, 0.7]},
        {"name": "crate", "position": [14.0, 0.0], "size": [1.0, 1.0, 0.7], "known": False},
    ],
)


@pytest.mark.parametrize(
    ("task", "why"),
    [
        (GoTo(Pose2D(math.nan, 0.0, 0.0)), r"goal: pose is \[nan, 0.0, 0.0\]; finite numbers"),
        (GoTo(Pose2D(3.0, 0.0, math.inf)), r"goal: pose is \[3.0, 0.0, inf\]; finite numbers"),
        (GoTo(Pose2D(3.0, 30.0, 0.0)), r"goal: pose: \[3.0, 30.0\] lies on no floor area"),
        (GoTo(Pose2D(10.2, 0.0, 0.0)), "goal: pose: .*lies inside object 'table'"),
        (GoTo(Pose2D(3.0, 1.8, 0.0)), "goal: pose: .*wall 'wall1' or nearer to it than the body's radius 0.3 m"),
        (GoTo(Pose2D(0.1, 0.0, 0.0)), "goal: pose: .*too near to a wall, to furniture or to the floor's end"),
        (HandOver(np.array([10.2, 0.0])), "goal: place: .*lies inside object 'table'"),
        (HandOver(np.array([3.0, math.nan])), "goal: place is .*finite numbers"),
        (HandOver(np.array([3.0, 0.0]), distance=-0.5), "goal: distance is -0.5 m; a positive one"),
    ],
)
def test_a_goal_where_nobody_can_stand_is_refused_with_the_reason(task: GoTo | HandOver, why: str) -> None:
    with pytest.raises(BadInputError, match=why):
        check_goal(ROOM, task)


def test_a_goal_is_held_against_what_the_robot_knows_so_a_crate_off_the_map_refuses_none() -> None:
    check_goal(ROOM, GoTo(Pose2D(14.0, 0.0, 0.0)))
    check_goal(ROOM, GoTo(Pose2D(3.0, 1.6, 0.0)))
    check_goal(ROOM, HandOver(np.array([math.nan, 0.0]), person=3))  # to where they are


def test_who_drives_overrides_the_task_and_when_they_let_go_it_goes_on() -> None:
    operator = Script(12.0, *driven(2.0, 4.0, Twist2D(0.0, 0.5, 0.0)))
    world = make_world(floor=[{"x": [0.0, 20.0], "y": [-4.0, 4.0]}], task={"kind": "go_to", "pose": [6.0, 0.0, 0.0]})
    end = episode(world, operator).pose_robot_in_world
    driving = [decision for decision in operator.decisions if decision.status is Status.TELEOPERATED]
    assert (driving[0].time, driving[-1].time) == pytest.approx((2.05, 3.9 + CONTROL_PERIOD + 0.5))
    assert place(driving[-1]).y > 0.8
    assert [d.time for d in operator.decisions if d.orders == (Order("drive"),)] == pytest.approx([2.05])
    assert end.distance_to((6.0, 0.0)) < 0.15


def test_commands_of_who_drives_keep_the_limits_of_the_base() -> None:
    operator = Script(4.0, *driven(0.5, 2.5, Twist2D(5.0, 5.0, 0.0)), *driven(2.5, 4.0, Twist2D(0.0, 0.0, 20.0)))
    world = make_world(floor=[{"x": [0.0, 20.0], "y": [-9.0, 9.0]}])
    episode(world, operator)
    commands = [decision.command for decision in operator.decisions]
    velocities = [d.command.linear_in_world(place(d).yaw) for d in operator.decisions]
    turned = CONTROL_PERIOD * world.robot.max_yaw_rate * world.robot.max_speed  # by the turn within a period
    largest = world.robot.max_acceleration * CONTROL_PERIOD + turned
    assert max(command.speed for command in commands) == pytest.approx(world.robot.max_speed, abs=0.01)
    assert max(command.omega for command in commands) == pytest.approx(world.robot.max_yaw_rate)
    assert all(math.dist(a, b) <= largest for a, b in pairwise(velocities))


def test_who_drives_into_a_wall_is_stopped_before_it() -> None:
    operator = Script(8.0, *driven(0.0, 8.0, Twist2D(0.0, 1.0, 0.0)))
    world = make_world(walls=WALLS)
    end = episode(world, operator)
    gap = 2.0 - world.robot.radius - end.pose_robot_in_world.y
    assert 0.0 < gap < 0.2
    assert not end.contacts
    assert Status.PROTECTIVE_STOP in {decision.status for decision in operator.decisions}


def test_who_is_driven_against_a_wall_for_long_does_not_give_up() -> None:
    world = make_world(walls=WALLS, recovery=SHORT_STEPS)
    operator = Script(10.0, *driven(0.0, 8.0, Twist2D(0.0, 1.0, 0.0)))
    episode(world, operator)
    assert all(decision.gave_up is None for decision in operator.decisions)
    assert operator.decisions[-1].status is Status.MOVING


def test_a_robot_that_is_driven_away_from_its_goal_stands_where_it_was_driven_to() -> None:
    world = make_world(task={"kind": "go_to", "pose": [3.0, 0.0, 0.0]})
    operator = Script(12.0, *driven(7.0, 9.0, Twist2D(0.5, 0.0, 0.0)))
    end = episode(world, operator).pose_robot_in_world
    assert operator.at(7.0).status is Status.ARRIVED
    assert end.x > 3.8
    assert operator.decisions[-1].status is Status.IDLE


@pytest.mark.parametrize("command", [Twist2D(math.nan, 0.0, 0.0), Twist2D(0.0, 0.0, math.inf)])
def test_a_command_that_is_no_number_is_refused_and_the_robot_goes_on(command: Twist2D) -> None:
    def refused(stack: NavigationStack) -> None:
        with pytest.raises(BadInputError, match=r"command to drive is .*finite"):
            stack.override(command)

    operator = Script(1.0, (0.5, refused))
    episode(make_world(), operator)
    assert {decision.status for decision in operator.decisions} == {Status.MOVING}


def test_a_way_between_two_points_is_planned_on_the_present_costmap_and_the_robots_own_stays() -> None:
    found = []
    operator = Script(
        3.0,
        (1.0, lambda stack: found.append(stack.plan_between(np.array([2.0, -1.0]), np.array([8.0, 1.0])))),
        (1.5, lambda stack: found.append(stack.plan_between(np.array([2.0, -1.0]), np.array([10.0, 0.0])))),
    )
    episode(ROOM, operator)
    undisturbed = Script(3.0)
    episode(ROOM, undisturbed)
    assert found[0] is not None and found[1] is None  # the second ends inside the table
    assert np.abs(found[0].points_in_world[[0, -1]] - [[2.0, -1.0], [8.0, 1.0]]).max() <= 0.05
    ways = [[(d.path.cost, d.path.expanded) for d in o.decisions if d.path] for o in (operator, undisturbed)]
    assert ways[0] == ways[1] and len(ways[0]) == 61


def test_obstacles_that_are_cleared_are_forgotten_until_they_are_seen_again() -> None:
    crate = {"name": "crate", "position": [14.0, 0.0], "size": [1.0, 1.0, 0.7], "known": False}
    world = make_world(
        furniture=[crate],
        robot={"start": [11.0, 0.0, 0.0]},
        task={"kind": "go_to", "pose": [11.5, 0.0, 0.0]},
    )
    operator = Script(4.0, (3.0, lambda stack: stack.clear_obstacles()))
    episode(world, operator)
    face = np.array([13.525, 0.0])
    costs = [int(operator.at(time).costmap.cost_at(face)) for time in (3.0, 3.05, 4.0)]
    assert costs[0] == costs[2] == LETHAL and costs[1] < INSCRIBED
    assert operator.at(3.05).orders == (Order("clear_obstacles"),)


def brief(world: str, folder: Path, **changes: object) -> Path:
    """A shipped world with changes."""
    path = folder / f"{world}_brief.yaml"
    path.write_text(yaml.safe_dump({"extends": world, **changes}))
    return path


def files_of(folder: Path) -> dict[str, bytes]:
    """What a run left, without its timings."""
    files = {path.name: path.read_bytes() for path in folder.iterdir()}
    result = json.loads(files["result.json"])
    del result["timings"]
    return files | {"result.json": json.dumps(result).encode()}


class Silent(Operator):
    """Says nothing."""

    def attend(self, decision: Decision) -> None:
        pass


@pytest.mark.scenario
def test_an_operator_who_says_nothing_changes_no_file_of_a_run(tmp_path: Path) -> None:
    world = brief("real2", tmp_path, duration=4.0)
    for name, operator in (("alone", None), ("watched", Silent())):
        run_world(world, OPTIONS, tmp_path / name, operator=operator)
    alone = files_of(tmp_path / "alone")
    assert alone == files_of(tmp_path / "watched") and len(alone) > 10
    result = json.loads(alone["result.json"])
    assert "orders" not in result and result["checks"]


@pytest.mark.scenario
def test_a_run_with_orders_lists_them_holds_no_expectation_against_it_and_can_be_explained(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    operator = Script(
        12.0,
        (2.0, to(BACK)),
        (6.0, to(HandOver(np.array([0.0, 0.0]), person=0))),
        (7.0, lambda stack: stack.cancel()),
        *driven(8.0, 9.0, Twist2D(0.3, 0.0, 0.0)),
        (9.5, lambda stack: stack.clear_obstacles()),
        (10.0, to(GoTo(Pose2D(9.0, 0.0, 0.0)))),
    )
    run = run_world("real4", OPTIONS, tmp_path, operator=operator)
    result = json.loads((tmp_path / "result.json").read_text())
    told = [(order["time"], order["order"]) for order in result["orders"]]
    names = ["go_to", "hand_over", "cancel", "drive", "clear_obstacles", "go_to"]
    assert told == list(zip([2.05, 6.05, 7.05, 8.05, 9.55, 10.05], names, strict=True))
    assert result["orders"][0]["pose"] == [2.0, 0.5, math.pi]
    assert (result["orders"][1]["person"], result["orders"][1]["distance"]) == (0, 0.9)
    assert result["orders"][1]["place"] == pytest.approx([10.5, 0.3], abs=0.2)
    assert run.checks == () and result["checks"] == [] and "given orders" in result["checks_detail"]
    metrics = {metric.name: metric.value for metric in run.metrics}
    assert metrics["outcome"] == "timeout"
    assert all(metrics[name] is None for name in ("success", "spl", "time_to_goal", "hand_over_distance"))
    for time, said in ((3.0, "best way: "), (7.5, "it has no task"), (8.5, "somebody drives it"), (11.0, "best way: ")):
        assert main(["explain", str(tmp_path), "--time", str(time)]) == 0
        assert said in capsys.readouterr().out, time
    page = write_run_page(tmp_path).read_text()
    assert "The robot ran out of time; it was given orders, so no expectation" in page
    assert "2.05 s: go to (2.00, 0.50); 6.05 s: hand over to track 0 at (10.5" in page
    for time, end in ((3.0, (2.0, 0.5)), (6.5, (9.6, 0.3)), (11.0, (9.0, 0.0))):
        path = replay(read_run(tmp_path), time).tick.decision.path
        assert path is not None and path.points_in_world[-1] == pytest.approx(end, abs=0.2), time


@pytest.mark.scenario
def test_a_device_of_which_an_operator_tells_is_known_to_the_robot_at_the_next_tick(tmp_path: Path) -> None:
    payload = write_payload(DeviceMessage("tv", 1.0, True, "house"))
    operator = Script(3.0)
    operator.add(1.0, lambda _: operator.channel.publish("tv", payload))
    run_world("real3_off", OPTIONS, tmp_path, operator=operator)
    known = [operator.at(time).scene.devices[0].on for time in (1.0, 1.05, 3.0)]
    assert known == [False, True, True]
    assert "1.050000,tv,1.000000,1,house" in (tmp_path / "messages.csv").read_text().splitlines()


def test_the_metrics_of_the_worlds_task_have_no_value_once_an_order_was_given() -> None:
    world = make_world(task={"kind": "go_to", "pose": [1.0, 0.0, 0.0]})
    for orders, outcome, success in (((), "arrived", True), ((Order("cancel"),), "timeout", None)):
        metrics = Metrics(world)
        metrics.record(tick(0, robot=(1.0, 0.0, 0.0), status=Status.ARRIVED))
        one = tick(1, robot=(1.0, 0.0, 0.0), status=Status.IDLE)
        metrics.record(replace(one, decision=replace(one.decision, orders=orders)))
        values = {metric.name: metric.value for metric in metrics.results()}
        assert (values["outcome"], values["success"]) == (outcome, success)
        assert values["path_length"] == 0.0


@pytest.mark.scenario
def test_the_documentations_operator_sends_the_robot_there_and_back(tmp_path: Path) -> None:
    text = (Path(__file__).parent.parent / "docs/index.md").read_text()
    names: dict[str, Any] = {"__name__": "documentation"}
    exec(text.split("## Orders to a running robot")[1].split("```python\n")[1].split("```")[0], names)
    world = brief("real2", tmp_path, people=[], task={"kind": "go_to", "pose": [5.0, 0.0, 0.0]}, expectations=[])
    run_world(world, OPTIONS, tmp_path / "run", operator=names["ThereAndBack"]())
    result = json.loads((tmp_path / "run/result.json").read_text())
    assert result["outcome"] == "arrived" and [order["order"] for order in result["orders"]] == ["go_to"]
    trace = np.loadtxt(tmp_path / "run/trace.csv", delimiter=",", skiprows=1, usecols=(1, 2))
    assert trace[:, 0].max() == pytest.approx(5.0, abs=0.2)
    assert trace[-1] == pytest.approx([2.0, 0.0], abs=0.2)


def test_an_order_at_the_last_moment_is_known_to_a_last_decision() -> None:
    operator = Script(1.0, (1.0, lambda stack: stack.cancel()))
    episode(make_world(), operator)
    assert operator.decisions[-1].time == pytest.approx(1.05)
    assert operator.decisions[-1].orders == (Order("cancel"),)
