"""The benchmark of start and memory, on programs that take a moment."""

import sys
from pathlib import Path

import pytest

from benchmarks.footprint import OTHERS, PROGRAM, RUNS, Footprint, has_stepped, measure, run_row
from han_bullet.cli import _parser

# Writes a trace as a run does, half a second from each line to the next, and holds 64 MiB while it goes on.
RUN = """
import sys, time
from pathlib import Path
held = b"x" * (64 << 20)
Path(sys.argv[-1]).mkdir()
for line in ("time,robot.x", "0.000000,1.0", "0.050000,1.0", "0.100000,1.0"):
    with open(Path(sys.argv[-1], "trace.csv"), "a") as trace:
        trace.write(line + "\\n")
    time.sleep(0.5)
sys.exit({code})
"""


def test_a_step_is_taken_when_a_whole_row_follows_that_of_the_start(tmp_path: Path) -> None:
    trace = tmp_path / "trace.csv"
    assert not has_stepped(trace)
    trace.write_text("time,robot.x\n0.000000,1.0\n0.05")
    assert not has_stepped(trace)
    trace.write_text("time,robot.x\n0.000000,1.0\n0.050000,1.0\n")
    assert has_stepped(trace)


def test_a_run_is_watched_until_its_first_step_and_its_memory_until_its_end(tmp_path: Path) -> None:
    found = measure([sys.executable, "-c", RUN.format(code=0)], tmp_path / "run")
    assert found.first_step > 1.0  # [s], of the two waits before the step's row
    assert 64.0 < found.shared <= found.resident < 64.0 + 40.0
    assert 0.0 < found.processor < found.first_step
    assert found.processes == 1


@pytest.mark.parametrize(("code", "complaint"), [("pass", "ended with 0 before its first step"), (RUN, "ended with 3")])
def test_a_run_that_fails_gives_no_figure(tmp_path: Path, code: str, complaint: str) -> None:
    with pytest.raises(SystemExit, match=complaint):
        measure([sys.executable, "-c", code.format(code=3)], tmp_path / "run")


def test_a_line_has_the_medians_of_the_rounds_and_the_slowest() -> None:
    rounds = [
        Footprint(2.5, 4.5, 900.0, 1500.0, 5),
        Footprint(4.0, 4.7, 950.4, 1600.0, 5),
        Footprint(2.6, 4.8, 940.0, 1540.0, 4),
    ]
    assert run_row("five cameras", rounds) == ("five cameras", "2.60", "4.00", "4.70", 940, 1540, 5)


def test_what_is_measured_are_commands_that_exist() -> None:
    assert PROGRAM.is_file()
    for arguments in RUNS.values():
        assert _parser().parse_args(["run", "real2", *arguments]).world == "real2"
    assert ("worlds",) in OTHERS
