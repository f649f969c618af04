"""`han-bullet detect` as a person meets it: what is refused, shown on the way, and how watching a camera ends."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from rich.progress import Progress

from han_bullet.cli import main
from han_bullet.detection.pedestrian_detector import PedestrianDetector
from han_bullet.film import Film
from han_bullet.messages import Detections


class FakeCamera:
    """A camera with grey pictures, during whose third one somebody presses Ctrl-C."""

    def __init__(self, source: object) -> None:
        self.count = 0

    def get(self, what: int) -> float:
        return 0.0

    def read(self) -> tuple[bool, np.ndarray]:
        self.count += 1
        assert self.count <= 3
        if self.count == 3:
            os.kill(os.getpid(), signal.SIGINT)
        return True, np.full((120, 160, 3), 90, np.uint8)

    def release(self) -> None:
        pass


def write_video(path: Path, frames: int) -> None:
    video = Film(path, 25.0)
    for _ in range(frames):
        video.write(np.full((120, 160, 3), 90, np.uint8))
    video.close()


def test_watching_a_camera_ends_with_ctrl_c_the_summary_and_whole_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    before = signal.getsignal(signal.SIGINT)
    with monkeypatch.context() as patched:
        patched.setattr(cv2, "VideoCapture", FakeCamera)
        assert main(["detect", "0", "--out", "out"]) == 0
    assert "0 people in 3 images; results in out/" in capsys.readouterr().out
    copy = cv2.VideoCapture(str(tmp_path / "out" / "camera0_boxes.mp4"))
    assert copy.get(cv2.CAP_PROP_FRAME_COUNT) == 3
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.parametrize(("video", "total"), [(True, None), (False, 2)], ids=["a video among them", "pictures alone"])
def test_the_bar_has_a_total_only_where_each_source_is_one_image(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, video: bool, total: int | None
) -> None:
    sources = tmp_path / "sources"
    sources.mkdir()
    for name in ("a.png", "b.png"):
        assert cv2.imwrite(str(sources / name), np.full((120, 160, 3), 90, np.uint8))
    if video:
        write_video(sources / "c.mp4", 4)
    totals: list[object] = []
    monkeypatch.setattr(Progress, "update", lambda bar, task, **changes: totals.append(changes["total"]))
    assert main(["detect", str(sources), "--out", str(tmp_path / "out")]) == 0
    assert totals == [total] * (6 if video else 2)


def test_results_in_place_of_a_file_are_refused_before_the_model_is_looked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    assert main(["detect", "x.png", "--model", "nowhere", "--out", str(tmp_path / "file")]) == 2
    assert "file' is a file; a folder would be right" in capsys.readouterr().err


def test_a_broken_video_is_one_line_without_those_of_opencv(tmp_path: Path) -> None:
    whole = tmp_path / "whole.mp4"
    write_video(whole, 4)
    (tmp_path / "half.mp4").write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    (tmp_path / "text.avi").write_text("no video")
    arguments = ["detect", "half.mp4", "text.avi", "--out", "out"]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("OPENCV_")}
    code = "import sys; from han_bullet.cli import main; sys.exit(main(sys.argv[1:]))"
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        f"han-bullet: {name} is not a video that OpenCV can read" for name in ("half.mp4", "text.avi")
    ]


def test_a_frame_is_named_as_the_help_says_by_the_path_as_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "videos").mkdir()
    write_video(tmp_path / "videos" / "clip.mp4", 1)
    monkeypatch.chdir(tmp_path)
    everybody = Detections(np.ones((1, 4)), np.ones(1), np.ones(1))
    monkeypatch.setattr(PedestrianDetector, "detect", lambda detector, image: everybody)
    assert main(["detect", "videos/clip.mp4", "--out", "out"]) == 0
    row = (tmp_path / "out" / "detections.csv").read_text().splitlines()[1]
    assert row.split(",")[0] == "videos/clip.mp4#000000"
    with pytest.raises(SystemExit):
        main(["detect", "--help"])
    assert "by the path as given: videos/clip.mp4#000123" in capsys.readouterr().out
