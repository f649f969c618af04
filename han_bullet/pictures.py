"""Find pedestrians in picture files: what `han-bullet detect` does."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.loading import load_detector
from han_bullet.detection.pictures import list_pictures, read_picture
from han_bullet.detection.threads import use_one_thread
from han_bullet.errors import BadInputError
from han_bullet.messages import Detections

HEADER = ("image", "x", "y", "width", "height", "score", "probability")
BOX_COLOUR = (80, 200, 60)  # BGR


def find_pictures(paths: Sequence[Path]) -> list[Path]:
    """Return the picture files among the paths and in the folders among them, sorted.

    Raises:
        BadInputError: A path does not exist, or a folder holds no picture.
    """
    pictures: list[Path] = []
    for path in paths:
        if not path.exists():
            raise BadInputError(f"picture {str(path)!r} does not exist")
        pictures += list_pictures(path) if path.is_dir() else [path]
    return pictures


def detect_pictures(pictures: Iterable[Path], model: str, threshold: float | None, folder: Path) -> int:
    """Write detections.csv and one picture with boxes per input; return the number of people found."""
    use_one_thread()
    detector = load_detector(model, threshold=threshold)
    folder.mkdir(parents=True, exist_ok=True)
    found = 0
    with (folder / "detections.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(HEADER)
        for path in pictures:
            image = read_picture(path)
            detections = detector.detect(image)
            for box, score, probability in zip(
                detections.boxes, detections.scores, detections.probabilities, strict=True
            ):
                writer.writerow([path, *(f"{v:.2f}" for v in box), f"{score:.3f}", f"{probability:.4f}"])
            file.flush()
            _write_drawn(_unused_name(folder, path.stem), image, detections)
            found += len(detections.boxes)
    return found


def _unused_name(folder: Path, stem: str) -> Path:
    """Return a name for the picture with boxes that no file of this run or of the user has."""
    names = (folder / f"{stem}_boxes{number}.png" for number in ("", *range(2, 1_000_000)))
    return next(name for name in names if not name.exists())


def _write_drawn(path: Path, image: NDArray[np.uint8], detections: Detections) -> None:
    picture = np.ascontiguousarray(image[:, :, ::-1])
    for (x, y, width, height), score in zip(detections.boxes, detections.scores, strict=True):
        corner, opposite = (round(x), round(y)), (round(x + width), round(y + height))
        cv2.rectangle(picture, corner, opposite, BOX_COLOUR, 2, cv2.LINE_AA)
        cv2.putText(picture, f"{score:.0f}", corner, cv2.FONT_HERSHEY_SIMPLEX, 0.5, BOX_COLOUR, 1, cv2.LINE_AA)
    if not cv2.imwrite(str(path), picture):
        raise BadInputError(f"picture {str(path)!r} could not be written; is the folder writable?")
