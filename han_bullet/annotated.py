"""Annotated copies of images: boxes with their scores, written as pictures or as an H.264 video."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path

import cv2
import imageio_ffmpeg
import numpy as np

from han_bullet.atomic_file import write_at_once
from han_bullet.detection.pictures import Image
from han_bullet.errors import HanError
from han_bullet.messages import Detections

BOX_COLOUR, TEXT_COLOUR = (60, 200, 80), (0, 0, 0)
FONT, FONT_SCALE = cv2.FONT_HERSHEY_SIMPLEX, 0.5
LABEL_MARGIN = 3  # [px] of the label's ground around its text
# Quick enough to keep up with the loop on a core of its own; +faststart lets a browser play it before it is all loaded.
ENCODER = ["-preset", "veryfast", "-crf", "23", "-movflags", "+faststart"]


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


class AnnotatedVideo:
    """An H.264 video under way; whole once it is closed.

    Args:
        path: Ending in .mp4.
        rate: Pictures per second.
    """

    def __init__(self, path: Path, rate: float) -> None:
        self._path, self._rate = path, rate
        self._writer: Generator[None, Image | None, None] | None = None

    def write(self, picture: Image) -> None:
        """Add an RGB picture; an odd side is lengthened by a pixel, as the format wants.

        Raises:
            HanError: The encoder has died.
        """
        height, width = picture.shape[:2]
        even = np.pad(picture, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
        try:
            if self._writer is None:
                self._writer = imageio_ffmpeg.write_frames(
                    str(self._path),
                    (even.shape[1], even.shape[0]),
                    fps=self._rate,
                    codec="libx264",
                    quality=None,
                    macro_block_size=2,
                    output_params=ENCODER,
                )
                self._writer.send(None)
            self._writer.send(np.ascontiguousarray(even))
        except OSError as error:
            raise HanError(f"video {str(self._path)!r}: the encoder died; is the disk full?") from error

    def close(self) -> None:
        """Let the encoder finish the file."""
        if self._writer is not None:
            self._writer.close()
            self._writer = None
