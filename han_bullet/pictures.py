"""Find people in pictures, videos and a camera's images: what `han-bullet detect` does."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from han_bullet.annotated import annotate, unused_name, write_picture
from han_bullet.detection.detector import Detector
from han_bullet.detection.pictures import Image
from han_bullet.errors import BadInputError
from han_bullet.film import Film
from han_bullet.image_sources import ImageSource, Video
from han_bullet.messages import Detections

HEADER = ("image", "x", "y", "width", "height", "score", "probability")


@dataclass
class Tally:
    """What came of the sources.

    Attributes:
        images: Looked at.
        people: Found in them.
    """

    images: int = 0
    people: int = 0


def detect_sources(
    sources: Iterable[ImageSource],
    detector: Detector,
    folder: Path,
    *,
    complain: Callable[[str], None],
    look: Callable[[ImageSource, Image], None] = lambda source, picture: None,
) -> Tally:
    """Write detections.csv and an annotated copy of every source; one that cannot be read is told and passed over.

    Args:
        sources: To look at.
        detector: Looks at them.
        folder: For the files; made if need be.
        complain: Gets one sentence for each source that cannot be read.
        look: Gets every annotated image.
    """
    tally = Tally()
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "detections.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(HEADER)

        def take(name: str, source: ImageSource, image: Image) -> Image:
            detections = detector.detect(image)
            write_rows(writer, name, detections)
            file.flush()
            tally.images += 1
            tally.people += len(detections.boxes)
            picture = annotate(image, detections)
            look(source, picture)
            return picture

        for source in sources:
            try:
                _annotate_source(source, folder, take)
            except BadInputError as error:
                complain(str(error))
    return tally


def _annotate_source(source: ImageSource, folder: Path, take: Callable[[str, ImageSource, Image], Image]) -> None:
    """Write the annotated copy of one source."""
    if not isinstance(source, Video):
        for name, image in _readable(source):
            write_picture(folder, source.stem, take(name, source, image))
        return
    video: Film | None = None
    try:
        for name, image in _readable(source):
            video = video or Film(unused_name(folder, source.stem, ".mp4"), source.rate)
            video.write(take(name, source, image))
    finally:
        if video is not None:
            video.close()


def _readable(source: ImageSource) -> Iterable[tuple[str, Image]]:
    """Give a source's images; what the system says of its file becomes a sentence."""
    with closing(source.images()) as images:  # type: ignore[type-var]
        while True:
            try:
                found = next(images)
            except StopIteration:
                return
            except OSError as error:
                raise BadInputError(f"{source.name} cannot be read: {error.strerror or error}") from error
            yield found


def write_rows(writer: Any, name: str, detections: Detections) -> None:
    """Write one row per box."""
    columns = (detections.boxes, detections.scores, detections.probabilities)
    for box, score, probability in zip(*columns, strict=True):
        writer.writerow([name, *(f"{v:.2f}" for v in box), f"{score:.3f}", f"{probability:.4f}"])
