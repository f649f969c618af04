"""The benchmark of trackers: ours on a short recording, who is too slow, and what it says without Stone Soup."""

import sys

import numpy as np
import pytest

import benchmarks
from benchmarks.crowd import Recording, record
from benchmarks.tracker import COLUMNS, Step, compare, main, ours, rows
from han_bullet.assembly import ASSOCIATIONS
from han_bullet.tracking.kalman import ConstantVelocity


def test_two_people_for_three_seconds_give_a_line_for_each_association() -> None:
    recordings = [record(2, 12.0, 3.0, seed) for seed in (0, 1)]
    outcomes = compare({name: ours(name, ConstantVelocity()) for name in ASSOCIATIONS}, recordings, limit=60.0)
    assert [len(outcome.times) for outcome in outcomes.values()] == [60, 60, 60]
    lines = rows(2, 12.0, outcomes, limit=60.0)
    assert [line[:3] for line in lines] == [(2, "12 x 12", name) for name in ("nnjpda", "nn", "gnn")]
    for line in lines:
        assert len(line) == len(COLUMNS)
        assert 0.01 < float(str(line[3])) < 0.35  # the mean, with the first scans, in which nobody is known yet
        assert 0.01 < float(str(line[4])) < 0.15
        assert line[5] == 0


def perfect(recording: Recording) -> Step:
    return lambda k: dict(enumerate(recording.positions[k]))


def endless(recording: Recording) -> Step:
    def step(k: int) -> dict[int, np.ndarray]:
        while k == 2:
            pass
        return {}

    return step


def test_a_tracker_with_one_scan_over_the_limit_has_no_figures_and_stops_nobody_else() -> None:
    recordings = [record(2, 5.0, 1.0, seed) for seed in (0, 1)]
    outcomes = compare({"endless": endless, "perfect": perfect}, recordings, limit=0.5)
    assert outcomes["endless"].too_slow and len(outcomes["endless"].times) == 2
    slow, quick = rows(2, 5.0, outcomes, limit=0.5)
    assert slow[2:] == ("endless", "-", "-", "-", "too slow (> 0.5 s per scan)", "-")
    assert quick[2:6] == ("perfect", "0.000", "0.000", 0)
    assert len(outcomes["perfect"].times) == 20


def test_all_trackers_see_the_scans_in_turn() -> None:
    seen: list[tuple[str, int]] = []

    def witness(name: str) -> Step:
        return lambda k: seen.append((name, k)) or {}

    compare({name: lambda _, n=name: witness(n) for name in "ab"}, [record(1, 5.0, 0.2, 0)], limit=60.0)
    assert seen == [("a", 0), ("b", 0), ("a", 1), ("b", 1)]


def test_without_stone_soup_it_says_in_one_sentence_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in [name for name in sys.modules if name.startswith("stonesoup.") or name == "benchmarks.stone_soup"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.delattr(benchmarks, "stone_soup", raising=False)
    monkeypatch.setitem(sys.modules, "stonesoup", None)
    monkeypatch.setattr(sys, "argv", ["tracker"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1 and "pip install '.[bench]'" in printed.err
