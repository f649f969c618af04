"""`han-bullet report` as a person meets it."""

from pathlib import Path

import pytest
from test_sweep_page import write_row

from han_bullet.cli import main
from han_bullet.report.markup import Html, element, table


def complaint(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(["report", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("han-bullet: ") and captured.err.count("\n") == 1
    return captured.err


def test_a_run_and_a_sweep_get_a_page_each(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run, sweep = tmp_path / "run", tmp_path / "sweep"
    assert main(["run", "sim1", "--perception", "truth", "--no-video", "--out", str(run)]) == 0
    write_row(sweep, "real2", "truth", 0)
    capsys.readouterr()
    assert main(["report", str(run), str(sweep)]) == 0
    assert capsys.readouterr().out.splitlines() == [
        f"report: {run / 'report.html'}",
        f"report: {sweep / 'report.html'}",
    ]
    assert (run / "report.html").stat().st_size > 50_000 and (sweep / "report.html").exists()


def test_what_is_neither_run_nor_sweep_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = complaint(capsys, str(tmp_path))
    assert f"'{tmp_path}' is neither a run" in told and "nor a sweep" in told
    assert "neither" in complaint(capsys, str(tmp_path / "nowhere"))
    assert list(tmp_path.iterdir()) == []


def test_nothing_to_report_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    assert "folder of a run or of a sweep, or --figures DIR" in complaint(capsys)


def test_a_baseline_for_a_single_run_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "result.json").write_text("{}")
    told = complaint(capsys, str(tmp_path), "--baseline", "truth")
    assert f"--baseline truth: {str(tmp_path)!r} is a single run" in told


def test_a_baseline_that_is_no_variant_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_row(tmp_path, "real2", "truth", 0)
    assert "baseline 'nn' is no variant" in complaint(capsys, str(tmp_path), "--baseline", "nn")
    assert not (tmp_path / "report.html").exists()


def test_text_is_escaped_and_html_is_not() -> None:
    inner = element("b", "a < b & c", title='"quoted"')
    assert inner == '<b title="&quot;quoted&quot;">a &lt; b &amp; c</b>'
    assert element("p", inner, "<i>") == f"<p>{inner}&lt;i&gt;</p>"
    assert element("img", src="x") == '<img src="x">'
    assert "&lt;td&gt;" in table(("a",), [["<td>"]]) and isinstance(table(("a",), []), Html)
