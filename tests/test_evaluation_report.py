"""The columns and the files of an evaluation."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from han_bullet.detection.evaluation import Evaluation
from han_bullet.detector_figures import FiguresRow
from han_bullet.evaluation_report import COLUMNS, PHOTOGRAPHS, RENDERED, WeightsFile, cells, write_report

# 100 images; the k-th false positive comes after k of 150 people.
EVALUATION = Evaluation(np.arange(300.0)[::-1], np.tile([True, False], 150), images=100, people=150)
ABOVE = EVALUATION.above(150.0)
ROWS = [
    FiguresRow("INRIA", "ACF", "acf_inria", "-", None, EVALUATION, 3.0, 3.0, 0.025, 0.0),
    FiguresRow("INRIA", "ACF + CNN", "acf_inria", "paper rule", 150.0, ABOVE, 1.625, 1.5, 0.025, 0.015),
]


WEIGHTS = [WeightsFile("model", "mine", "mine.npz", "ab12"), WeightsFile("model", "hog", None, None)]


def test_a_line_shows_which_proposals_count_what_was_found_and_how_fast() -> None:
    rate = f"{ABOVE.log_average_miss_rate():.2%}"
    alone, both = cells(ROWS, PHOTOGRAPHS)
    assert both == ["ACF + CNN", "acf_inria", "paper rule", ">= 150.00", "75", "75", "75", rate, "25.00"]
    assert (alone[3:7], alone[-1]) == (["all", "150", "150", "0"], "40.00")
    assert cells(ROWS, RENDERED)[1][5:] == ["1.62", "1.50", "25.0", "15.0", "25.00", rate, "50.0%", "0.750"]


def test_every_column_of_the_tables_exists() -> None:
    assert set(COLUMNS) == {*PHOTOGRAPHS, *RENDERED}


def test_the_files_hold_the_table_the_notes_and_where_the_figures_come_from(tmp_path: Path) -> None:
    write_report(tmp_path, ROWS, PHOTOGRAPHS, {"images": "100 made-up photographs"}, WEIGHTS)
    document = json.loads((tmp_path / "evaluation.json").read_text())
    first, second = document["rows"]
    assert (first["true_positives"], second["true_positives"]) == (150, 75)
    assert (first["threshold"], second["threshold"]) == (None, 150.0)
    assert second["frames_per_second"] == pytest.approx(25.0)
    assert first["miss_rate"] == pytest.approx(EVALUATION.log_average_miss_rate())
    assert first["reference_false_positives_per_image"][::4] == pytest.approx([0.01, 0.1, 1.0])
    assert first["reference_miss_rates"][::4] == pytest.approx([1 - 2 / 150, 1 - 11 / 150, 1 - 101 / 150])
    assert document["images"] == "100 made-up photographs"
    assert {"git_commit", "processor", "versions"} <= set(document)
    assert document["weights"][0] == {"part": "model", "given": "mine", "file": "mine.npz", "sha256": "ab12"}
    assert [file["given"] for file in document["weights"]] == ["mine", "hog"]
    lines = (tmp_path / "evaluation.md").read_text().splitlines()
    assert [line.count("|") for line in lines[2:6]] == [10, 10, 10, 10]
    assert "- images: 100 made-up photographs" in lines
    assert "- model mine: sha256 ab12" in lines
    assert not [line for line in lines if "hog" in line]  # it has no file


def test_the_curves_of_each_set_of_images_are_drawn(tmp_path: Path) -> None:
    write_report(tmp_path, ROWS, PHOTOGRAPHS, {}, [])
    (file,) = tmp_path.glob("*.png")
    picture = cv2.imread(str(file))
    assert (file.name, picture.shape) == ("miss_rate_INRIA.png", (900, 1080, 3))
    best_of_all = np.abs(picture.astype(int) - (180, 119, 31)).max(axis=2) < 30  # matplotlib's first colour, in BGR
    assert best_of_all.sum() > 1000
