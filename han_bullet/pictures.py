"""Find pedestrians in picture files: what `han-bullet detect` does."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.detector import load_detector
from han_bullet.detection.threads import use_one_thread
from han_bullet.errors import BadInputError
from han_bullet.geometry import Intrinsics
from han_bullet.messages import Detections, Frame

ENDINGS = {".jpg", ".jpeg", ".png", ".bmp", ".webp", ".ppm"}
HEADER = ("image", "x", "y", "width", "height", "score", "probability")
BOX_COLOUR = (80, 200, 60)  # BGR


def find_pictures(paths: Sequence[Path]) -> list[Path]:
    """Return the picture files among the paths and in the folders among them, sorted.

    Raises:
        BadInputError: A path does not exist, or there is no picture at all.
    """
    pictures: list[Path] = []
    for path in paths:
        if path.is_dir():
            pictures += sorted(p for p in path.iterdir() if p.suffix.lower() in ENDINGS)
        elif path.is_file():
            pictures.append(path)
        else:
            raise BadInputError(f"picture {str(path)!r} does not exist")
    if not pictures:
        raise BadInputError(f"no picture ({', '.join(sorted(ENDINGS))}) in {', '.join(map(str, paths))}")
    return pictures


def read_picture(path: Path) -> NDArray[np.uint8]:
    """Return a picture as RGB, shape (height, width, 3).

    Raises:
        BadInputError: The file is no picture.
    """
    picture: Any = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if picture is None:
        raise BadInputError(f"{path} is not a picture that OpenCV can read")
    rgb: NDArray[np.uint8] = np.ascontiguousarray(picture[:, :, ::-1])
    return rgb


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
            detections = detector.detect([_frame_of(path, image)])[0]
            for box, score, probability in zip(
                detections.boxes, detections.scores, detections.probabilities, strict=True
            ):
                writer.writerow([path, *(f"{v:.2f}" for v in box), f"{score:.3f}", f"{probability:.4f}"])
            file.flush()
            cv2.imwrite(str(folder / f"{path.stem}.png"), _drawn(image, detections)[:, :, ::-1])
            found += len(detections.boxes)
    return found


def _frame_of(path: Path, image: NDArray[np.uint8]) -> Frame:
    """Wrap a picture whose camera nobody knows."""
    height, width = image.shape[:2]
    intrinsics = Intrinsics.from_vertical_field_of_view(width, height, 1.0)
    return Frame(str(path), 0.0, image, intrinsics, np.eye(4), fixed=False)


def _drawn(image: NDArray[np.uint8], detections: Detections) -> NDArray[np.uint8]:
    picture = image.copy()
    for (x, y, width, height), score in zip(detections.boxes, detections.scores, strict=True):
        corner, opposite = (round(x), round(y)), (round(x + width), round(y + height))
        cv2.rectangle(picture, corner, opposite, BOX_COLOUR[::-1], 2, cv2.LINE_AA)
        cv2.putText(picture, f"{score:.0f}", corner, cv2.FONT_HERSHEY_SIMPLEX, 0.5, BOX_COLOUR[::-1], 1, cv2.LINE_AA)
    return picture
