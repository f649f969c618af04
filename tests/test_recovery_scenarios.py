"""Whole episodes of robots that cannot go on: people who make way or do not, a box, a robot that is carried away."""

import csv
import json
from pathlib import Path
from typing import Any

import pybullet
import pytest
import yaml

from han_bullet.ablation import NoDetector, TruthTracker
from han_bullet.assembly import build_localization, build_stack
from han_bullet.cli import main
from han_bullet.episode import Hook, Tick, run_episode
from han_bullet.geometry import Pose2D
from han_bullet.messages import RecoveryStep, Status
from han_bullet.report.run_page import write_run_page
from han_bullet.runner import RunOptions, run_world
from han_bullet.sim.simulator import Simulator
from han_bullet.stack import Decision
from han_bullet.variation import vary
from han_bullet.world_file import load_world

OPTIONS = RunOptions(perception="truth", video=False)
FAST = {"wait": 3.0, "clear": 2.0, "ask": 4.0}  # the steps in a third of the time
NOTHING_HELPED = "no free way to the goal for 9 s; waited, cleared the obstacle layer, asked people to make way"


def world(folder: Path, **changes: Any) -> Path:
    """The world of the person in the doorway, without expectations, with changes."""
    path = folder / "mine.yaml"
    path.write_text(yaml.safe_dump({"extends": "make_way", "recovery": FAST, "expectations": [], **changes}))
    return path


def steps(folder: Path) -> list[str]:
    """The recovery's steps of a run, each as it began."""
    with (folder / "status.csv").open() as file:
        rows = [row["step"] for row in csv.DictReader(file)]
    return [step for i, step in enumerate(rows) if i == 0 or step != rows[i - 1]]


@pytest.mark.scenario
@pytest.mark.parametrize("seed", [0, 1])
def test_a_person_in_the_doorway_makes_way_when_asked_and_the_robot_arrives(seed: int, tmp_path: Path) -> None:
    result = run_world("make_way", RunOptions(seed=seed, perception="truth", video=False), tmp_path)
    assert result.checks and all(check.passed for check in result.checks)
    assert steps(tmp_path) == ["wait", "clear", "ask", ""]
    assert json.loads((tmp_path / "result.json").read_text())["outcome_detail"] is None


@pytest.mark.scenario
def test_before_a_person_who_does_not_make_way_it_gives_up_and_everything_says_why(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = world(tmp_path, people=[{"name": "deaf", "start": [15.9, 0.0, 0.0]}])
    folder = tmp_path / "run"
    assert main(["run", str(path), "--perception", "truth", "--no-video", "--out", str(folder)]) == 0
    assert f"gave up: {NOTHING_HELPED}\n" in capsys.readouterr().out
    result = json.loads((folder / "result.json").read_text())
    assert (result["outcome"], result["outcome_detail"]) == ("blocked", NOTHING_HELPED)
    assert steps(folder) == ["wait", "clear", "ask", "give_up"]
    assert main(["explain", str(folder), "--time", "6.0"]) == 0
    assert "it cannot go on: since 5.00 s it asks people to make way" in capsys.readouterr().out
    page = write_run_page(folder).read_text()
    assert f"The robot found no free way; the world states no expectations. It gave up: {NOTHING_HELPED}." in page
    assert "5.00 s: asks people to make way; 9.00 s: gives up." in page


@pytest.mark.scenario
def test_a_box_in_the_doorway_is_carried_away_when_the_robot_asks(tmp_path: Path) -> None:
    box = {"name": "box", "position": [15.95, 0.0], "size": [0.4, 1.0, 0.5], "known": False}
    for when, outcome in (({"when": "time", "delay": 100.0}, "blocked"), ({"when": "robot_asks"}, "arrived")):
        path = world(tmp_path, people=[], sitting_areas=[], furniture=[box | {"until": when}])
        run_world(path, OPTIONS, tmp_path / outcome)
        result = json.loads((tmp_path / outcome / "result.json").read_text())
        assert result["outcome"] == outcome, result["outcome_detail"]
        assert "ask" in steps(tmp_path / outcome)


@pytest.mark.scenario
@pytest.mark.parametrize("name", ["two_abreast", "crossing", "doorway", "real1"])
def test_among_people_who_let_it_pass_it_does_not_recover(name: str, tmp_path: Path) -> None:
    run_world(name, OPTIONS, tmp_path)
    assert set(steps(tmp_path)) <= {"", "wait"}


class Carrying(Hook):
    """Carries the robot away while its wheels stand still, and takes note of what it did."""

    def __init__(self, simulator: Simulator, time: float, to: Pose2D) -> None:
        self._simulator, self._time, self._to = simulator, time, to
        self.steps: list[RecoveryStep | None] = []

    def record(self, tick: Tick) -> None:
        self.steps.append(tick.decision.step)
        if abs(tick.truth.time - self._time) < 1e-6:
            client, body = self._simulator._client, self._simulator._robot.body
            (_, _, z), _ = pybullet.getBasePositionAndOrientation(body, physicsClientId=client)
            turned = pybullet.getQuaternionFromEuler([0.0, 0.0, self._to.yaw])
            pybullet.resetBasePositionAndOrientation(body, [self._to.x, self._to.y, z], turned, physicsClientId=client)
            self._simulator._odometry._true_pose = self._to


def carried_away(to: Pose2D) -> tuple[Decision, Pose2D, list[RecoveryStep | None]]:
    """Run the empty corridor, the robot carried to a pose after 4 s; return how it ends, where, and the steps."""
    empty = vary(load_world("sim1"), 0).model_copy(update={"people": ()})
    with Simulator(empty, renderer=None) as simulator:
        stack = build_stack(
            empty,
            localization=build_localization(empty, empty.robot.start_pose_in_world, 0),
            detector=NoDetector(),
            tracker=TruthTracker(lambda: simulator.truth, {}),
        )
        hook = Carrying(simulator, 4.0, to)
        end = run_episode(simulator, stack, duration=40.0, hooks=[hook])
        return end, simulator.truth.pose_robot_in_world, hook.steps


@pytest.mark.scenario
def test_a_robot_that_is_carried_to_another_room_finds_itself_and_arrives() -> None:
    end, pose, steps = carried_away(Pose2D(17.5, 2.0, 2.0))
    assert RecoveryStep.RELOCALIZE in steps
    assert (end.status, end.gave_up) == (Status.ARRIVED, None)
    assert pose.distance_to([14.5, 0.0]) < 0.2


@pytest.mark.scenario
def test_a_robot_that_is_carried_to_where_the_map_looks_alike_says_that_it_is_lost() -> None:
    end, pose, steps = carried_away(Pose2D(14.0, 0.5, 3.0))
    assert (end.status, steps[-1]) == (Status.LOST, RecoveryStep.GIVE_UP)
    assert end.gave_up == "lost for 11 s; waited, looked for itself on the whole map"
    assert pose.distance_to([14.0, 0.5]) < 0.6  # it stood still, but for braking
