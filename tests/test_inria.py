"""Both layouts of the INRIA photographs, on made-up folders."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from han_bullet.detection.inria import load_test_photographs, photographs_note, train_backgrounds, train_people
from han_bullet.errors import BadInputError

ANNOTATION = """# PASCAL Annotation Version 1.00

Image filename : "Test/pos/{name}.png"
Image size (X x Y x C) : 1060 x 605 x 3
Database : "The INRIA Rhône-Alpes Annotated Person Database"
Objects with ground truth : 2 {{ "PASperson" "PASperson" }}

# Top left pixel co-ordinates : ({origin}, {origin})

# Details for object 1 ("PASperson")
Original label for object 1 "PASperson" : "UprightPerson"
Center point on object 1 "PASperson" (X, Y) : (281, 169)
Bounding box for object 1 "PASperson" (Xmin, Ymin) - (Xmax, Ymax) : (250, 151) - (299, 294)

# Details for object 2 ("PASperson")
Bounding box for object 2 "PASperson" (Xmin, Ymin) - (Xmax, Ymax) : (215, 354) - (274, 466)
"""


def picture(file: Path) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(file), np.zeros((8, 8, 3), np.uint8))


def distribution(root: Path, origin: int = 0) -> Path:
    """Make a folder as the distribution has it, with one test photograph."""
    picture(root / "Test" / "pos" / "crop001501.png")
    picture(root / "96X160H96" / "Train" / "pos" / "a.png")
    picture(root / "Train" / "neg" / "b.jpg")
    (root / "Test" / "annotations").mkdir()
    text = ANNOTATION.format(name="crop001501", origin=origin)
    (root / "Test" / "annotations" / "crop001501.txt").write_text(text, encoding="latin-1")
    return root


def own(root: Path, document: object) -> Path:
    picture(root / "inria" / "test" / "a.jpg")
    (root / "inria" / "gt.json").write_text(json.dumps(document), encoding="utf-8")
    return root


@pytest.mark.parametrize("inside", ["", "INRIAPerson"])
def test_the_distribution_is_read_from_the_folder_or_from_the_one_that_holds_it(tmp_path: Path, inside: str) -> None:
    root = distribution(tmp_path / inside)
    (image,) = load_test_photographs(tmp_path)
    assert image.path == root / "Test" / "pos" / "crop001501.png"
    assert image.boxes.tolist() == [[250.0, 151.0, 49.0, 143.0], [215.0, 354.0, 59.0, 112.0]]
    assert image.ignored.shape == (0, 4)
    assert [path.name for path in train_people(tmp_path)] == ["a.png"]
    assert [path.name for path in train_backgrounds(tmp_path)] == ["b.jpg"]


def test_an_annotation_that_counts_from_one_is_moved_by_one_pixel(tmp_path: Path) -> None:
    distribution(tmp_path, origin=1)
    assert load_test_photographs(tmp_path)[0].boxes[0].tolist() == [249.0, 150.0, 49.0, 143.0]


def test_both_layouts_give_the_same_box(tmp_path: Path) -> None:
    distribution(tmp_path / "theirs")
    own(tmp_path / "ours", {"a.jpg": {"boxes_xyxy": [[250, 151, 299, 294], [215, 354, 274, 466]]}})
    ours, theirs = (load_test_photographs(tmp_path / name)[0].boxes for name in ("ours", "theirs"))
    assert np.array_equal(ours, theirs)


def test_the_note_tells_how_many_photographs_were_rebuilt(tmp_path: Path) -> None:
    own(tmp_path / "ours", {"a.jpg": {"boxes_xyxy": [[0, 0, 9, 9]], "image": "inpainted"}})
    distribution(tmp_path / "theirs")
    ours, theirs = (photographs_note(tmp_path / n, load_test_photographs(tmp_path / n)) for n in ("ours", "theirs"))
    assert "1 INRIA test photographs with 1 people (the published set: 288 and 589); 1 of them rebuilt" in ours
    assert "rebuilt" not in theirs


def test_training_pictures_of_the_own_layout_are_found(tmp_path: Path) -> None:
    picture(tmp_path / "inria" / "train_pos" / "p.png")
    picture(tmp_path / "inria" / "train_neg" / "n.png")
    assert (train_people(tmp_path)[0].name, train_backgrounds(tmp_path)[0].name) == ("p.png", "n.png")


@pytest.mark.parametrize(
    "text",
    [
        "[]",
        "{}",
        '{"a.jpg": {}}',
        '{"a.jpg": []}',
        "not json",
        '{"a.jpg": {"boxes_xyxy": [[1, 2]]}}',
        '{"a.jpg": {"boxes_xyxy": [[1, 2], [3, 4]]}}',
        '{"a.jpg": {"boxes_xyxy": {}}}',
        '{"a.jpg": {"boxes_xyxy": ""}}',
        '{"a.jpg": {"boxes_xyxy": null}}',
        '{"a.jpg": {"boxes_xyxy": [[0, 0, 9, 1%s]]}}' % ("0" * 400),
        '{"a.jpg": {"boxes_xyxy": ' + "[" * 100_000 + "]" * 100_000 + "}}",
    ],
    ids=lambda text: text[:40],
)
def test_a_malformed_list_of_people_is_bad_input(tmp_path: Path, text: str) -> None:
    own(tmp_path, {})
    (tmp_path / "inria" / "gt.json").write_text(text, encoding="utf-8")
    with pytest.raises(BadInputError, match=r"gt\.json") as caught:
        load_test_photographs(tmp_path)
    assert len(str(caught.value)) < 400


def test_a_photograph_without_people_has_an_empty_list(tmp_path: Path) -> None:
    own(tmp_path, {"a.jpg": {"boxes_xyxy": []}})
    assert load_test_photographs(tmp_path)[0].boxes.shape == (0, 4)


@pytest.mark.parametrize("box", [[9, 0, 9, 9], [9, 0, 3, 9], [0, 0, float("nan"), 9]])
def test_a_box_without_an_area_is_bad_input(tmp_path: Path, box: list[float]) -> None:
    own(tmp_path, {"a.jpg": {"boxes_xyxy": [box]}})
    with pytest.raises(BadInputError, match=r"a\.jpg: boxes must have x0 < x1"):
        load_test_photographs(tmp_path)


def test_a_photograph_that_is_listed_and_missing_is_bad_input(tmp_path: Path) -> None:
    own(tmp_path, {"b.jpg": {"boxes_xyxy": [[0, 0, 9, 9]]}})
    with pytest.raises(BadInputError, match=r"b\.jpg is missing"):
        load_test_photographs(tmp_path)


def test_a_missing_folder_and_one_with_neither_layout_are_bad_input(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match="nowhere' does not exist"):
        load_test_photographs(tmp_path / "nowhere")
    for load in (load_test_photographs, train_people, train_backgrounds):
        with pytest.raises(BadInputError, match="neither inria/ nor INRIAPerson/"):
            load(tmp_path)


def test_an_annotation_that_is_missing_or_of_another_format_is_bad_input(tmp_path: Path) -> None:
    file = distribution(tmp_path) / "Test" / "annotations" / "crop001501.txt"
    file.write_text("1 0.5 0.5 0.1 0.2\n")
    with pytest.raises(BadInputError, match=r"crop001501\.txt has no line"):
        load_test_photographs(tmp_path)
    file.unlink()
    with pytest.raises(BadInputError, match=r"crop001501\.txt, the annotation of crop001501\.png, cannot be read"):
        load_test_photographs(tmp_path)
