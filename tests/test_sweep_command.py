"""`han-bullet sweep` as a person meets it: seeds, and refusals in a sentence before anything is written."""

import argparse
import importlib.util
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from han_bullet.cli import main
from han_bullet.commands import sweep
from han_bullet.sweep import running
from han_bullet.sweep.bar import SweepBar


@pytest.mark.parametrize(
    ("text", "expected"),
    [("3", (3,)), ("0-4", (0, 1, 2, 3, 4)), ("0-2,7", (0, 1, 2, 7)), ("5-5, 1", (5, 1)), ("0-19", tuple(range(20)))],
)
def test_seeds_are_numbers_and_ranges_that_hold_their_ends(text: str, expected: tuple[int, ...]) -> None:
    assert sweep.seeds(text) == expected


@pytest.mark.parametrize("text", ["", "x", "3-", "-3", "4-2", "1.5", "0-2-4", "0..4"])
def test_what_is_no_seed_is_refused(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match=r"would be right|neither a seed nor a range"):
        sweep.seeds(text)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["nowhere"], "'nowhere' is not known; there are"),
        (["real2", "--variants", "truth,turth"], "variant 'turth': 'turth' is no word"),
        (["real2", "--variants", "truth+without:overtke"], "layer 'overtke' is not known"),
        (["real2", "--variants", "truth,camera:camera9"], "world 'real2' has no camera 'camera9'"),
        (["real2", "--seeds", "9-0"], "'9-0' is neither a seed nor a range"),
        (["real2", "--processes", "2", "--scheduler", "tcp://a:1"], "not allowed with"),
    ],
)
def test_bad_input_is_one_sentence_and_nothing_is_written(
    arguments: list[str], expected: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "out"
    assert main(["sweep", *arguments, "--out", str(out)]) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("han-bullet: ") and captured.err.count("\n") == 1 and expected in captured.err
    assert not out.exists()


def test_without_its_libraries_it_says_what_to_install(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    there = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "pyarrow" else there(name))
    assert main(["sweep", "real2"]) == 2
    assert capsys.readouterr().err == ("han-bullet: han-bullet sweep needs pyarrow: pip install 'han_bullet[sweep]'\n")


def row(seed: int, **others: Any) -> dict[str, Any]:
    return {"world": "a", "variant": "truth", "seed": seed, "passed": True, "failed": "", "error": None} | others


def test_the_table_counts_what_was_met_and_names_the_seeds_where_it_was_not() -> None:
    rows = [row(0), row(1, passed=False, failed="x = 2, expected <= 1"), row(2, passed=False, error="it died")]
    rows.append(row(3, passed=False, failed="x = 2, expected <= 1"))
    console = Console(record=True, width=100)
    console.print(sweep._table(rows))
    text = console.export_text()
    assert "1 of 4" in text and "seed 1: x = 2, expected <= 1, and in 1 more" in text and "seed 2: not run" in text


def test_what_a_run_died_of_is_printed_as_it_is_with_all_its_brackets(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    died = row(0, passed=False, error="ValueError: [/] is no index of [red]", folder="runs/a/truth/0")
    monkeypatch.setattr(running, "run_sweep", lambda *_, **__: [died])
    assert main(["sweep", "real2", "--variants", "truth", "--seeds", "0", "--out", str(tmp_path / "[out]")]) == 3
    told = capsys.readouterr().out
    assert "not run: runs/a/truth/0: ValueError: [/] is no index of [red]\n" in told
    assert f"results in {tmp_path}/[out]/" in told


def test_where_nobody_watches_a_line_tells_of_the_end_and_of_rows_of_another_commit() -> None:
    console = Console(record=True, width=200, force_terminal=False)
    bar = SweepBar(console)
    bar.started(2, [row(7, git_commit="abc", folder="runs/a/truth/7")])
    bar.ended(row(0))
    bar.ended(row(1, passed=False, failed="x"))
    bar.close()
    first, second, last = console.export_text().splitlines()
    assert first == "kept from before: 1 (--fresh does them again)"
    assert second == "of another commit: 1 of them, such as runs/a/truth/7 of abc"
    assert last.startswith("2 of 2 runs, ") and last.endswith("0:00 min left, expectations not met in 1")
