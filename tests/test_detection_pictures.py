"""Picture files and cuts of pictures, as the detector and its training take them."""

from pathlib import Path

import cv2
import numpy as np
import PIL.Image
import pytest

from han_bullet.detection.pictures import ENDINGS, check_picture, cut, list_pictures, read_picture
from han_bullet.errors import BadInputError


def test_a_picture_is_read_as_rgb(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "red.png"), np.full((2, 3, 3), (0, 0, 255), np.uint8))  # BGR
    picture = read_picture(tmp_path / "red.png")
    assert picture.shape == (2, 3, 3)
    assert (picture == (255, 0, 0)).all()
    assert picture.flags.c_contiguous


def test_a_missing_file_and_one_that_is_no_picture_are_bad_input_by_name(tmp_path: Path) -> None:
    (tmp_path / "notes.png").write_text("hello")
    for name in ("notes.png", "missing.png"):
        with pytest.raises(BadInputError, match=rf"{name} is not a picture"):
            read_picture(tmp_path / name)


def test_a_folder_gives_its_pictures_in_the_order_of_their_names_and_nothing_else(tmp_path: Path) -> None:
    for name in ("b.JPG", "a.png", "c.jpeg", "notes.txt", "picture"):
        (tmp_path / name).touch()
    assert [path.name for path in list_pictures(tmp_path)] == ["a.png", "b.JPG", "c.jpeg"]


@pytest.mark.parametrize("ending", sorted(ENDINGS))
def test_a_picture_with_any_ending_is_found_in_a_folder_and_read(tmp_path: Path, ending: str) -> None:
    PIL.Image.new("RGB", (6, 4), (200, 100, 50)).save(tmp_path / f"one{ending}")
    (found,) = list_pictures(tmp_path)
    check_picture(found)
    assert read_picture(found) == pytest.approx(np.full((4, 6, 3), (200, 100, 50)), abs=3)


def test_gifs_and_tiffs_count_as_pictures() -> None:
    assert {".gif", ".tif", ".tiff"} < ENDINGS


@pytest.mark.parametrize("name", ["drawing.png", "drawing.eps"])
def test_a_kind_that_would_start_a_program_is_no_picture_whatever_its_name(tmp_path: Path, name: str) -> None:
    PIL.Image.new("RGB", (6, 4)).save(tmp_path / name, format="EPS")
    with pytest.raises(BadInputError, match=rf"{name} is not a picture that can be read"):
        check_picture(tmp_path / name)


def test_a_folder_without_pictures_and_one_that_is_missing_are_bad_input_by_name(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").touch()
    with pytest.raises(BadInputError, match=rf"no picture \(.*\.png.*\) in {tmp_path}"):
        list_pictures(tmp_path)
    with pytest.raises(BadInputError, match="nowhere is not a folder"):
        list_pictures(tmp_path / "nowhere")


def test_a_cut_repeats_the_border_outside() -> None:
    image = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
    assert np.array_equal(cut(image, 1, 0, 3, 2), image[:, 1:3])
    across = cut(image, -2, -1, 6, 3)
    assert across.shape == (4, 8, 3)
    assert np.array_equal(across, np.pad(image, ((1, 1), (2, 2), (0, 0)), mode="edge"))
