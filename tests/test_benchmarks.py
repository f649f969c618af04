"""`python -m benchmarks`: what it lists, and that it goes on where a benchmark fails."""

import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks import __main__ as everything
from benchmarks import results

FOLDER = Path(results.__file__).parent


def test_help_lists_every_benchmark_with_its_first_line() -> None:
    told = everything.listing()
    run, alone = told.split("not run")
    programs = {path.stem for path in FOLDER.glob("[a-z]*.py") if "def main()" in path.read_text()}
    listed = [{line.split()[0] for line in part.splitlines() if line.startswith("  ")} for part in (run, alone)]
    assert listed[0] | listed[1] == programs and not listed[0] & listed[1]
    assert listed[0] == {name for name, *_ in everything.BENCHMARKS}
    assert "How long an update of the whole costmap takes, layer by layer, by the number of people." in run


def test_help_runs_nothing() -> None:
    done = subprocess.run([sys.executable, "-m", "benchmarks", "--help"], capture_output=True, text=True, check=True)
    assert "run, in this order:" in done.stdout and "not run, only by their name:" in done.stdout


def test_a_benchmark_that_fails_is_named_and_the_others_are_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(everything, "BENCHMARKS", (("sweep_tables",), ("work", "--help")))
    monkeypatch.setattr(results, "RESULTS", tmp_path / "RESULTS.md")
    monkeypatch.setattr(sys, "argv", ["benchmarks"])
    assert everything.main() == 1
    written = (tmp_path / "RESULTS.md").read_text()
    assert "`benchmarks.sweep_tables` ended with exit code 2." in written and "usage: work.py" in written
