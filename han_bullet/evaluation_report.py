"""How the detector's figures are shown: columns of the tables, files for programs and for people, the curves."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from han_bullet.atomic_file import write_at_once, write_json
from han_bullet.detection.evaluation import REFERENCE_RATES
from han_bullet.detector_figures import FiguresRow
from han_bullet.markdown import markdown_table
from han_bullet.miss_rate_plot import Curve, draw_miss_rates
from han_bullet.provenance import git_commit, processor, versions


@dataclass(frozen=True)
class WeightsFile:
    """Where the weights of one stage come from.

    Attributes:
        part: "model", a first stage, or "classifier".
        given: Name or path as it was given.
        file: Path of the file; None for OpenCV's detector, which has none.
        sha256: Its checksum.
    """

    part: str
    given: str
    file: str | None
    sha256: str | None


COLUMNS: Mapping[str, Callable[[FiguresRow], str]] = {
    "images": lambda row: row.images,
    "detector": lambda row: row.detector,
    "model": lambda row: row.model,
    "rule": lambda row: row.rule,
    "proposals": lambda row: _proposals(row.threshold),
    "found": lambda row: f"{row.proposals:.2f}",
    "kept": lambda row: f"{row.detections:.2f}",
    "TP": lambda row: str(row.evaluation.counts().true_positives),
    "FP": lambda row: str(row.evaluation.counts().false_positives),
    "FN": lambda row: str(row.evaluation.counts().false_negatives),
    "recall": lambda row: f"{row.evaluation.recall():.1%}",
    "FPPI": lambda row: f"{row.evaluation.false_positives_per_image():.3f}",
    "miss rate": lambda row: f"{row.evaluation.log_average_miss_rate():.2%}",
    "first ms": lambda row: f"{1e3 * row.proposing:.1f}",
    "CNN ms": lambda row: f"{1e3 * row.classifying:.1f}",
    "fps": lambda row: f"{row.frames_per_second:.2f}",
}
PHOTOGRAPHS = ("detector", "model", "rule", "proposals", "TP", "FP", "FN", "miss rate", "fps")
RENDERED = (
    *("images", "detector", "model", "rule", "proposals", "found", "kept", "first ms", "CNN ms", "fps"),
    *("miss rate", "recall", "FPPI"),
)
MEASURES = (
    "miss rate: log-average over nine rates of false positives per image from 0.01 to 1; "
    "fps: images per second through the stages, one thread, files already read"
)
LEGEND = f"{MEASURES}; lines with a threshold that was chosen on the same photographs are no independent test of it"
RENDERED_LEGEND = (
    "found: proposals per image; kept: those of them that the rule keeps; first ms: time of the first stage; "
    f"FPPI: false positives per image; {MEASURES}"
)


def cells(rows: Sequence[FiguresRow], headings: Sequence[str]) -> list[list[str]]:
    """Return a table's lines as text."""
    return [[COLUMNS[heading](row) for heading in headings] for row in rows]


def write_report(
    folder: Path,
    rows: Sequence[FiguresRow],
    headings: Sequence[str],
    notes: Mapping[str, str],
    weights: Sequence[WeightsFile],
) -> None:
    """Write evaluation.json, evaluation.md and a picture of curves for each set of images, miss_rate_<images>.png.

    Args:
        folder: Where; it exists.
        rows: The table.
        headings: Columns of evaluation.md; evaluation.json has all.
        notes: What the figures mean and what was looked at.
        weights: Of all models and of the classifier.
    """
    sources = {**notes, "git_commit": git_commit(), "processor": processor()}
    libraries = versions()
    files = [asdict(file) for file in weights]
    document = {"rows": [_document(row) for row in rows], **sources, "weights": files, "versions": libraries}
    write_json(folder / "evaluation.json", document)
    sources |= {f"{file.part} {file.given}": f"sha256 {file.sha256}" for file in weights if file.sha256}
    sources["versions"] = ", ".join(f"{name} {version}" for name, version in libraries.items())
    lines = "\n".join(f"- {name}: {value}" for name, value in sources.items())
    text = f"# Evaluation\n\n{markdown_table(headings, cells(rows, headings))}\n\n{lines}\n"
    write_at_once(folder / "evaluation.md", text.encode())
    for name in dict.fromkeys(row.images for row in rows):
        draw_miss_rates(folder / f"miss_rate_{name}.png", [_curve(row) for row in rows if row.images == name])


def _document(row: FiguresRow) -> dict[str, Any]:
    """Return a line of the table for programs."""
    evaluation = row.evaluation
    return {
        "images": row.images,
        "detector": row.detector,
        "model": row.model,
        "rule": row.rule,
        "threshold": row.threshold,
        **asdict(evaluation.counts()),
        "miss_rate": evaluation.log_average_miss_rate(),
        "recall": evaluation.recall(),
        "false_positives_per_image": evaluation.false_positives_per_image(),
        "proposals": row.proposals,
        "detections": row.detections,
        "first_stage_seconds": row.proposing,
        "cnn_seconds": row.classifying,
        "frames_per_second": row.frames_per_second,
        "reference_false_positives_per_image": REFERENCE_RATES.tolist(),
        "reference_miss_rates": evaluation.reference_miss_rates().tolist(),
    }


def _proposals(threshold: float | None) -> str:
    """Tell in words which proposals count."""
    return "all" if threshold is None else f">= {threshold:.2f}"


def _curve(row: FiguresRow) -> Curve:
    parts = [part for part in (row.detector, row.model, row.rule, _proposals(row.threshold)) if part != "-"]
    return Curve(", ".join(parts), row.evaluation, dashed=row.threshold is not None)
