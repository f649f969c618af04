"""A picture from the middle of a video, shown until it plays, and on paper."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import cv2
import imageio_ffmpeg
import numpy as np

WIDTH = 1280  # [px]
QUALITY = 85  # of the JPEG, in per cent


def middle_picture(video: Path) -> bytes | None:
    """Return a JPEG file of a video's middle, or None where it cannot be read."""
    try:
        with closing(imageio_ffmpeg.read_frames(str(video))) as reader:
            duration = next(reader)["duration"]
        with closing(imageio_ffmpeg.read_frames(str(video), input_params=["-ss", f"{0.5 * duration:.2f}"])) as reader:
            width, height = next(reader)["size"]
            frame = np.frombuffer(next(reader), np.uint8).reshape(height, width, 3)
    except (OSError, RuntimeError, StopIteration, KeyError, ValueError):
        return None
    small = cv2.resize(frame, (WIDTH, round(height * WIDTH / width)), interpolation=cv2.INTER_AREA)
    done, content = cv2.imencode(".jpg", small[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return content.tobytes() if done else None
