"""What the map does not have and whom nobody tracks: whole episodes with the laser, and what makes them fail."""

from pathlib import Path

import numpy as np
import pytest

from han_bullet.ablation import TruthTracker
from han_bullet.control.protective_stop import ProtectiveStop
from han_bullet.costmap.grid import LETHAL
from han_bullet.episode import Hook, Tick
from han_bullet.messages import Status
from han_bullet.runner import RunOptions, RunResult, run_world

CLEARED_WITHIN = 1.0  # [s]


def run(
    world: str, seed: int, folder: Path, *hooks: Hook, without: tuple[str, ...] = ()
) -> tuple[RunResult, dict[str, object]]:
    options = RunOptions(seed=seed, perception="truth", video=False, without=without)
    result = run_world(world, options, folder, hooks=hooks)
    return result, {metric.name: metric.value for metric in result.metrics}


def failed(result: RunResult) -> set[str]:
    assert result.checks
    return {check.metric for check in result.checks if not check.passed}


class Second(Hook):
    """When the second crate of the world `box` was marked, taken away, and gone from the map [s]."""

    def __init__(self) -> None:
        self.marked = self.taken = self.cleared = np.inf
        self.statuses: set[Status] = set()

    def record(self, tick: Tick) -> None:
        time, costmap = tick.truth.time, tick.decision.costmap
        window = costmap.window((10.0, 11.0), (-0.6, 0.6))
        there = bool((costmap.building[window] >= LETHAL).any())
        self.statuses.add(tick.decision.status)
        if there and not tick.truth.taken_away:
            self.marked = min(self.marked, time)
        if tick.truth.taken_away:
            self.taken = min(self.taken, time)
        if not there and np.isfinite(self.taken):
            self.cleared = min(self.cleared, time)


@pytest.mark.scenario
@pytest.mark.parametrize("seed", range(3))
def test_boxes_that_the_map_does_not_have_are_avoided_and_forgotten_when_they_are_gone(
    seed: int, tmp_path: Path
) -> None:
    second = Second()
    result, _ = run("box", seed, tmp_path, second)
    assert failed(result) == set()
    assert second.marked < second.taken
    assert second.cleared - second.taken <= CLEARED_WITHIN
    assert Status.PROTECTIVE_STOP not in second.statuses  # the layer alone leads round them


@pytest.mark.scenario
def test_without_the_obstacle_layer_the_protective_stop_still_keeps_the_robot_off_a_box(tmp_path: Path) -> None:
    _, metrics = run("box", 0, tmp_path, without=("obstacle",))
    assert metrics["outcome"] == "blocked"
    assert metrics["contacts_object"] == 0


@pytest.mark.scenario
def test_with_neither_the_robot_hits_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ProtectiveStop, "limit", lambda self, command, *_: (command, False))
    _, metrics = run("box", 0, tmp_path, without=("obstacle",))
    assert isinstance(metrics["contacts_object"], int) and metrics["contacts_object"] > 0


@pytest.mark.scenario
@pytest.mark.parametrize("tracked", [True, False])
@pytest.mark.parametrize("seed", [1, 2])
def test_the_robot_runs_into_nobody_who_jumps_in_whether_or_not_people_are_tracked(
    seed: int, tracked: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not tracked:
        monkeypatch.setattr(TruthTracker, "update", lambda *_: ())
    result, metrics = run("jump_in", seed, tmp_path)
    assert failed(result) == set()
    assert metrics["outcome"] == "arrived"


@pytest.mark.scenario
@pytest.mark.parametrize("seed", [1, 2])
def test_without_tracks_and_protective_stop_it_runs_into_who_jumps_in(
    seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(TruthTracker, "update", lambda *_: ())
    monkeypatch.setattr(ProtectiveStop, "limit", lambda self, command, *_: (command, False))
    result, _ = run("jump_in", seed, tmp_path)
    assert "contacts_person" in failed(result)
