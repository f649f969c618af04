"""Whole sweeps: the same runs as `run` makes, rows that say what came of them, and going on after every kind of end."""

import contextlib
import functools
import json
import os
import runpy
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import psutil
import pytest
import yaml

from han_bullet.cli import main
from han_bullet.errors import BadInputError, WorkerDiedError
from han_bullet.provenance import git_commit, sha256
from han_bullet.runner import RunOptions, run_world
from han_bullet.sweep import running
from han_bullet.sweep.plan import PlannedRun, plan_sweep
from han_bullet.sweep.running import Onlooker, run_sweep
from han_bullet.sweep.task import Outcome, carry_out
from han_bullet.sweep.workers import local_workers
from han_bullet.sweep_rows import COLUMNS, read_row, read_rows
from han_bullet.world_file import find_world, world_files


def brief(folder: Path, duration: float = 0.5) -> Path:
    """A copy of real2 that ends soon: nobody arrives."""
    path = folder / "brief.yaml"
    path.write_text(yaml.safe_dump(yaml.safe_load(find_world("real2").read_text()) | {"duration": duration}))
    return path


class Counting(Onlooker):
    """Remembers what it is told."""

    def __init__(self) -> None:
        self.kept: list[dict[str, Any]] = []
        self.rows: list[dict[str, Any]] = []

    def started(self, runs: int, kept: Any) -> None:
        self.runs, self.kept = runs, list(kept)

    def ended(self, row: dict[str, Any]) -> None:
        self.rows.append(row)


class Listening(Onlooker):
    """Remembers the addresses at which this process and those below it can be reached while a sweep goes on."""

    def __init__(self) -> None:
        self.addresses: set[str] = set()

    def ended(self, row: dict[str, Any]) -> None:
        processes = [psutil.Process(), *psutil.Process().children(recursive=True)]
        sockets = [socket for process in processes for socket in process.net_connections("inet")]
        self.addresses = {socket.laddr.ip for socket in sockets if socket.status == psutil.CONN_LISTEN}


listening = Listening()


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[PlannedRun], list[dict[str, Any]]]:
    """The folder, plan and rows of a sweep of four short runs."""
    out = tmp_path_factory.mktemp("small")
    plan = plan_sweep([brief(out)], [0, 1], ["camera:camera1+nn", "truth+without:overtake"])
    return out, plan, run_sweep(plan, out, processes=1, onlooker=listening)


@pytest.mark.scenario
def test_a_run_of_a_sweep_is_the_run_that_the_same_options_give(small: Any, tmp_path: Path) -> None:
    out, plan, _ = small
    for run in plan[:2]:
        seeing = run.options.perception == "cameras"
        options = (
            RunOptions(cameras=("camera1",), association="nn", video=False)
            if seeing
            else RunOptions(perception="truth", without=("overtake",), video=False)
        )
        alone = run_world(out / "brief.yaml", options, tmp_path / run.variant).folder
        for name in ("trace.csv", "tracks.csv", "detections.csv"):
            assert (out / run.folder / name).read_bytes() == (alone / name).read_bytes(), name
        swept, single = (json.loads((folder / "result.json").read_text()) for folder in (out / run.folder, alone))
        assert swept.pop("timings").keys() == single.pop("timings").keys()
        assert swept == single


@pytest.mark.scenario
def test_a_row_says_what_was_run_and_what_came_of_it(small: Any) -> None:
    out, _, rows = small
    seen, told = rows[:2]
    assert list(seen)[: len(COLUMNS)] == COLUMNS.names
    assert (seen["world"], seen["variant"], seen["seed"]) == ("brief", "camera:camera1+nn", 0)
    assert (seen["perception"], seen["association"], seen["cameras"]) == ("cameras", "nn", "camera1")
    assert (told["perception"], told["association"], told["cameras"]) == ("truth", None, "")
    assert (seen["without"], told["without"], told["pass_side"]) == ("", "overtake", "left")
    assert seen["threshold"] is None and seen["error"] is None
    assert seen["outcome"] == seen["metric.outcome"] == "timeout" and not seen["passed"]
    assert seen["failed"].startswith("outcome = timeout, expected == arrived; goal_distance = None, expected <= 0.2;")
    assert "; overtaking_side.walker = none, expected == left" in seen["failed"]
    assert seen["simulated_s"] == 0.5
    assert seen["real_time_factor"] == pytest.approx(0.5 / seen["loop_s"], rel=0.01)
    assert seen["git_commit"] == git_commit() and seen["world_sha256"] == sha256(*world_files(out / "brief.yaml"))
    result = json.loads((out / seen["folder"] / "result.json").read_text())
    metrics = {f"metric.{metric['name']}": metric["value"] for metric in result["metrics"]}
    assert {name: seen[name] for name in metrics} == metrics
    assert all(type(value) in (float, str, type(None)) for name, value in seen.items() if name.startswith("metric."))


@pytest.mark.scenario
def test_all_rows_together_are_a_table(small: Any) -> None:
    out, plan, _ = small
    table = read_rows(out)
    assert table.num_rows == len(plan) == 4
    assert {"world", "metric.minimum_distance.walker"} <= set(table.column_names)


@pytest.mark.scenario
def test_only_this_machine_can_reach_its_processes(small: Any) -> None:
    assert listening.addresses == {"127.0.0.1"}


@pytest.mark.scenario
def test_started_again_a_sweep_runs_only_what_is_missing_failed_or_of_another_world_file(
    small: Any, tmp_path: Path
) -> None:
    first, plan, _ = small
    out = tmp_path / "again"
    shutil.copytree(first, out)
    (out / plan[2].row).unlink()
    (out / plan[3].row).write_bytes(b"")
    before = {run: (out / run.row).stat().st_mtime_ns for run in plan[:2]}
    onlooker = Counting()
    rows = run_sweep(plan, out, processes=1, onlooker=onlooker)
    assert onlooker.runs == 2 and [row["seed"] for row in onlooker.kept] == [0, 0]
    assert [(row["variant"], row["seed"]) for row in onlooker.rows] == [(run.variant, 1) for run in plan[2:]]
    assert {run: (out / run.row).stat().st_mtime_ns for run in plan[:2]} == before
    assert [row["seed"] for row in rows] == [0, 0, 1, 1] and all(row["error"] is None for row in rows)
    changed = plan_sweep([brief(tmp_path, duration=0.6)], [0, 1], ["truth+without:overtake"])
    assert [running.kept_row(run, out) for run in changed] == [None, None]


def with_accidents(marks: Path, world: Sequence[tuple[str, bytes]], options: RunOptions) -> Outcome:
    """Run, but kill this process: once for seed 1, always for seed 2; seed 3 is refused and seed 4 meets a fault."""
    (marks / f"{options.seed}.{time.time_ns()}").touch()
    starts = len(list(marks.glob(f"{options.seed}.*")))
    if options.seed == 2 or (options.seed == 1 and starts == 1):
        os.kill(os.getpid(), signal.SIGKILL)
    if options.seed == 3:
        return carry_out([(name, content.replace(b"walker", b"1")) for name, content in world], options)
    if options.seed == 4:
        raise ValueError("a fault\nof ours")
    return carry_out(world, options)


@pytest.mark.scenario
def test_a_run_outlives_a_killed_worker_and_a_sweep_outlives_any_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    marks = tmp_path / "marks"
    marks.mkdir()
    monkeypatch.setattr(running, "carry_out", functools.partial(with_accidents, marks))
    plan = plan_sweep([brief(tmp_path)], range(6), ["truth"])
    rows = run_sweep(plan, tmp_path, processes=2)
    starts = [len(list(marks.glob(f"{seed}.*"))) for seed in range(6)]
    assert starts[1] >= 2 and starts[2] == 4  # a result that lay with a worker that died is made again
    assert min(starts) == 1
    errors = [row["error"] for row in rows]
    assert [error is None for error in errors] == [True, True, False, False, False, True]
    assert errors[2] == "its worker process died each of 4 times"
    assert errors[3].startswith("brief.yaml: people[0].name: ")
    assert errors[4] == "ValueError: a fault of ours"
    assert [row["outcome"] for row in rows] == ["timeout", "timeout", None, None, None, "timeout"]
    assert all((tmp_path / row["folder"] / "result.json").exists() == (row["error"] is None) for row in rows)
    assert read_rows(tmp_path)["seed"].to_pylist() == list(range(6))
    assert [running.kept_row(run, tmp_path) is None for run in plan] == [error is not None for error in errors]
    assert capfd.readouterr() == ("", "")  # dask's own tale of dying workers is not told


def hears_the_keyboard() -> None:
    """Undo what a shell does to what it starts in the background, and a process hands down: to ignore Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@contextlib.contextmanager
def stopped_after(rows: int, command: list[str], out: Path, by: signal.Signals) -> Iterator[int]:
    """Start a sweep as a command of its own, end it after some rows; give its exit code."""
    sweep = subprocess.Popen(
        [sys.executable, "-m", "han_bullet.cli", *command],
        stdout=subprocess.DEVNULL,
        start_new_session=True,
        preexec_fn=hears_the_keyboard,
    )
    while sweep.poll() is None and len(list(out.glob("rows/*.parquet"))) < rows:
        time.sleep(0.02)
    os.killpg(sweep.pid, by) if by == signal.SIGINT else os.kill(sweep.pid, by)  # the keyboard reaches its children
    yield sweep.wait()


@pytest.mark.scenario
def test_a_sweep_that_is_interrupted_or_killed_goes_on_where_it_stopped(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, world = tmp_path / "out", brief(tmp_path, duration=4.0)
    command = ["sweep", str(world), "--seeds", "0-11", "--variants", "truth", "--processes", "1", "--out", str(out)]
    with stopped_after(1, command, out, signal.SIGINT) as code:
        assert code == 130
    done = {path: path.stat().st_mtime_ns for path in out.glob("rows/*.parquet")}
    assert 1 <= len(done) < 12
    with stopped_after(len(done) + 1, command, out, signal.SIGKILL) as code:
        assert code == -signal.SIGKILL
    done = {path: path.stat().st_mtime_ns for path in out.glob("rows/*.parquet")} | done
    assert 2 <= len(done) < 12 and all(read_row(path) is not None for path in done)
    assert main(command) == 0
    told = capsys.readouterr().out
    assert f"kept from before: {len(done)} " in told and "12 of 12 runs are done" in told
    assert {path: path.stat().st_mtime_ns for path in done} == done
    assert read_rows(out).num_rows == 12


@pytest.mark.parametrize("address", ["garbage", "10.0.0.1:8786", "tcp://10.0.0.1", "tcp://10.0.0.1:x", "foo://a:1"])
def test_what_is_no_address_of_a_scheduler_is_told_in_a_sentence(address: str, tmp_path: Path) -> None:
    plan = plan_sweep([brief(tmp_path)], [0], ["truth"])
    with pytest.raises(BadInputError, match=f"scheduler '{address}' is no address; one like tcp://"):
        run_sweep(plan, tmp_path, scheduler=address)


def test_a_scheduler_that_does_not_answer_is_told_in_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("han_bullet.sweep.workers.ANSWER_WITHIN", 0.5)
    plan = plan_sweep([brief(tmp_path)], [0], ["truth"])
    with pytest.raises(BadInputError, match=r"no dask scheduler answers at 'tcp://127.0.0.1:9'"):
        run_sweep(plan, tmp_path, scheduler="tcp://127.0.0.1:9")


@pytest.mark.scenario
def test_a_sweep_uses_somebodys_cluster_and_goes_on_after_that_went_away(tmp_path: Path) -> None:
    class Shutting(Counting):
        def ended(self, row: dict[str, Any]) -> None:
            super().ended(row)
            theirs.shutdown()

    plan, rows = plan_sweep([brief(tmp_path)], range(3), ["truth"]), tmp_path / "rows"
    with local_workers(1) as theirs, pytest.raises(WorkerDiedError, match="the dask scheduler is gone"):
        run_sweep(plan, tmp_path, scheduler=theirs.scheduler.address, onlooker=Shutting())
    done = len(list(rows.glob("*.parquet")))
    assert 1 <= done < 3
    again = Counting()
    with local_workers(1) as theirs:
        found = run_sweep(plan, tmp_path, scheduler=theirs.scheduler.address, onlooker=again)
        assert theirs.run(os.getpid)  # it is still there for its owner
    assert [row["seed"] for row in found] == [0, 1, 2]
    assert (len(again.kept), len(again.rows)) == (done, 3 - done)


@pytest.mark.scenario
def test_the_example_of_the_documentation_runs_as_a_script(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (Path(__file__).parent.parent / "docs/sweep.md").read_text()
    code = text.split("```python\n")[1].split("```")[0]
    assert '"real2"' in code and "range(3)" in code and "processes=2" in code
    code = code.replace('"real2"', repr(str(brief(tmp_path)))).replace("range(3)", "[5]")
    script = tmp_path / "mine.py"
    script.write_text(code.replace("processes=2", "processes=1"))
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(script), run_name="__main__")
    assert [line.split()[:3] for line in capsys.readouterr().out.splitlines()] == [
        ["truth", "5", "False"],
        ["truth+without:overtake", "5", "False"],
    ]
    assert read_rows(Path("runs/mine")).num_rows == 2
