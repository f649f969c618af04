"""`han-bullet evaluate` as a person meets it: tables, files, one sentence about what is wrong."""

import hashlib
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from little_samples import small_network
from rich.progress import Progress

from han_bullet.cli import main
from han_bullet.detection.acf import load_acf_model
from han_bullet.detection.cnn import save_network


def complaint(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(["evaluate", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("han-bullet: ") and captured.err.count("\n") == 1
    assert "Traceback" not in captured.err + captured.out
    return captured.err


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """Return a folder with two grey photographs, a person noted in the first."""
    folder = tmp_path / "data"
    (folder / "inria" / "test").mkdir(parents=True)
    for name in ("a.png", "b.png"):
        assert cv2.imwrite(str(folder / "inria" / "test" / name), np.full((240, 320, 3), 90, np.uint8))
    labels = {"a.png": {"boxes_xyxy": [[60, 70, 100, 170]]}, "b.png": {"boxes_xyxy": []}}
    (folder / "inria" / "gt.json").write_text(json.dumps(labels), encoding="utf-8")
    return folder


def test_the_table_is_shown_and_its_files_are_written(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "new" / "out"
    assert main(["evaluate", "--data", str(data), "--out", str(out)]) == 0
    shown = capsys.readouterr().out
    assert "ACF + CNN" in shown and "paper rule" in shown and "2 INRIA test photographs with 1 people" in shown
    assert "a threshold that was chosen on the same photographs are no independent test" in shown
    assert {path.name for path in out.iterdir()} == {"evaluation.json", "evaluation.md", "miss_rate_INRIA.png"}
    assert len(json.loads((out / "evaluation.json").read_text())["rows"]) == 6


def test_other_models_stand_in_the_same_table(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--data", str(data), "--compare", "acf_inria", "hog", "--out", str(tmp_path / "out")]
    assert main(["evaluate", *arguments]) == 0
    rows = json.loads((tmp_path / "out" / "evaluation.json").read_text())["rows"]
    assert [row["model"] for row in rows] == ["default"] * 6 + ["acf_inria"] * 6 + ["OpenCV"]
    assert (rows[-1]["detector"], rows[-1]["rule"], rows[-1]["threshold"]) == ("HOG", "-", None)


def test_files_of_one_stem_are_told_apart_by_path_and_checksum(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = [tmp_path / folder / "acf.npz" for folder in ("a", "b")]
    for file, threshold in zip(files, (30.0, 40.0), strict=True):
        file.parent.mkdir()
        load_acf_model().with_score_threshold(threshold).save(file)
    classifier = tmp_path / "mine.safetensors"
    save_network(small_network(), classifier)
    arguments = ["--model", str(files[0]), "--compare", str(files[1]), "--classifier", str(classifier)]
    assert main(["evaluate", "--data", str(data), *arguments, "--out", str(tmp_path / "out")]) == 0
    document = json.loads((tmp_path / "out" / "evaluation.json").read_text())
    assert [row["model"] for row in document["rows"]] == [str(files[0])] * 6 + [str(files[1])] * 6
    expected = [("model", file) for file in files] + [("classifier", classifier)]
    assert document["weights"] == [
        {"part": part, "given": str(file), "file": str(file), "sha256": hashlib.sha256(file.read_bytes()).hexdigest()}
        for part, file in expected
    ]
    assert len({file["sha256"] for file in document["weights"]}) == 3


def test_the_choice_of_a_threshold_shows_how_many_photographs_are_done(
    data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[int] = []
    monkeypatch.setattr(Progress, "update", lambda bar, task, completed: done.append(completed))
    assert main(["evaluate", "--data", str(data), "--choose-threshold"]) == 2  # nothing is found on grey
    assert done == [1, 2]


def test_rendered_sequences_are_measured_without_photographs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["evaluate", "--rendered", "--frames", "20", "--out", str(tmp_path / "out")]) == 0
    assert "20 rendered frames of each sequence" in capsys.readouterr().out
    rows = json.loads((tmp_path / "out" / "evaluation.json").read_text())["rows"]
    assert [row["images"] for row in rows] == ["corridor"] * 6 + ["MBOT"] * 6
    assert {path.name for path in (tmp_path / "out").glob("*.png")} == {
        "miss_rate_corridor.png",
        "miss_rate_MBOT.png",
    }


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ([], "either --data DIR with photographs or --rendered"),
        (["--data", "{data}", "--rendered"], "either --data DIR with photographs or --rendered"),
        (["--rendered", "--choose-threshold"], "--choose-threshold is for photographs"),
        (["--data", "{data}", "--choose-threshold", "--compare", "hog"], "--model alone, without --compare and"),
        (["--data", "{data}", "--choose-threshold", "--classifier", "cnn_inria"], "without --compare and --classifier"),
        (["--data", "{data}", "--choose-threshold", "--model", "hog"], "only ACF models have a threshold to choose"),
        (["--data", "{data}", "--frames", "20"], "--frames is for --rendered"),
        (["--rendered", "--frames", "0"], "'0' is not a whole number of at least 1"),
        (["--rendered", "--frames", "1", "--model", "acf_nowhere"], "acf_nowhere"),
        (["--data", "nowhere"], "'nowhere' does not exist"),
        (["--data", "{empty}"], "neither inria/ nor INRIAPerson/"),
        (["--data", "{data}", "--model", "acf_nowhere"], "acf_nowhere"),
        (["--data", "{data}", "--compare", "acf_nowhere"], "acf_nowhere"),
        (["--data", "{data}", "--model", "{file}"], "file.npz is not an ACF model"),
        (["--data", "{data}", "--classifier", "{file}"], "file.npz is not a pedestrian classifier"),
        (["--data", "{data}", "--out", "{file}"], "file.npz' is a file; a folder would be right"),
        (["--data", "{data}", "--out", "{file}/below"], "file.npz' is a file; a folder would be right"),
    ],
)
def test_bad_input_is_one_sentence(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], expected: str
) -> None:
    places = {"data": data, "empty": tmp_path / "empty", "file": tmp_path / "file.npz"}
    places["empty"].mkdir()
    places["file"].write_text("no model")
    assert expected in complaint(capsys, *(argument.format(**places) for argument in arguments))


def test_a_photograph_that_cannot_be_read_is_named(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (data / "inria" / "test" / "b.png").write_text("no picture")
    assert "b.png is not a picture" in complaint(capsys, "--data", str(data))


def test_photographs_without_anybody_are_refused(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (data / "inria" / "gt.json").write_text('{"a.png": {"boxes_xyxy": []}}', encoding="utf-8")
    assert "no person in them" in complaint(capsys, "--data", str(data))
    assert "no person in them" in complaint(capsys, "--data", str(data), "--choose-threshold")


def test_a_list_that_is_no_list_is_refused(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (data / "inria" / "gt.json").write_text("{", encoding="utf-8")
    assert "gt.json must map names to boxes_xyxy" in complaint(capsys, "--data", str(data))
