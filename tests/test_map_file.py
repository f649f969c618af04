"""Maps as map_server's YAML and PGM: what is written, read and refused."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from han_bullet.errors import BadInputError
from han_bullet.localization.map_file import read_map, write_map
from han_bullet.localization.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid

DESCRIPTION = {
    "image": "map.pgm",
    "resolution": 0.1,
    "origin": [-1.0, 2.0, 0.0],
    "negate": 0,
    "occupied_thresh": 0.65,
    "free_thresh": 0.196,
}


def described(folder: Path, picture: bytes, **changed: object) -> Path:
    """A map of a picture, its description changed; None leaves a key out."""
    (folder / "map.pgm").write_bytes(picture)
    document = {key: value for key, value in (DESCRIPTION | changed).items() if value is not None}
    (folder / "map.yaml").write_text(yaml.safe_dump(document))
    return folder / "map.yaml"


def test_a_map_that_is_written_and_read_again_is_the_same(tmp_path: Path) -> None:
    cells = np.random.default_rng(0).choice(np.array([FREE, OCCUPIED, UNKNOWN], np.int8), (7, 11))
    write_map(OccupancyGrid(cells, np.array([-3.25, 1.5]), 0.05), tmp_path / "floor.yaml")
    grid = read_map(tmp_path / "floor.yaml")
    assert (grid.cells == cells).all()
    assert grid.origin_in_world.tolist() == [-3.25, 1.5] and grid.resolution == 0.05


def test_a_file_that_is_read_and_written_again_holds_the_same_picture(tmp_path: Path) -> None:
    picture = b"P5\n3 2\n255\n" + bytes([0, 205, 254, 254, 0, 205])
    write_map(read_map(described(tmp_path, picture)), tmp_path / "again.yaml")
    assert (tmp_path / "again.pgm").read_bytes() == picture


def test_the_uppermost_row_of_the_picture_is_the_one_with_the_largest_y(tmp_path: Path) -> None:
    grid = read_map(described(tmp_path, b"P5 2 3 255\n" + bytes([0, 254, 254, 254, 254, 254])))
    rows, columns = np.nonzero(grid.cells == OCCUPIED)
    x, y = grid.centres()
    assert x[0, columns[0]] == pytest.approx(-0.95) and y[rows[0], 0] == pytest.approx(2.25)


def test_remarks_in_the_header_are_passed_over(tmp_path: Path) -> None:
    grid = read_map(described(tmp_path, b"P5\n# CREATOR: map_saver 0.050 m/pix\n2 1\n255\n" + bytes([0, 254])))
    assert grid.cells.tolist() == [[OCCUPIED, FREE]]


@pytest.mark.parametrize(
    ("changed", "cells"),
    [
        ({}, [OCCUPIED, UNKNOWN, UNKNOWN, FREE]),
        ({"mode": "scale"}, [OCCUPIED, UNKNOWN, UNKNOWN, FREE]),
        ({"negate": 1}, [FREE, UNKNOWN, OCCUPIED, OCCUPIED]),
        ({"occupied_thresh": 0.4}, [OCCUPIED, OCCUPIED, UNKNOWN, FREE]),
        ({"free_thresh": 0.3}, [OCCUPIED, UNKNOWN, FREE, FREE]),
    ],
)
def test_thresholds_and_negate_decide_what_a_grey_means(
    tmp_path: Path, changed: dict[str, object], cells: list[int]
) -> None:
    grid = read_map(described(tmp_path, b"P5 4 1 255 " + bytes([0, 130, 200, 255]), **changed))
    assert grid.cells.tolist() == [cells]


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"resolution": 0.0}, "resolution is 0.0 m"),
        ({"resolution": "fine"}, "resolution is 'fine'"),
        ({"resolution": float("nan")}, "resolution is nan"),
        ({"origin": [0.0, 0.0]}, r"origin is \[0.0, 0.0\]"),
        ({"origin": [0.0, 0.0, 0.5]}, "yaw of 0.5"),
        ({"negate": None}, "negate is None"),
        ({"mode": "raw"}, "mode is 'raw'"),
        ({"free_thresh": 0.7}, "free_thresh is 0.7"),
        ({"image": None}, "image is None"),
        ({"image": "other.pgm"}, "not readable"),
    ],
)
def test_a_bad_description_is_told_by_its_field(tmp_path: Path, changed: dict[str, object], told: str) -> None:
    with pytest.raises(BadInputError, match=told):
        read_map(described(tmp_path, b"P5 2 1 255 ab", **changed))


@pytest.mark.parametrize(
    ("picture", "told"),
    [
        (b"\x89PNG\r\n", "no PGM file"),
        (b"P5" + 4000 * b" ", "no PGM file"),
        (b"P5 2 2 255 abc", "has 3 of 4 pixels"),
        (b"P5 100000 100000 255 abc", "100000 x 100000 pixels"),
        (b"P5 2 1 65535 abcd", "white at 65535"),
        (b"P5 0 1 255 ", "0 x 1 pixels"),
    ],
)
def test_a_bad_picture_is_told_before_anything_is_allocated(tmp_path: Path, picture: bytes, told: str) -> None:
    with pytest.raises(BadInputError, match=told):
        read_map(described(tmp_path, picture))


@pytest.mark.parametrize("text", ["- a list", "a: [", "!!python/object/apply:os.getcwd []"])
def test_what_is_no_mapping_or_would_run_something_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "map.yaml").write_text(text)
    with pytest.raises(BadInputError, match=r"map\.yaml"):
        read_map(tmp_path / "map.yaml")


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match=r"none\.yaml"):
        read_map(tmp_path / "none.yaml")
