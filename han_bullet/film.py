"""Films: pictures one after the other, written as an H.264 video."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path

import imageio_ffmpeg
import numpy as np

from han_bullet.detection.pictures import Image
from han_bullet.errors import HanError

# Quick enough to keep up with the loop on a core of its own; +faststart lets a browser play it before it is all loaded.
ENCODER = ["-preset", "veryfast", "-crf", "23", "-movflags", "+faststart"]


class Film:
    """An H.264 video under way; whole once it is closed.

    Args:
        path: Ending in .mp4; an older file is replaced.
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
        if height % 2 or width % 2:
            picture = np.pad(picture, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
        try:
            if self._writer is None:
                self._writer = imageio_ffmpeg.write_frames(
                    str(self._path),
                    (picture.shape[1], picture.shape[0]),
                    fps=self._rate,
                    codec="libx264",
                    quality=None,
                    macro_block_size=2,
                    output_params=ENCODER,
                )
                self._writer.send(None)
            self._writer.send(np.ascontiguousarray(picture))
        except OSError as error:
            raise HanError(f"video {str(self._path)!r}: the encoder died; is the disk full?") from error

    def close(self) -> None:
        """Let the encoder finish the file."""
        if self._writer is not None:
            self._writer.close()
            self._writer = None
