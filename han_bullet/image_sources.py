"""Where images come from: picture files, folders of them, videos, a camera of this machine."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np

from han_bullet.detection.pictures import ENDINGS, Image, check_picture, read_picture
from han_bullet.errors import BadInputError

VIDEO_ENDINGS = frozenset({".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v", ".mpg", ".mpeg"})
MOST_DIGITS = 4  # of a camera's number
USUAL_RATE = 25.0  # [1/s] of a video that does not tell its own


class ImageSource(ABC):
    """One thing to look at, with one image or many.

    Attributes:
        name: What a person calls it.
        stem: For the file of its annotated copy.
    """

    name: str
    stem: str

    @abstractmethod
    def images(self) -> Iterator[tuple[str, Image]]:
        """Give each image, RGB, with its own name.

        Raises:
            BadInputError: The source, or what is left of it, cannot be read.
        """


class PictureFile(ImageSource):
    """A file with one picture."""

    def __init__(self, path: Path) -> None:
        self.name, self.stem, self._path = str(path), path.stem, path

    def images(self) -> Iterator[tuple[str, Image]]:
        """Give the picture, turned as its EXIF data say."""
        check_picture(self._path)
        yield self.name, read_picture(self._path)


class Video(ImageSource):
    """A video file, or the camera with a number."""

    def __init__(self, source: Path | int) -> None:
        camera = isinstance(source, int)
        self.name = f"camera{source}" if camera else str(source)
        self.stem = self.name if camera else Path(self.name).stem
        self._source = source if isinstance(source, int) else str(source)
        self.rate = USUAL_RATE  # [1/s], known once the first image has come
        self.length: int | None = None  # images, where the file tells

    def images(self) -> Iterator[tuple[str, Image]]:
        """Give frame after frame, named name#000000 and on."""
        if isinstance(self._source, str):
            with open(self._source, "rb"):  # OpenCV does not say why it cannot
                pass
        level = cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
        capture = cv2.VideoCapture(self._source)
        try:
            rate, length = capture.get(cv2.CAP_PROP_FPS), int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
            self.rate = rate if math.isfinite(rate) and rate > 0.0 else USUAL_RATE
            self.length = length if length > 0 else None
            count = 0
            while True:
                there, picture = capture.read()
                if not there:
                    break
                yield f"{self.name}#{count:06d}", np.ascontiguousarray(picture[:, :, ::-1])
                count += 1
        finally:
            capture.release()
            cv2.utils.logging.setLogLevel(level)
        if count == 0:
            kind = "video" if isinstance(self._source, str) else "camera"
            raise BadInputError(f"{self.name} is not a {kind} that OpenCV can read")
        if self.length is not None and count < self.length:
            raise BadInputError(f"{self.name} ends after {count} of {self.length} frames; it is damaged from there on")


def find_sources(path: Path) -> Sequence[ImageSource]:
    """Return what a path names: a picture, a video, the pictures and videos of a folder by name, or a camera's number.

    Raises:
        BadInputError: Nothing is there.
    """
    if path.is_dir():
        endings = ENDINGS | VIDEO_ENDINGS
        files = sorted(file for file in path.iterdir() if file.suffix.lower() in endings and not file.is_dir())
        if not files:
            raise BadInputError(f"no picture or video ({', '.join(sorted(endings))}) in {path}")
        return [_file(file) for file in files]
    if path.exists():
        return [_file(path)]
    number = str(path)
    if number.isascii() and number.isdigit() and len(number) <= MOST_DIGITS:
        return [Video(int(number))]
    raise BadInputError(
        f"{path} does not exist; a picture, video, folder or camera number of at most {MOST_DIGITS} digits would be "
        "right"
    )


def _file(path: Path) -> ImageSource:
    return Video(path) if path.suffix.lower() in VIDEO_ENDINGS else PictureFile(path)
