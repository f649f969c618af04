"""What a path names, and what a video tells of itself."""

from pathlib import Path

import imageio_ffmpeg
import numpy as np
import PIL.Image
import pytest

from han_bullet.errors import BadInputError
from han_bullet.image_sources import Video, find_sources


def write_video(path: Path, rate: float) -> Path:
    writer = imageio_ffmpeg.write_frames(str(path), (64, 48), fps=rate, macro_block_size=2)
    writer.send(None)
    for _ in range(3):
        writer.send(np.full((48, 64, 3), 90, np.uint8))
    writer.close()
    return path


@pytest.mark.parametrize("ending", ["mp4", "avi"])
@pytest.mark.parametrize("rate", [0.1, 0.5, 10.0])
def test_a_videos_rate_is_its_own_also_below_one_image_a_second(tmp_path: Path, rate: float, ending: str) -> None:
    video = Video(write_video(tmp_path / f"lapse.{ending}", rate))
    assert len(list(video.images())) == 3
    assert video.rate == pytest.approx(rate)


@pytest.mark.parametrize("rate", [0.0, -5.0, float("nan"), float("inf")])
def test_a_rate_that_is_none_becomes_the_usual_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rate: float
) -> None:
    class Capture:
        def __init__(self, source: str) -> None:
            self.left = 2

        def get(self, name: int) -> float:
            return rate if name == 5 else 0.0  # CAP_PROP_FPS

        def read(self) -> tuple[bool, np.ndarray]:
            self.left -= 1
            return self.left >= 0, np.zeros((4, 4, 3), np.uint8)

        def release(self) -> None: ...

    monkeypatch.setattr("cv2.VideoCapture", Capture)
    (tmp_path / "it.mp4").touch()
    video = Video(tmp_path / "it.mp4")
    assert len(list(video.images())) == 2
    assert video.rate == 25.0


def test_a_folder_gives_the_endings_that_a_path_may_have(tmp_path: Path) -> None:
    for name in ("a.gif", "b.tiff", "c.TIF", "d.png"):
        PIL.Image.new("RGB", (6, 4)).save(tmp_path / name)
    (tmp_path / "notes.txt").touch()
    assert [source.stem for source in find_sources(tmp_path)] == ["a", "b", "c", "d"]


@pytest.mark.parametrize("number", ["0", "97", "9999"])
def test_a_short_number_is_a_camera(number: str) -> None:
    (source,) = find_sources(Path(number))
    assert source.name == f"camera{number}"


@pytest.mark.parametrize("text", ["\u00b2", "\u0663", "99999999999999", "10000", "-1", "1.5"])
def test_what_looks_like_a_number_and_is_none_of_a_camera_is_bad_input(text: str) -> None:
    with pytest.raises(BadInputError, match=rf"^{text} does not exist; .* camera number of at most 4 digits"):
        find_sources(Path(text))
