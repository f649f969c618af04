"""The files of an evaluation."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from han_bullet.detection.evaluation import Evaluation
from han_bullet.evaluation_report import cells, write_report
from han_bullet.inria_table import TableRow

# 100 images; the k-th false positive comes after k of 150 people.
EVALUATION = Evaluation(np.arange(300.0)[::-1], np.tile([True, False], 150), images=100, people=150)
ROWS = [
    TableRow("ACF", "acf_inria", "-", None, EVALUATION, 40.0),
    TableRow("ACF + CNN", "acf_inria", "paper rule", 150.0, EVALUATION.above(150.0), 20.5),
]


def test_a_line_shows_which_proposals_count_and_what_was_found() -> None:
    rate = f"{EVALUATION.above(150.0).log_average_miss_rate():.2%}"
    assert cells(ROWS[1]) == ("ACF + CNN", "acf_inria", "paper rule", ">= 150.00", "75", "75", "75", rate, "20.50")
    assert cells(ROWS[0])[3:7] == ("all", "150", "150", "0")


def test_the_files_hold_the_table_the_note_and_where_the_figures_come_from(tmp_path: Path) -> None:
    write_report(tmp_path, ROWS, "100 made-up photographs")
    document = json.loads((tmp_path / "evaluation.json").read_text())
    assert [row["true_positives"] for row in document["rows"]] == [150, 75]
    assert [row["threshold"] for row in document["rows"]] == [None, 150.0]
    assert document["rows"][0]["miss_rate"] == pytest.approx(EVALUATION.log_average_miss_rate())
    assert document["rows"][0]["false_positives_per_image"][::4] == pytest.approx([0.01, 0.1, 1.0])
    assert document["rows"][0]["miss_rates"][::4] == pytest.approx([1 - 2 / 150, 1 - 11 / 150, 1 - 101 / 150])
    assert document["data"] == "100 made-up photographs"
    assert {"git_commit", "processor", "versions", "figures"} <= set(document)
    lines = (tmp_path / "evaluation.md").read_text().splitlines()
    assert [line.count("|") for line in lines[2:6]] == [10, 10, 10, 10]
    assert "- data: 100 made-up photographs" in lines


def test_the_curves_are_drawn(tmp_path: Path) -> None:
    write_report(tmp_path, ROWS, "")
    picture = cv2.imread(str(tmp_path / "miss_rate.png"))
    assert picture.shape == (720, 960, 3)
    first_colour = np.abs(picture.astype(int) - (180, 119, 31)).max(axis=2) < 30  # matplotlib's C0, in BGR
    assert first_colour.sum() > 1000
