"""The command line as a person meets it: help, tables, one-sentence errors, exit codes."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from little_samples import small_network

from han_bullet.cli import main
from han_bullet.costmap.layers import SAFETY
from han_bullet.detection.cnn import save_network
from han_bullet.detection.model_files import proposer_file
from han_bullet.world_file import find_world, json_schema, world_document


def short_world(folder: Path, **changes: object) -> Path:
    """A copy of real2 that ends after a second."""
    document = yaml.safe_load(find_world("real2").read_text()) | {"duration": 1.0} | changes
    path = folder / "short.yaml"
    path.write_text(yaml.safe_dump(document))
    return path


def complaint(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("han-bullet: ") and captured.err.count("\n") == 1
    assert "Traceback" not in captured.err + captured.out
    return captured.err


def test_worlds_lists_each_world_with_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["worlds"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert {line.split()[0] for line in lines} >= {"real2", "sim1"}


def test_checking_a_world_shows_what_its_cameras_cover(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["worlds", "real2"]) == 0
    text = capsys.readouterr().out
    assert all(name in text for name in ("camera1", "camera2", "camera3", "camera4", "onboard"))


def test_the_schema_can_be_printed_for_editors(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["worlds", "--schema"]) == 0
    assert json.loads(capsys.readouterr().out) == json_schema()


@pytest.mark.parametrize(
    "command", ["worlds", "run", "sweep", "report", "explain", "export", "detect", "calibrate", "evaluate", "train"]
)
def test_every_command_has_help_with_examples(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main([command, "--help"])
    assert stop.value.code == 0
    assert "examples:" in capsys.readouterr().out


@pytest.mark.parametrize("command", ["run", "sweep"])
def test_help_says_which_layers_stay_without_the_social_ones(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main([command, "--help"])
    *others, last = SAFETY
    assert f"social: all but {', '.join(others)} and {last}" in " ".join(capsys.readouterr().out.split())


def test_an_unknown_world_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    assert "'nowhere' is not known; there are" in complaint(capsys, "run", "nowhere")


def test_an_unknown_option_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    assert "--sed" in complaint(capsys, "run", "real2", "--sed", "3")


@pytest.mark.parametrize("seed", ["-1", "1.5", "x"])
def test_a_seed_that_is_no_natural_number_is_refused(seed: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert seed in complaint(capsys, "run", "real2", f"--seed={seed}")


def test_an_unknown_layer_is_named_with_those_there_are(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out = tmp_path / "run"
    message = complaint(
        capsys, "run", "real2", "--perception", "truth", "--no-video", "--without", "overtke", "--out", str(out)
    )
    assert "'overtke'" in message and "overtake" in message and "social for all but safety" in message
    assert not out.exists()


def test_an_unknown_camera_is_named_with_those_there_are(capsys: pytest.CaptureFixture[str]) -> None:
    assert "camera9" in complaint(capsys, "run", "real2", "--cameras", "camera9")


def test_a_classifier_of_ones_own_is_used_and_named_in_the_result(tmp_path: Path) -> None:
    mine, out = tmp_path / "mine.safetensors", tmp_path / "run"
    save_network(small_network(), mine)
    path = short_world(tmp_path, duration=0.2)
    arguments = ["run", str(path), "--cameras", "onboard", "--no-video", "--out", str(out)]
    described = {}
    for classifier in ("default", str(mine)):
        assert main([*arguments, "--classifier", classifier]) == 0
        described[classifier] = json.loads((out / "result.json").read_text())["detector"]
    assert [described[name]["classifier"] for name in ("default", str(mine))] == ["cnn_inria", "mine"]
    assert described["default"]["threshold"] == described[str(mine)]["threshold"]  # the world's, for ACF's scores


def test_a_worlds_threshold_is_for_the_shipped_model_by_whatever_name_and_for_no_other(tmp_path: Path) -> None:
    shipped, out = proposer_file(), tmp_path / "run"
    copy = tmp_path / "acf_inria.npz"
    copy.write_bytes(shipped.read_bytes())
    path = short_world(tmp_path, duration=0.1, score_threshold=77.5)
    arguments = ["run", str(path), "--cameras", "onboard", "--no-video", "--out", str(out)]
    used = []
    for model in ("default", "acf_inria", str(shipped), str(copy)):
        assert main([*arguments, "--detector", model]) == 0
        used.append(json.loads((out / "result.json").read_text())["detector"]["threshold"])
    assert used[:3] == [77.5] * 3 and used[3] < 20.0


def test_a_classifier_that_does_not_exist_or_has_no_use_is_one_sentence(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    for command in (["run", "real2", "--no-video", "--detector"], ["detect", "x.png", "--model"]):
        out = ["--out", str(tmp_path / "out")]
        assert "cnn_nowhere" in complaint(capsys, *command, "default", "--classifier", "cnn_nowhere", *out)
        assert "one stage" in complaint(capsys, *command, "hog", "--classifier", "cnn_inria", *out)
    assert not (tmp_path / "out").exists()


def test_an_unknown_detector_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    assert "nothing_like_it" in complaint(capsys, "run", "real2", "--detector", "nothing_like_it", "--no-video")


def test_a_person_inside_a_wall_is_told_with_file_and_field(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    document = yaml.safe_load(find_world("real2").read_text())
    document["people"][0]["start"] = [4.5, 1.48, 0.0]
    path = short_world(tmp_path, people=document["people"], seed_varies={"person_start": 0.0})
    message = complaint(capsys, "run", str(path))
    assert "short.yaml" in message and "people[0].start" in message and "wall" in message


def test_a_goal_that_cannot_be_reached_is_told_with_file_and_field(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    walls = world_document("real2")["walls"]
    path = short_world(tmp_path, walls=[*walls, {"start": [10.0, -1.5], "end": [10.0, 1.5]}])
    message = complaint(capsys, "worlds", str(path))
    assert "short.yaml" in message and "task.pose" in message and "no free way" in message


def test_an_expectation_on_a_metric_that_does_not_exist_is_told_before_the_run(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = short_world(tmp_path, expectations=[{"metric": "applause", "at_least": 1.0}])
    out = tmp_path / "run"
    assert "'applause'" in complaint(capsys, "run", str(path), "--perception", "truth", "--no-video", "--out", str(out))
    assert not out.exists()


def test_a_check_that_fails_names_the_expectation_and_the_figure(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = short_world(tmp_path)
    arguments = ["run", str(path), "--perception", "truth", "--no-video", "--out", str(tmp_path / "run")]
    assert main([*arguments, "--check"]) == 1
    assert "outcome is timeout, expected == arrived" in capsys.readouterr().out
    assert main(arguments) == 0


def test_a_window_without_a_display_is_refused_in_one_sentence(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    assert "needs a display" in complaint(capsys, "run", "real2", "--perception", "truth", "--no-video", "--gui")


def test_detect_writes_boxes_and_pictures(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    picture = tmp_path / "grey.png"
    cv2.imwrite(str(picture), np.full((240, 320, 3), 128, np.uint8))
    assert main(["detect", str(picture), "--out", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out/detections.csv").read_text() == "image,x,y,width,height,score,probability\n"
    assert cv2.imread(str(tmp_path / "out/grey_boxes.png")).shape == (240, 320, 3)


def test_detect_never_overwrites_a_picture(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        cv2.imwrite(str(tmp_path / folder / "1.png"), np.full((120, 160, 3), 90, np.uint8))
    before = (tmp_path / "a/1.png").read_bytes()
    assert main(["detect", str(tmp_path / "a"), str(tmp_path / "b"), "--out", str(tmp_path / "a")]) == 0
    assert (tmp_path / "a/1.png").read_bytes() == before
    assert (tmp_path / "a/1_boxes.png").exists() and (tmp_path / "a/1_boxes2.png").exists()


def test_a_folder_that_is_a_file_is_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    out = str(tmp_path / "file")
    for command in (["run", "real2", "--out", out], ["run", "real2", "--out", f"{out}/run"]):
        assert f"{out!r} is a file; a folder would be right" in complaint(capsys, *command)
    plot = ["explain", str(tmp_path), "--time", "1", "--plot"]
    assert f"{out!r} is a file; a folder would be right" in complaint(capsys, *plot, f"{out}/moment.png")
    (tmp_path / "moment.png").mkdir()
    assert "moment.png' is a folder; a file" in complaint(capsys, *plot, str(tmp_path / "moment.png"))


def test_names_in_brackets_are_printed_as_they_are(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out = tmp_path / "[red]"
    world = str(short_world(tmp_path, expectations=[{"metric": "outcome", "equals": "[blue]"}]))
    assert main(["run", world, "--perception", "truth", "--no-video", "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    assert f"results in {out}/" in printed and "outcome is timeout, expected == [blue]" in printed
    assert main(["explain", str(out), "--time", "1", "--plot", str(out / "moment.png")]) == 0
    assert f"picture: {out / 'moment.png'}" in capsys.readouterr().out


def test_social_stands_for_all_layers_but_those_of_safety(tmp_path: Path) -> None:
    command = ["run", str(short_world(tmp_path)), "--perception", "truth", "--no-video", "--out", str(tmp_path / "run")]
    assert main([*command, "--without", "social,body"]) == 0
    assert json.loads((tmp_path / "run" / "result.json").read_text())["layers"] == ["static", "obstacle", "inflation"]


def test_detect_refuses_what_is_no_picture(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    text = tmp_path / "notes.png"
    text.write_text("hello")
    assert "notes.png is not a picture" in complaint(capsys, "detect", str(text), "--out", str(tmp_path / "out"))
    assert "does not exist" in complaint(capsys, "detect", str(tmp_path / "missing.jpg"))


def test_a_run_prints_its_headlines_by_subject_and_what_the_world_expects(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path, out = short_world(tmp_path, expectations=[{"metric": "mean_jerk", "at_most": 99.0}]), tmp_path / "run"
    assert main(["run", str(path), "--perception", "truth", "--no-video", "--out", str(out)]) == 0
    rows = [line.split("│")[1].strip() for line in capsys.readouterr().out.splitlines() if line.startswith("│")]
    subjects = [row for row in rows if row in ("task", "motion", "people", "perception")]
    assert subjects == ["task", "motion", "people", "perception"]
    assert {"outcome", "spl", "mean_jerk", "minimum_distance.walker", "mota"} <= set(rows)
    # No part of a figure that stands there for all, nothing without a value, no detail.
    assert not {"personal_space_intrusion.walker", "time_to_goal", "detection_recall", "max_jerk"} & set(rows)
    written = {metric["name"] for metric in json.loads((out / "result.json").read_text())["metrics"]}
    assert set(rows) - set(subjects) < written and "max_jerk" in written
    assert len(rows) < 35
