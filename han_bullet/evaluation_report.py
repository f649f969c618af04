"""The files that `han-bullet evaluate --out` leaves: figures for programs, a table for people, the curves."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from han_bullet.atomic_file import write_at_once, write_json
from han_bullet.detection.evaluation import REFERENCE_RATES
from han_bullet.inria_table import TableRow
from han_bullet.markdown import markdown_table
from han_bullet.miss_rate_plot import Curve, draw_miss_rates
from han_bullet.provenance import git_commit, processor, versions

HEADINGS = ("detector", "model", "rule", "proposals", "TP", "FP", "FN", "miss rate", "fps")
LEGEND = (
    "miss rate: log-average over nine rates of false positives per image from 0.01 to 1; "
    "fps: photographs per second through the stages, one thread, files already read"
)


def cells(row: TableRow) -> tuple[str, ...]:
    """Return a line of the table as text, under HEADINGS."""
    counts = row.evaluation.counts()
    return (
        row.detector,
        row.model,
        row.rule,
        proposals(row.threshold),
        str(counts.true_positives),
        str(counts.false_positives),
        str(counts.false_negatives),
        f"{row.evaluation.log_average_miss_rate():.2%}",
        f"{row.frames_per_second:.2f}",
    )


def proposals(threshold: float | None) -> str:
    """Tell in words which proposals count."""
    return "all" if threshold is None else f">= {threshold:.2f}"


def write_report(folder: Path, rows: Sequence[TableRow], note: str) -> None:
    """Write evaluation.json, evaluation.md and miss_rate.png.

    Args:
        folder: Where; it exists.
        rows: The table.
        note: What was looked at.
    """
    write_figures(folder / "evaluation", markdown_table(HEADINGS, map(cells, rows)), map(_document, rows), LEGEND, note)
    draw_miss_rates(folder / "miss_rate.png", [_curve(row) for row in rows])


def write_figures(stem: Path, table: str, rows: Iterable[dict[str, Any]], legend: str, note: str) -> None:
    """Write figures as a .json and a .md file, with what they mean, what was looked at and where they come from."""
    sources = {"figures": legend, "data": note, "git_commit": git_commit(), "processor": f"{processor()}, one thread"}
    libraries = versions()
    write_json(stem.with_suffix(".json"), {"rows": list(rows), **sources, "versions": libraries})
    sources["versions"] = ", ".join(f"{name} {version}" for name, version in libraries.items())
    lines = "\n".join(f"- {name}: {value}" for name, value in sources.items())
    write_at_once(stem.with_suffix(".md"), f"# {stem.name.capitalize()}\n\n{table}\n\n{lines}\n".encode())


def _document(row: TableRow) -> dict[str, Any]:
    """Return a line of the table for programs."""
    evaluation = row.evaluation
    return {
        "detector": row.detector,
        "model": row.model,
        "rule": row.rule,
        "threshold": row.threshold,
        **asdict(evaluation.counts()),
        "miss_rate": evaluation.log_average_miss_rate(),
        "frames_per_second": row.frames_per_second,
        "false_positives_per_image": REFERENCE_RATES.tolist(),
        "miss_rates": evaluation.reference_miss_rates().tolist(),
    }


def _curve(row: TableRow) -> Curve:
    parts = [part for part in (row.detector, row.model, row.rule, proposals(row.threshold)) if part != "-"]
    return Curve(", ".join(parts), row.evaluation, dashed=row.threshold is not None)
