"""Annotated copies of images: boxes with their scores, and pictures as files."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from han_bullet.atomic_file import write_at_once
from han_bullet.detection.pictures import Image
from han_bullet.messages import Detections

BOX_COLOUR, TEXT_COLOUR = (60, 200, 80), (0, 0, 0)
FONT, FONT_SCALE = cv2.FONT_HERSHEY_SIMPLEX, 0.5
LABEL_MARGIN = 3  # [px] of the label's ground around its text


def annotate(image: Image, detections: Detections) -> Image:
    """Return a copy of an RGB image with boxes and scores."""
    picture = image.copy()
    for (x, y, width, height), score in zip(detections.boxes, detections.scores, strict=True):
        corner, opposite = (round(x), round(y)), (round(x + width), round(y + height))
        cv2.rectangle(picture, corner, opposite, BOX_COLOUR, 2, cv2.LINE_AA)
        text = f"{score:.0f}" if abs(score) >= 10.0 else f"{score:.2f}"
        _label(picture, text, corner)
    return picture


def _label(picture: Image, text: str, corner: tuple[int, int]) -> None:
    """Write a text on a ground of the box's colour, on top of the box or, where there is no room, inside it."""
    (width, height), _ = cv2.getTextSize(text, FONT, FONT_SCALE, 1)
    left, bottom = corner[0], max(corner[1], height + 2 * LABEL_MARGIN)
    right, top = left + width + 2 * LABEL_MARGIN, bottom - height - 2 * LABEL_MARGIN
    cv2.rectangle(picture, (left - 1, top), (right, bottom), BOX_COLOUR, cv2.FILLED)
    cv2.putText(
        picture, text, (left + LABEL_MARGIN, bottom - LABEL_MARGIN), FONT, FONT_SCALE, TEXT_COLOUR, 1, cv2.LINE_AA
    )


def write_picture(folder: Path, stem: str, picture: Image) -> None:
    """Write a PNG at once, under a name that no file of this run or of the user has."""
    encoded = cv2.imencode(".png", np.ascontiguousarray(picture[:, :, ::-1]))[1]
    write_at_once(unused_name(folder, stem, ".png"), encoded.tobytes())


def unused_name(folder: Path, stem: str, ending: str) -> Path:
    """Return a name for an annotated copy that is not taken yet."""
    names = (folder / f"{stem}_boxes{number}{ending}" for number in ("", *range(2, 1_000_000)))
    return next(name for name in names if not name.exists())
