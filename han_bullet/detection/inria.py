"""Where the INRIA person photographs lie [Dalal2005]: this project's own layout of them and the distribution's.

| what | own layout | the distribution, in INRIAPerson/ |
|---|---|---|
| test photographs | inria/test | Test/pos |
| the people in them | inria/gt.json | Test/annotations |
| crops of people for training | inria/train_pos | 96X160H96/Train/pos |
| person-free photographs for training | inria/train_neg | Train/neg |

Where a folder holds both, its own layout counts.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from han_bullet.detection.evaluation import LabelledImage
from han_bullet.detection.pictures import list_pictures
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array

PUBLISHED_PHOTOGRAPHS, PUBLISHED_PEOPLE = 288, 589  # of the test set that published figures are about
_ORIGIN = re.compile(r"Top left pixel co-ordinates : \((\d+), (\d+)\)")
_BOX = re.compile(r'Bounding box for object \d+ "[^"]*" .*: \((\d+), (\d+)\) - \((\d+), (\d+)\)')


def load_test_photographs(data: Path) -> list[LabelledImage]:
    """Return the INRIA test photographs of a data folder, in the order of their names.

    Raises:
        BadInputError: If the folder has neither layout, or a file is missing or malformed.
    """
    if _own_layout(data):
        images = _from_list(data / "inria" / "gt.json")
    else:
        root = _distribution(data, "Test/pos")
        images = [_from_annotation(photograph, root) for photograph in list_pictures(root / "Test" / "pos")]
    for image in images:
        _check(image)
    return images


def photographs_note(data: Path, images: Sequence[LabelledImage]) -> str:
    """Return the sentence about its photographs that belongs beside every figure from a data folder."""
    people = sum(len(image.boxes) for image in images)
    note = f"{len(images)} INRIA test photographs with {people} people"
    if (len(images), people) != (PUBLISHED_PHOTOGRAPHS, PUBLISHED_PEOPLE):
        note += f" (the published set: {PUBLISHED_PHOTOGRAPHS} and {PUBLISHED_PEOPLE})"
    entries = json.loads((data / "inria" / "gt.json").read_text(encoding="utf-8")) if _own_layout(data) else {}
    rebuilt = sum(entry.get("image") == "inpainted" for entry in entries.values())
    if rebuilt:
        note += f"; {rebuilt} of them rebuilt from copies with thin drawn lines, which were inpainted"
    return note


def train_people(data: Path) -> list[Path]:
    """Return the crops of people, 96 x 160 px, the person 96 px high in the middle.

    Raises:
        BadInputError: If there are none.
    """
    if _own_layout(data):
        return list_pictures(data / "inria" / "train_pos")
    return list_pictures(_distribution(data, "96X160H96/Train/pos") / "96X160H96" / "Train" / "pos")


def train_backgrounds(data: Path) -> list[Path]:
    """Return the photographs without people.

    Raises:
        BadInputError: If there are none.
    """
    if _own_layout(data):
        return list_pictures(data / "inria" / "train_neg")
    return list_pictures(_distribution(data, "Train/neg") / "Train" / "neg")


def _own_layout(data: Path) -> bool:
    if not data.is_dir():
        raise BadInputError(f"data folder {str(data)!r} does not exist; give the one with inria/ or INRIAPerson/ in it")
    return (data / "inria").is_dir()


def _distribution(data: Path, needed: str) -> Path:
    """Return the distribution's folder, which holds the one needed."""
    for root in (data / "INRIAPerson", data):
        if (root / needed).is_dir():
            return root
    raise BadInputError(f"data folder {str(data)!r} has neither inria/ nor INRIAPerson/{needed}/ in it")


def _from_list(file: Path) -> list[LabelledImage]:
    """Read the own layout's list, image -> boxes_xyxy."""
    try:
        entries = json.loads(file.read_text(encoding="utf-8"))
        images = [
            LabelledImage(file.parent / "test" / name, _from_corners(entry["boxes_xyxy"]))
            for name, entry in sorted(entries.items())
        ]
    except (OSError, ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise BadInputError(f"{file} must map names to boxes_xyxy, lists of x0, y0, x1, y1: {reason}") from error
    if not images:
        raise BadInputError(f"{file} names no photograph")
    return images


def _from_annotation(photograph: Path, root: Path) -> LabelledImage:
    """Read the annotation of one of the distribution's photographs.

    It says where it counts from: (0, 0) in INRIA's files, (1, 1) in others of the PASCAL format. As in Dollár's
    evaluation, a box is as wide as the difference of its corners.
    """
    file = root / "Test" / "annotations" / f"{photograph.stem}.txt"
    try:
        text = file.read_text(encoding="latin-1")
    except OSError as error:
        raise BadInputError(f"{file}, the annotation of {photograph.name}, cannot be read: {error.strerror}") from error
    origin = _ORIGIN.search(text)
    corners = np.array([[int(value) for value in box] for box in _BOX.findall(text)], float).reshape(-1, 4)
    if origin is None:
        raise BadInputError(f"{file} has no line 'Top left pixel co-ordinates : (0, 0)'; is it of the PASCAL format?")
    return LabelledImage(photograph, _from_corners(corners - np.tile([int(value) for value in origin.groups()], 2)))


def _from_corners(corners: Array | list[list[float]]) -> Array:
    """Return x, y, width, height of boxes given by two corners."""
    if not isinstance(corners, list | np.ndarray):
        raise TypeError(f"boxes are a {type(corners).__name__}, not a list")
    boxes = np.asarray(corners, float) if len(corners) else np.empty((0, 4))
    if boxes.ndim != 2 or boxes.shape[1] != 4:
        raise ValueError(f"boxes of shape {boxes.shape}")
    return np.column_stack([boxes[:, :2], boxes[:, 2:] - boxes[:, :2]])


def _check(image: LabelledImage) -> None:
    """Refuse what would otherwise be noticed late or not at all."""
    if not image.path.is_file():
        raise BadInputError(f"test photograph {image.path} is missing")
    if not (np.isfinite(image.boxes).all() and (image.boxes[:, 2:] > 0.0).all()):
        raise BadInputError(f"test photograph {image.path}: boxes must have x0 < x1 and y0 < y1, all finite")
