"""Files of marked points, and points that cannot tell where a camera is."""

from pathlib import Path

import numpy as np
import pytest

from han_bullet.calibration.points import MarkedPoints, check_points, read_points, write_points
from han_bullet.errors import BadInputError

ROWS = [[310.5, 402.25, 3.0, 0.0, 0.0], [100.0, 300.0, 6.0, 1.5, 0.0], [500.0, 310.0, 6.0, -1.5, 0.2]]
SQUARE = [[100.0, 100.0, 0.0, 0.0, 0.0], [200, 100, 1, 0, 0], [200, 200, 1, 1, 0], [110, 210, 0, 1, 0]]


def test_points_come_back_from_their_file(tmp_path: Path) -> None:
    path = tmp_path / "hall.csv"
    write_points(MarkedPoints.of_rows(ROWS), path)
    assert read_points(path).rows() == ROWS
    assert read_points(path).without(1).rows() == [ROWS[0], ROWS[2]]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", "u,v,x,y\n310.5,402.25,3,0\n100,300,6,1.5\n"),
        ("a.csv", "\ufeff# by hand\n\nu, v, x, y, z\n310.5, 402.25, 3, 0, 0\n# next\n100, 300, 6, 1.5, 0\r\n"),
        ("a.yaml", "- {u: 310.5, v: 402.25, x: 3, y: 0}\n- {u: 100, v: 300, x: 6, y: 1.5, z: 0}\n"),
        ("a.yml", "name: hall\npoints:\n- {u: 310.5, v: 402.25, x: 3.0, y: 0}\n- {u: 100, v: 300, x: 6, y: 1.5}\n"),
    ],
)
def test_each_form_of_file_is_read(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    assert read_points(tmp_path / name).rows() == ROWS[:2]


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.csv", "", "the first line is ''; u,v,x,y or u,v,x,y,z would be right"),
        ("a.csv", "310,402,3,0\n", "the first line is '310,402,3,0'"),
        ("a.csv", "u,v,y,x\n1,2,3,4\n", "the first line is 'u,v,y,x'"),
        ("a.csv", "u,v,x,y\n1,2,3,4\n1,2,3\n", "point 2 has 3 values; 4 would be right: u,v,x,y"),
        ("a.csv", "u,v,x,y\n1,2,three,4\n", "point 1: x is 'three'; a finite number"),
        ("a.csv", "u,v,x,y\n1,nan,3,4\n", "point 1: v is 'nan'; a finite number"),
        ("a.csv", "u,v,x,y\n1,2,3,inf\n", "point 1: y is 'inf'"),
        ("a.yaml", "- {u: 1, v: 2, x: 3, y: .nan}\n", "point 1: y is nan"),
        ("a.yaml", "- {u: 1, v: 2, x: 3, y: true}\n", "point 1: y is True"),
        ("a.yaml", "- {u: 1, v: 2, x: 3, y: [4]}\n", r"point 1: y is \[4\]"),
        ("a.yaml", "- {u: 1, v: 2, x: 3}\n", "point 1 has u, v, x; u, v, x, y and, above the floor, z"),
        ("a.yaml", "- {u: 1, v: 2, x: 3, y: 4, w: 5}\n", "point 1 has u, v, x, y, w"),
        ("a.yaml", "- 7\n", "point 1 has 7"),
        ("a.yaml", "colour: red\n", "no list of points"),
        ("a.yaml", "[", "not readable"),
        ("a.csv", None, "not readable: .*No such file"),
    ],
)
def test_what_is_no_file_of_points_is_refused_with_file_and_row(
    tmp_path: Path, name: str, text: str | None, message: str
) -> None:
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(BadInputError, match=message) as refused:
        read_points(tmp_path / name)
    assert str(refused.value).startswith(f"points {tmp_path / name}: ")


def test_the_corners_of_a_square_can_tell_a_camera() -> None:
    check_points(MarkedPoints.of_rows(SQUARE), (640, 480))


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (SQUARE[:3], "3 points are marked; 4 to 1000 would be right"),
        ([*SQUARE, [641.0, 100.0, 5, 5, 0]], "point 5 is marked at u 641, v 100, outside the image of 640 x 480 px"),
        ([*SQUARE, [-1.0, 100.0, 5, 5, 0]], "point 5 is marked at u -1"),
        ([*SQUARE, [100.0, 100.0, 5, 5, 0]], r"points 1 and 5 have the same pixel \(100, 100\)"),
        ([*SQUARE, [300.0, 100.0, 1, 1, 0]], r"points 3 and 5 have the same place \(1, 1, 0\)"),
        (
            [[100.0 + 50 * i, 100.0 + i * i, i, 2.0 * i, 0] for i in range(5)],
            "all 5 points lie on one line on the floor",
        ),
        ([[100.0 + 50 * i, 200.0, i, i * i, 0] for i in range(5)], "all 5 points lie on one line in the image"),
    ],
)
def test_points_that_cannot_tell_a_camera_are_refused(rows: list[list[float]], message: str) -> None:
    with pytest.raises(BadInputError, match=message):
        check_points(MarkedPoints.of_rows(rows), (640, 480))


def test_points_hold_rows_apart_as_pixels_and_places() -> None:
    points = MarkedPoints.of_rows(ROWS)
    assert len(points) == 3 and len(MarkedPoints.of_rows([])) == 0
    assert np.array_equal(points.pixels[2], [500.0, 310.0])
    assert np.array_equal(points.points_in_world[2], [6.0, -1.5, 0.2])
