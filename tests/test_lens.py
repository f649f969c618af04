"""Lens distortion and ROS's camera_info files."""

from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.calibration.lens import Distortion, read_camera_info
from han_bullet.errors import BadInputError
from han_bullet.geometry import Intrinsics

LENS = Intrinsics(640, 480, 420.0, 430.0, 330.5, 235.5)
DISTORTIONS = (
    Distortion("plumb_bob", np.array([-0.28, 0.09, 1e-3, -5e-4, -0.01])),
    Distortion("plumb_bob", np.array([-0.1, 0.01, 0.0, 0.0])),
    Distortion("rational_polynomial", np.array([-0.15, 0.02, 1e-3, 1e-3, 0.001, 0.05, -0.01, 0.001])),
    Distortion("equidistant", np.array([-0.02, 0.005, -0.002, 0.0])),
)
FILE = {
    "image_width": 640,
    "image_height": 480,
    "camera_name": "hall",
    "camera_matrix": {"rows": 3, "cols": 3, "data": [420.0, 0, 330.0, 0, 430.0, 235.0, 0, 0, 1]},
    "distortion_model": "plumb_bob",
    "distortion_coefficients": {"rows": 1, "cols": 5, "data": [-0.28, 0.09, 0.001, -0.0005, -0.01]},
}
TOPIC = """\
header:
  seq: 1
  frame_id: "hall"
height: 480
width: 640
distortion_model: "plumb_bob"
D: [-0.28, 0.09, 0.001, -0.0005, -0.01]
K: [420.0, 0.0, 330.0, 0.0, 430.0, 235.0, 0.0, 0.0, 1.0]
---
header:
"""


@pytest.mark.parametrize("distortion", DISTORTIONS, ids=lambda d: f"{d.model}{len(d.coefficients)}")
@given(u=st.floats(0.0, 640.0), v=st.floats(0.0, 480.0))
def test_distorting_an_undistorted_pixel_gives_it_again(distortion: Distortion, u: float, v: float) -> None:
    pixel = np.array([[u, v]])
    assert distortion.distort(distortion.undistort(pixel, LENS), LENS) == pytest.approx(pixel, abs=1e-3)


@pytest.mark.parametrize("distortion", DISTORTIONS, ids=lambda d: f"{d.model}{len(d.coefficients)}")
def test_a_dot_of_an_image_moves_to_where_its_pixel_is_undistorted(distortion: Distortion) -> None:
    image = np.zeros((480, 640, 3), np.uint8)
    image[100:103, 150:153] = 255  # its middle is at u 151.5, v 101.5
    straight = distortion.undistort_image(image, LENS)[:, :, 0].astype(float)
    rows, columns = np.indices(straight.shape) + 0.5
    middle = [(columns * straight).sum() / straight.sum(), (rows * straight).sum() / straight.sum()]
    moved = distortion.undistort(np.array([[151.5, 101.5]]), LENS)[0]
    assert np.linalg.norm(moved - [151.5, 101.5]) > 0.8
    assert middle == pytest.approx(moved, abs=0.25)


def test_a_pixel_that_the_coefficients_do_not_describe_is_refused() -> None:
    folds = Distortion("plumb_bob", np.array([-0.6, 0.0, 0.0, 0.0, 0.0]))
    with pytest.raises(BadInputError, match=r"cannot be undone at u 639, v 479; mark points nearer the middle"):
        folds.undistort(np.array([[320.0, 240.0], [639.0, 479.0]]), LENS)


def test_file_and_topic_of_ros_say_the_same_half_a_pixel_aside(tmp_path: Path) -> None:
    (tmp_path / "file.yaml").write_text(yaml.safe_dump(FILE))
    (tmp_path / "topic.yaml").write_text(TOPIC)
    for name in ("file.yaml", "topic.yaml"):
        intrinsics, distortion = read_camera_info(tmp_path / name)
        assert intrinsics == LENS  # ROS counts from the first pixel's middle, we from its corner
        assert distortion is not None and distortion.model == "plumb_bob"
        assert np.array_equal(distortion.coefficients, DISTORTIONS[0].coefficients)
    matrix = np.array(FILE["camera_matrix"]["data"]).reshape(3, 3)  # type: ignore[index]
    theirs, _ = cv2.projectPoints(np.array([[0.3, 0.2, 1.0]]), np.zeros(3), np.zeros(3), matrix, None)
    ours = LENS.matrix @ [0.3, 0.2, 1.0]
    assert theirs.ravel() + 0.5 == pytest.approx(ours[:2])


def test_a_lens_of_zeros_has_no_distortion(tmp_path: Path) -> None:
    for coefficients in ([0.0] * 5, []):
        (tmp_path / "info.yaml").write_text(yaml.safe_dump(FILE | {"distortion_coefficients": {"data": coefficients}}))
        assert read_camera_info(tmp_path / "info.yaml")[1] is None


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"image_width": "640"}, "image_width is '640'; a whole number of pixels"),
        ({"image_height": 0}, "image_height is 0"),
        ({"camera_matrix": {"data": [1.0]}}, r"camera_matrix is \[1.0\]; \[fx, 0, cx"),
        ({"camera_matrix": {"data": [420.0, 5.0, 330.0, 0, 430.0, 235.0, 0, 0, 1]}}, r"\[fx, 0, cx"),
        ({"camera_matrix": {"data": [0.0, 0.0, 330.0, 0, 430.0, 235.0, 0, 0, 1]}}, r"\[fx, 0, cx"),
        ({"camera_matrix": {"data": [float("nan")] * 9}}, "a list of finite numbers would be right"),
        ({"camera_matrix": None}, "camera_matrix is None"),
        ({"distortion_model": "fancy"}, "distortion model is 'fancy'; plumb_bob, rational_polynomial, equidistant"),
        ({"distortion_coefficients": {"data": [0.1, 0.2]}}, "4 or 5 numbers would be right for plumb_bob"),
    ],
)
def test_what_is_no_camera_info_is_refused_with_file_and_field(
    tmp_path: Path, changes: dict[str, object], message: str
) -> None:
    path = tmp_path / "info.yaml"
    path.write_text(yaml.safe_dump(FILE | changes))
    with pytest.raises(BadInputError, match=message) as refused:
        read_camera_info(path)
    assert str(refused.value).startswith(f"camera_info {path}: ")


@pytest.mark.parametrize("text", ["[", "", "- 1"])
def test_text_that_is_no_mapping_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "info.yaml").write_text(text)
    with pytest.raises(BadInputError, match=r"info.yaml: (not readable|holds)"):
        read_camera_info(tmp_path / "info.yaml")
