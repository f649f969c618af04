"""A calibration as a value and as a file: round trip, what is refused, and the picture of it."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from floor_points import CAMERAS, floor_points, tilted_camera

from han_bullet.calibration.calibration import Calibration, check_name
from han_bullet.calibration.lens import Distortion
from han_bullet.calibration.picture import GRID, draw
from han_bullet.calibration.points import MarkedPoints
from han_bullet.errors import BadInputError
from han_bullet.geometry import Intrinsics, project

CAMERA = CAMERAS[0]
POINTS = floor_points(CAMERA.intrinsics, CAMERA.camera_in_world, 8, np.random.default_rng(0), noise=1.0)
LENS = Distortion("plumb_bob", np.array([-0.2, 0.05, 0.0, 0.0, 0.0]))
CALIBRATION = Calibration("hall", CAMERA.intrinsics, CAMERA.camera_in_world, LENS, POINTS)


def written(folder: Path, **changes: object) -> Path:
    """The file of CALIBRATION with some fields changed; None takes one away."""
    path = folder / "hall.yaml"
    CALIBRATION.save(path, "a remark")
    document = yaml.safe_load(path.read_text()) | changes
    path.write_text(yaml.safe_dump({name: value for name, value in document.items() if value is not None}))
    return path


def test_a_calibration_comes_back_from_its_file_bit_for_bit(tmp_path: Path) -> None:
    path = tmp_path / "hall.yaml"
    for calibration in (CALIBRATION, replace(CALIBRATION, distortion=None), replace(CALIBRATION, name="other")):
        calibration.save(path, "a remark")
        assert path.read_text().startswith("# a remark\nname: ")
        back = Calibration.load(path)
        assert back.name == calibration.name and back.intrinsics == calibration.intrinsics
        assert np.array_equal(back.camera_in_world, calibration.camera_in_world)
        assert back.points.rows() == calibration.points.rows()
        assert (back.distortion is None) == (calibration.distortion is None)
        if back.distortion is not None:
            assert back.distortion.model == "plumb_bob"
            assert np.array_equal(back.distortion.coefficients, LENS.coefficients)
    assert [file.name for file in tmp_path.iterdir()] == ["hall.yaml"]


def test_the_file_holds_homography_and_errors_for_other_programs(tmp_path: Path) -> None:
    document = yaml.safe_load(written(tmp_path).read_text())
    place = np.array(document["homography_pixel_to_floor"]) @ [*CALIBRATION.marked()[2], 1.0]
    off = np.linalg.norm(place[:2] / place[2] - POINTS.points_in_world[2, :2])
    assert document["errors"]["points_m"][2] == pytest.approx(off, abs=1e-4)
    assert document["errors"]["worst_px"] == pytest.approx(CALIBRATION.pixel_errors().max())
    assert document["errors"]["rms_px"] == pytest.approx(math.sqrt(np.mean(CALIBRATION.pixel_errors() ** 2)))
    assert len(document["points"]) == 8 and set(document["points"][0]) == set("uvxyz")


def test_a_file_that_a_person_wrote_needs_only_lens_and_place(tmp_path: Path) -> None:
    nothing = {"distortion": None, "homography_pixel_to_floor": None, "errors": None, "points": None}
    back = Calibration.load(written(tmp_path, **nothing))
    assert len(back.points) == 0 and back.distortion is None
    assert np.array_equal(back.camera_in_world, CAMERA.camera_in_world)


POSE = CAMERA.camera_in_world.tolist()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": "my hall"}, "name of the camera is 'my hall'"),
        ({"name": 3}, "name of the camera is 3"),
        ({"size": [640]}, r"size is \[640\]; \[width, height\]"),
        ({"size": [640, True]}, "size is"),
        ({"intrinsics": {"fx": 500.0}}, "fx, fy, cx, cy would be right"),
        ({"intrinsics": {"fx": -500.0, "fy": 500.0, "cx": 1.0, "cy": 1.0}}, "positive focal lengths"),
        ({"intrinsics": {"fx": math.nan, "fy": 500.0, "cx": 1.0, "cy": 1.0}}, "fx is nan"),
        ({"camera_in_world": None}, "name, size, intrinsics, camera_in_world and at most"),
        ({"camera_in_world": POSE[:3]}, "4 x 4 finite numbers"),
        ({"camera_in_world": [[2.0, 0, 0, 0], *POSE[1:]]}, "is no pose"),
        ({"camera_in_world": [[-v for v in POSE[0]], *POSE[1:]]}, "is no pose"),
        ({"camera_in_world": [*POSE[:2], [*POSE[2][:3], -2.6], POSE[3]]}, "at z -2.6 m; above the floor"),
        ({"camera_in_world": [[0.0, *POSE[0][1:3], 0.5], *POSE[1:]]}, "homography_pixel_to_floor is not that of"),
        ({"homography_pixel_to_floor": [[1.0]]}, "3 x 3 finite numbers"),
        ({"distortion": {"model": "best", "coefficients": [0.0]}}, "distortion model is 'best'; plumb_bob"),
        ({"distortion": {"model": "plumb_bob", "coefficients": [0.1]}}, "4 or 5 numbers would be right"),
        ({"distortion": "none"}, "model and coefficients would be right"),
        ({"points": [{"u": 1}]}, "point 1 has u; u, v, x, y"),
        ({"colour": "red"}, "holds .*colour"),
    ],
)
def test_what_is_no_calibration_is_refused_with_file_and_field(
    tmp_path: Path, changes: dict[str, object], message: str
) -> None:
    with pytest.raises(BadInputError, match=message) as refused:
        Calibration.load(written(tmp_path, **changes))
    assert str(refused.value).startswith(f"calibration {tmp_path / 'hall.yaml'}: ")


@pytest.mark.parametrize("text", ["[", "3", "\x00"])
def test_a_file_that_is_no_mapping_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "hall.yaml").write_text(text)
    with pytest.raises(BadInputError, match=r"hall.yaml: (not readable|holds)"):
        Calibration.load(tmp_path / "hall.yaml")
    with pytest.raises(BadInputError, match="No such file"):
        Calibration.load(tmp_path / "none.yaml")


def test_names_of_cameras_are_those_that_worlds_may_give() -> None:
    assert check_name("camera1_left") == "camera1_left"
    for bad in ("1st", "", "a-b", "a\n"):
        with pytest.raises(BadInputError):
            check_name(bad)


def test_the_error_on_the_floor_is_that_of_the_ray_at_the_points_height() -> None:
    lens = Intrinsics.from_vertical_field_of_view(640, 480, 1.0)
    pose = tilted_camera(2.0, math.radians(30.0))
    for height in (0.0, 1.0):
        pixel, _ = project(np.array([[4.0, 0.0, height]]), lens, pose)
        points = MarkedPoints(pixel, np.array([[4.2, 0.0, height]]))
        assert Calibration("c", lens, pose, points=points).floor_errors() == pytest.approx([0.2], abs=1e-9)
    sky = MarkedPoints(np.array([[320.0, 0.0]]), np.array([[4.0, 0.0, 0.0]]))
    level = replace(Calibration("c", lens, tilted_camera(2.0, 0.01), points=sky))
    assert np.isnan(level.floor_errors()[0])


def test_the_view_is_told_as_yaw_tilt_and_turn_and_by_the_floor_in_its_middle() -> None:
    lens = Intrinsics.from_vertical_field_of_view(640, 480, 1.0)
    camera = Calibration("c", lens, tilted_camera(2.0, math.radians(45.0), math.radians(10.0)))
    assert np.degrees(camera.view_angles()) == pytest.approx([0.0, 45.0, 10.0])
    assert camera.looked_at() == pytest.approx([2.0, 0.0])
    assert Calibration("c", lens, tilted_camera(2.0, -0.1)).looked_at() is None
    # Turned clockwise, a camera's image is turned counter-clockwise: what is to its right is higher up.
    right, left = (project(np.array([2.0, side, 0.0]), lens, camera.camera_in_world)[0] for side in (-0.5, 0.5))
    assert right[1] < left[1]


def test_the_picture_has_the_grid_where_the_floor_is() -> None:
    image = np.full((480, 640, 3), 90, np.uint8)
    calibration = replace(CALIBRATION, distortion=None)
    picture = draw(image, calibration)
    assert picture.shape == image.shape and np.all(image == 90)
    share = (picture.astype(float) - 90.0) / (np.array(GRID) - 90.0)  # of the grid's colour in each channel
    blue = (share.min(axis=-1) > 0.2) & (np.ptp(share, axis=-1) < 0.1)
    on_line, _ = project(np.array([[7.0, y, 0.0] for y in (-0.6, 0.4, 0.6)]), CAMERA.intrinsics, CAMERA.camera_in_world)
    between, _ = project(np.array([[6.6, 0.45, 0.0]]), CAMERA.intrinsics, CAMERA.camera_in_world)
    for u, v in np.floor(on_line).astype(int):
        assert blue[v - 1 : v + 2, u].any()
    u, v = np.floor(between[0]).astype(int)
    assert not blue[v - 3 : v + 4, u].any()
    assert not blue[:74].any()  # the horizon is at row 76
