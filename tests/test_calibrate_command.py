"""`han-bullet calibrate` as a person meets it, up to a rendered image of the building with marks on its floor."""

import re
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from floor_points import CAMERAS, floor_points

from han_bullet.calibration.calibration import Calibration
from han_bullet.calibration.points import MarkedPoints, read_points, write_points
from han_bullet.cli import main
from han_bullet.geometry import project
from han_bullet.sim.renderer import Renderer
from han_bullet.world_file import load_world
from han_bullet.world_schema import Furniture

CAMERA = CAMERAS[0]
SIDE, THICK = 0.16, 0.004  # [m] of a mark on the floor
PLACES = [(4.2, -0.9), (4.2, 0.8), (5.0, 0.1), (6.0, -1.2), (6.5, 1.1), (7.5, -0.4), (9.0, -1.1), (9.0, 1.0)]
CAMERA_INFO = {
    "image_width": 640,
    "image_height": 480,
    "camera_matrix": {"data": [CAMERA.intrinsics.fx, 0, 319.5, 0, CAMERA.intrinsics.fy, 239.5, 0, 0, 1]},
    "distortion_model": "plumb_bob",
    "distortion_coefficients": {"data": [0.0] * 5},
}


@pytest.fixture
def points(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """points.csv of camera1 in the current folder."""
    monkeypatch.chdir(tmp_path)
    write_points(
        floor_points(CAMERA.intrinsics, CAMERA.camera_in_world, 8, np.random.default_rng(1)), Path("points.csv")
    )
    return Path("points.csv")


def complaint(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(["calibrate", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("han-bullet: ") and captured.err.count("\n") == 1
    assert "Traceback" not in captured.err + captured.out
    return captured.err


def bare_and_marked() -> tuple[np.ndarray, np.ndarray]:
    """What camera1 sees of the empty corridor, without and with thin square marks on its floor."""
    world = load_world("real2").model_copy(update={"people": (), "image_noise": 0.0})
    marks = tuple(
        Furniture(name=f"mark{number}", position=place, size=(SIDE, SIDE, THICK), texture="screen_on")
        for number, place in enumerate(PLACES)
    )
    pictures = []
    for furniture in (world.furniture, world.furniture + marks):
        renderer = Renderer(world.model_copy(update={"furniture": furniture}), seed=0)
        pictures.append(renderer.calibration_image("camera1").copy())
        renderer.close()
    return pictures[0], pictures[1]


def middles_of_marks(bare: np.ndarray, marked: np.ndarray) -> np.ndarray:
    """The middles of the marks [px] in the order of PLACES: from near to far, of two abreast the right one first."""
    changed = np.any(bare != marked, axis=-1).astype(np.uint8)
    count, _, _, middles = cv2.connectedComponentsWithStats(changed)
    assert count == len(PLACES) + 1
    middles = middles[1:] + 0.5
    order = np.lexsort((-middles[:, 0], -np.round(middles[:, 1] / 5.0)))
    return np.asarray(middles[order])


def test_a_rendered_camera_is_found_again_from_marks_on_its_floor(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    bare, marked = bare_and_marked()
    middles = middles_of_marks(bare, marked)
    write_points(MarkedPoints.of_rows([[*m, *p, 0.0] for m, p in zip(middles, PLACES, strict=True)]), Path("p.csv"))
    assert cv2.imwrite("hall.png", marked[:, :, ::-1])
    assert main(["calibrate", "hall.png", "--points", "p.csv", "--out", "c/hall.yaml", "--picture", "g.png"]) == 0
    calibration = Calibration.load(Path("c/hall.yaml"))
    assert calibration.name == "hall" and calibration.pixel_errors().max() < 0.5
    assert calibration.intrinsics.fx == pytest.approx(CAMERA.intrinsics.fx, rel=0.01)
    assert np.linalg.norm(calibration.camera_in_world[:3, 3] - CAMERA.position) < 0.05
    assert calibration.camera_in_world[:3, :3] == pytest.approx(CAMERA.camera_in_world[:3, :3], abs=0.005)
    drawn = cv2.imread("g.png")
    assert drawn.shape == marked.shape and np.any(drawn != marked[:, :, ::-1])
    assert main(["calibrate", "hall.png", "--points", "p.csv", "--field-of-view", "45", "--out", "hall2.yaml"]) == 0
    known = Calibration.load(Path("hall2.yaml"))
    assert np.linalg.norm(known.camera_in_world[:3, 3] - CAMERA.position) < 0.01
    assert "in the middle is the floor at x 9.3" in capsys.readouterr().out  # the world's camera: 9.38


def test_points_alone_are_enough_where_the_size_is_given(points: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["calibrate", "--points", "points.csv", "--size", "640x480", "--out", "hall.yaml"]) == 0
    text = capsys.readouterr().out
    assert "position: x 0.20 ± 0." in text and "2.60 ± 0." in text and "m above the floor" in text
    assert "view: 0.0 degrees from x towards y, 15.8 degrees down, turned 0.0 degrees" in text
    assert "focal length: 579.4 ± " in text and "solved from the points for square pixels" in text
    assert "reprojection error: 0.00 px RMS; worst 0.00 px" in text
    assert sum(line.startswith("│ ") for line in text.splitlines()) == 8
    assert Calibration.load(Path("hall.yaml")).camera_in_world == pytest.approx(CAMERA.camera_in_world, abs=1e-6)
    assert main(["calibrate", "--points", "hall.yaml", "--size", "640x480"]) == 0  # its own points, once more


@pytest.mark.parametrize(
    "option", [("--field-of-view", "45"), ("--focal", "579.41125"), ("--camera-matrix", "info.yaml")]
)
def test_each_way_to_give_the_focal_length_gives_the_same_camera(
    points: Path, option: tuple[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    Path("info.yaml").write_text(yaml.safe_dump(CAMERA_INFO))
    assert main(["calibrate", "--points", str(points), "--size", "640x480", *option, "--out", "hall.yaml"]) == 0
    assert "focal length: 579.4 px, as given; vertical field of view 45.0 degrees" in capsys.readouterr().out
    assert Calibration.load(Path("hall.yaml")).camera_in_world == pytest.approx(CAMERA.camera_in_world, abs=1e-6)


def test_a_wrong_point_is_named_as_a_question(points: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = read_points(points).rows()
    rows[4][0] += 43.0 if rows[4][0] < 320.0 else -43.0
    write_points(MarkedPoints.of_rows(rows), points)
    assert main(["calibrate", "--points", str(points), "--size", "640x480", "--field-of-view", "45"]) == 0
    text = capsys.readouterr().out
    assert "point 5 is off by 43 px; measured or typed wrong? It was left out: the others have 0.00 px RMS" in text


def test_clicked_points_are_kept_in_the_file(points: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert cv2.imwrite("hall.png", np.full((480, 640, 3), 90, np.uint8))
    whole = read_points(points)
    write_points(whole.without(7), points)
    answers = iter([" ".join(map(str, whole.points_in_world[7]))])

    class Clicked:
        def clicks(self) -> list[tuple[float, float]]:
            return [tuple(whole.pixels[7].tolist())]

        def mark(self, pixel: tuple[float, float], text: str) -> None:
            pass

    monkeypatch.setattr("han_bullet.calibration.clicking.open_clicking", lambda image: Clicked())
    monkeypatch.setattr("builtins.input", lambda question: next(answers))
    assert main(["calibrate", "hall.png", "--points", "points.csv", "--click"]) == 0
    assert read_points(points).rows() == [pytest.approx(row, rel=1e-9) for row in whole.rows()]


SIZE = ("--size", "640x480")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "--points"),
        (("--points", "none.csv", *SIZE), "none.csv: not readable: .*No such file"),
        (("--points", "points.csv"), "the size of the image is not known; give the image, or --size"),
        (("--points", "points.csv", "--size", "640"), "'640' is no size such as 1280x720"),
        (("--points", "points.csv", *SIZE, "--field-of-view", "190"), "'190' is no angle of 1 to 170 degrees"),
        (("--points", "points.csv", *SIZE, "--focal", "nan"), "'nan' is no focal length"),
        (("--points", "points.csv", *SIZE, "--focal", "500", "--field-of-view", "45"), "not allowed with"),
        (("--points", "points.csv", *SIZE, "--camera-matrix", "none.yaml"), "none.yaml: not readable"),
        (("--points", "points.csv", "--size", "641x480", "--camera-matrix", "info.yaml"), "these must agree"),
        (("--points", "points.csv", *SIZE, "--out", "my-hall.yaml"), "name of the camera is 'my-hall'"),
        (("--points", "points.csv", *SIZE, "--out", "hall.txt"), "'hall.txt' is no file that ends in .yaml"),
        (("--points", "points.csv", *SIZE, "--picture", "grid.gif"), "no file that ends in .png or .jpg"),
        (("--points", "points.csv", *SIZE, "--picture", "grid.png"), "--picture needs an image"),
        (("--points", "points.csv", *SIZE, "--click"), "--click needs an image"),
        (("none.png", "--points", "points.csv"), "none.png does not exist"),
        ((".", "--points", "points.csv"), ". is a folder; a picture, video or camera number"),
        (("text.png", "--points", "points.csv"), "text.png is not a picture"),
        (("grey.png", "--points", "points.csv", "--picture", "grey.png"), "grey.png would be overwritten"),
        (("grey.png", "--points", "points.yaml", "--out", "points.yaml"), "points.yaml would be overwritten"),
        (("grey.png", "--points", "points.csv", *SIZE), "64 x 48 px by the image, 640 x 480 px by --size; these must"),
        (("grey.png", "--points", "points.csv"), "outside the image of 64 x 48 px"),
        (("grey.png", "--points", "points.yaml", "--click"), "a name that ends in .csv would be right"),
        (("grey.png", "--points", "points.csv", "--click"), "--click needs a display"),
    ],
)
def test_bad_input_is_one_sentence_and_nothing_is_written(
    points: Path,
    arguments: tuple[str, ...],
    message: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    Path("info.yaml").write_text(yaml.safe_dump(CAMERA_INFO))
    Path("text.png").write_text("no picture")
    assert cv2.imwrite("grey.png", np.full((48, 64, 3), 90, np.uint8))
    before = sorted(path.name for path in Path().iterdir())
    assert re.search(message, complaint(capsys, *arguments))
    assert sorted(path.name for path in Path().iterdir()) == before


def changed(rows: list[list[float]], row: int, column: int, value: float) -> list[list[float]]:
    return [[value if (r, c) == (row, column) else old for c, old in enumerate(line)] for r, line in enumerate(rows)]


def test_points_that_tell_no_camera_are_one_sentence(points: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good = read_points(points).rows()
    behind = [*project(np.array([-1.0, 0.1, 0.0]), CAMERA.intrinsics, CAMERA.camera_in_world)[0], -1.0, 0.1, 0.0]
    behind[1] = max(behind[1], 1.0)
    cases = {
        "3 points are marked; 4 to 1000": good[:3],
        "one line on the floor": [[u, v, x, 2.0 * x, z] for u, v, x, _, z in good],
        "one line in the image": [[u, 2.0 * u / 3.0, x, y, z] for u, _, x, y, z in good],
        "points 1 and 9 have the same pixel": [*good, good[0]],
        "point 4 (u": changed(good, 3, 1, 10.0),
        "point 9 (u": [*good, behind],
        "under the floor": [[u, v, x, -y, z] for u, v, x, y, z in good],
    }
    for message, rows in cases.items():
        write_points(MarkedPoints.of_rows(rows), points)
        assert message in complaint(capsys, "--points", str(points), *SIZE, "--field-of-view", "45")
    points.write_text("u,v,x,y\n1,2,nan,4\n")
    assert "point 1: x is 'nan'; a finite number would be right" in complaint(capsys, "--points", str(points), *SIZE)
