"""`detect` on every kind of picture, video and folder: what is found, what is said, what is written."""

import csv
from collections.abc import Sequence
from pathlib import Path

import cv2
import imageio_ffmpeg
import numpy as np
import PIL.Image
import pytest
from bars import WHITE, bar_model, image

from han_bullet.cli import main
from han_bullet.detection.hog_detector import HogDetector


@pytest.fixture
def model(tmp_path: Path) -> Path:
    bar_model().with_score_threshold(20.0).save(tmp_path / "bars.npz")
    return tmp_path / "bars.npz"


def bars() -> np.ndarray:
    """Return a picture with one bar at column 72, which the model finds."""
    return image((60, WHITE))


@pytest.fixture(autouse=True)
def without_cnn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bars are no pedestrians: let the second stage keep everything."""
    monkeypatch.setattr("han_bullet.detection.cnn.load_classifier", lambda name: None)


def detect(paths: Sequence[Path | str], out: Path, model: Path) -> int:
    return main(["detect", *map(str, paths), "--out", str(out), "--model", str(model)])


def rows(out: Path) -> list[dict[str, str]]:
    header, *_ = (out / "detections.csv").read_text().splitlines()
    assert header == "image,x,y,width,height,score,probability"
    return list(csv.DictReader((out / "detections.csv").open()))


def complaints(capsys: pytest.CaptureFixture[str]) -> list[str]:
    return [line for line in capsys.readouterr().err.splitlines() if line]


def write_video(path: Path, pictures: Sequence[np.ndarray], rate: float = 10.0) -> None:
    height, width = pictures[0].shape[:2]
    writer = imageio_ffmpeg.write_frames(str(path), (width, height), fps=rate, macro_block_size=2)
    writer.send(None)
    for picture in pictures:
        writer.send(np.ascontiguousarray(picture))
    writer.close()


def save(kind: str, path: Path) -> Path:
    """Write the picture with a bar as a file of a kind."""
    picture = PIL.Image.fromarray(bars())
    if kind == "grey":
        picture.convert("L").save(path.with_suffix(".png"))
    elif kind == "rgba":
        picture.convert("RGBA").save(path.with_suffix(".png"))
    elif kind == "palette":
        picture.convert("P").save(path.with_suffix(".png"))
    elif kind == "16-bit":
        cv2.imwrite(str(path.with_suffix(".png")), bars()[:, :, 0].astype(np.uint16) * 257)
    elif kind == "cmyk":
        picture.convert("CMYK").save(path.with_suffix(".jpg"), quality=95)
    elif kind == "rotated":
        exif = PIL.Image.Exif()
        exif[0x0112] = 6  # to be turned clockwise when shown
        picture.rotate(90, expand=True).save(path.with_suffix(".jpg"), exif=exif, quality=95)
    else:
        picture.save(path.with_suffix(f".{kind}"))
    return next(file for file in path.parent.iterdir() if file.stem == path.stem)


@pytest.mark.parametrize("kind", ["png", "bmp", "webp", "ppm", "grey", "rgba", "palette", "16-bit", "cmyk", "rotated"])
def test_the_same_bar_is_found_in_every_kind_of_picture(tmp_path: Path, model: Path, kind: str) -> None:
    file = save(kind, tmp_path / "in")
    assert detect([file], tmp_path / "out", model) == 0
    found = rows(tmp_path / "out")
    assert found and {row["image"] for row in found} == {str(file)}
    assert float(found[0]["x"]) + float(found[0]["width"]) / 2 == pytest.approx(72.0, abs=9.0)
    assert cv2.imread(str(tmp_path / "out/in_boxes.png")).shape == (240, 320, 3)


@pytest.mark.parametrize("shape", [(1, 1), (60, 40), (99, 300)])
def test_a_picture_smaller_than_a_person_holds_nobody(tmp_path: Path, model: Path, shape: tuple[int, int]) -> None:
    cv2.imwrite(str(tmp_path / "tiny.png"), np.full((*shape, 3), 200, np.uint8))
    assert detect([tmp_path / "tiny.png"], tmp_path / "out", model) == 0
    assert rows(tmp_path / "out") == []
    assert cv2.imread(str(tmp_path / "out/tiny_boxes.png")).shape == (*shape, 3)


def test_what_cannot_be_read_is_told_in_a_sentence_each_and_the_rest_goes_on(
    tmp_path: Path, model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    good = save("png", tmp_path / "good")
    whole = good.read_bytes()
    (tmp_path / "empty.jpg").touch()
    (tmp_path / "text.png").write_text("hello")
    (tmp_path / "half.png").write_bytes(whole[: len(whole) // 2])
    PIL.Image.fromarray(np.random.default_rng(0).integers(0, 255, (300, 300, 3), np.uint8)).save(tmp_path / "h.jpg")
    (tmp_path / "half.jpg").write_bytes((tmp_path / "h.jpg").read_bytes()[:9000])
    (tmp_path / "empty.mp4").touch()
    bad = [tmp_path / name for name in ("empty.jpg", "text.png", "half.png", "half.jpg", "empty.mp4", "missing.png")]
    assert detect([*bad, good], tmp_path / "out", model) == 0
    said = complaints(capsys)
    assert len(said) == len(bad)
    assert all(line.startswith("han-bullet: ") for line in said)
    assert {path.name for path in bad} == {path.name for path in bad for line in said if str(path) in line}
    assert {row["image"] for row in rows(tmp_path / "out")} == {str(good)}
    assert [file.name for file in sorted((tmp_path / "out").iterdir())] == ["detections.csv", "good_boxes.png"]


def test_nothing_but_unreadable_files_is_exit_code_2(tmp_path: Path, model: Path) -> None:
    (tmp_path / "empty.jpg").touch()
    assert detect([tmp_path / "empty.jpg"], tmp_path / "out", model) == 2


def test_a_file_without_permission_is_told_with_the_reason(
    tmp_path: Path, model: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file = save("png", tmp_path / "secret")

    def refuse(*_: object, **__: object) -> None:  # the superuser, who may run this test, is never refused
        raise PermissionError(13, "Permission denied", str(file))

    monkeypatch.setattr("PIL.Image.open", refuse)
    assert detect([file], tmp_path / "out", model) == 2
    (line,) = complaints(capsys)
    assert "secret.png cannot be read: Permission denied" in line


def test_a_huge_picture_is_refused_before_its_pixels_are_read(
    tmp_path: Path, model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    PIL.Image.new("1", (20_000, 15_000)).save(tmp_path / "huge.png")
    assert detect([tmp_path / "huge.png"], tmp_path / "out", model) == 2
    (line,) = complaints(capsys)
    assert "huge.png" in line and ("too large" in line or "20000 x 15000 px" in line) and "36,000,000" in line


def test_a_folder_named_like_a_picture_is_a_folder(tmp_path: Path, model: Path) -> None:
    (tmp_path / "album.jpg").mkdir()
    save("png", tmp_path / "album.jpg" / "one")
    assert detect([tmp_path / "album.jpg"], tmp_path / "out", model) == 0
    assert (tmp_path / "out/one_boxes.png").exists()


def test_an_empty_folder_is_told(tmp_path: Path, model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "empty").mkdir()
    assert detect([tmp_path / "empty"], tmp_path / "out", model) == 2
    assert "no picture or video" in complaints(capsys)[0]


@pytest.mark.parametrize("ending", ["mp4", "avi", "mov", "mkv"])
def test_a_videos_frames_are_numbered_and_its_copy_plays_at_its_rate(tmp_path: Path, model: Path, ending: str) -> None:
    write_video(tmp_path / f"clip.{ending}", [bars(), image(), bars()], rate=10.0)
    assert detect([tmp_path / f"clip.{ending}"], tmp_path / "out", model) == 0
    name = str(tmp_path / f"clip.{ending}")
    assert {row["image"] for row in rows(tmp_path / "out")} == {f"{name}#000000", f"{name}#000002"}
    copy = imageio_ffmpeg.read_frames(str(tmp_path / "out/clip_boxes.mp4"))
    about = next(copy)
    assert (about["size"], about["fps"], about["codec"]) == ((320, 240), 10.0, "h264")
    assert sum(1 for _ in copy) == 3


def test_a_video_with_odd_sides_keeps_its_pixels(tmp_path: Path, model: Path) -> None:
    options = {"fps": 5.0, "codec": "ffv1", "pix_fmt_out": "bgr0", "macro_block_size": 1}
    writer = imageio_ffmpeg.write_frames(str(tmp_path / "odd.mkv"), (321, 241), **options)
    writer.send(None)
    for _ in range(2):
        writer.send(np.full((241, 321, 3), 90, np.uint8))
    writer.close()
    assert detect([tmp_path / "odd.mkv"], tmp_path / "out", model) == 0
    assert next(imageio_ffmpeg.read_frames(str(tmp_path / "out/odd_boxes.mp4")))["size"] == (322, 242)


def test_a_camera_that_is_not_there_is_told(tmp_path: Path, model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert detect(["97"], tmp_path / "out", model) == 2
    assert complaints(capsys) == ["han-bullet: camera97 is not a camera that OpenCV can read"]


def test_a_window_needs_a_display(
    tmp_path: Path, model: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert main(["detect", str(save("png", tmp_path / "one")), "--show", "--out", str(tmp_path / "out")]) == 2
    assert "--show needs a display" in complaints(capsys)[0]
    assert not (tmp_path / "out").exists()


def test_opencvs_detector_is_a_model_too(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "bars.png"), bars())
    options = ["--out", str(tmp_path / "out"), "--model", "hog", "--threshold", "-2"]
    assert main(["detect", str(tmp_path / "bars.png"), *options]) == 0
    expected = HogDetector(-2.0).detect(bars()).scores
    assert len(expected) > 0
    assert [float(row["score"]) for row in rows(tmp_path / "out")] == pytest.approx(expected.tolist(), abs=0.01)
