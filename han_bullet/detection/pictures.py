"""Pictures as the detector takes them, RGB: read from files, listed in folders, cut with their border repeated."""

from __future__ import annotations

import struct
import warnings
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import PIL.Image
from numpy.typing import NDArray

from han_bullet.errors import BadInputError

Image = NDArray[np.uint8]
"""RGB, shape (height, width, 3)."""

MOST_PIXELS = 36_000_000  # what a large photograph has; memory grows with it
# Pillow's names of the kinds that are read, whatever a file is called: another, such as EPS, would start a program.
KINDS = ("PNG", "JPEG", "BMP", "WEBP", "PPM", "GIF", "TIFF")
ENDINGS = frozenset({".jpg", ".jpeg", ".png", ".bmp", ".webp", ".ppm", ".gif", ".tif", ".tiff"})


def read_picture(path: Path) -> Image:
    """Return a picture file as RGB, shape (height, width, 3).

    Raises:
        BadInputError: The file is missing or no picture.
    """
    picture: Any = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if picture is None:
        raise BadInputError(f"{path} is not a picture that OpenCV can read")
    return np.ascontiguousarray(picture[:, :, ::-1])


def check_rgb(image: Image) -> None:
    """Make sure that an array is an image as detectors take it.

    Raises:
        BadInputError: It is not (h, w, 3) or not uint8.
    """
    if image.ndim != 3 or image.shape[2] != 3 or image.dtype != np.uint8:
        raise BadInputError(f"image has shape {image.shape} and type {image.dtype}, must be (h, w, 3) and uint8")


def check_picture(path: Path) -> None:
    """Make sure that a picture file is whole and not too large, before its pixels are used.

    OpenCV fills what is missing of a truncated file with grey, and allocates whatever size a file claims.

    Raises:
        BadInputError: The file is missing, no picture, truncated, or has more than MOST_PIXELS.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", PIL.Image.DecompressionBombWarning)  # the limit here is lower
            with PIL.Image.open(path, formats=KINDS) as picture:
                width, height = picture.size
                if width * height <= MOST_PIXELS:
                    picture.load()
                    return
        raise BadInputError(f"{path} has {width} x {height} px; at most {MOST_PIXELS:,} px in all would be right")
    except PIL.Image.DecompressionBombError as error:
        raise BadInputError(f"{path} is too large; at most {MOST_PIXELS:,} px in all would be right") from error
    except PIL.UnidentifiedImageError as error:
        raise BadInputError(f"{path} is not a picture that can be read: it is empty or of another kind") from error
    except OSError as error:
        raise BadInputError(f"{path} cannot be read: {error.strerror or error}") from error
    except (ValueError, SyntaxError, struct.error, EOFError, IndexError) as error:  # Pillow on malformed files
        raise BadInputError(f"{path} is a malformed picture: {error}") from error


def list_pictures(folder: Path) -> list[Path]:
    """Return the picture files of a folder, in the order of their names.

    Raises:
        BadInputError: The folder is missing or holds no picture.
    """
    if not folder.is_dir():
        raise BadInputError(f"{folder} is not a folder; one with pictures would be right")
    pictures = sorted(path for path in folder.iterdir() if path.suffix.lower() in ENDINGS)
    if not pictures:
        raise BadInputError(f"no picture ({', '.join(sorted(ENDINGS))}) in {folder}")
    return pictures


def cut(image: Image, left: int, top: int, right: int, bottom: int) -> Image:
    """Return image[top:bottom, left:right] [px], the border repeated outside."""
    rows = np.clip(np.arange(top, bottom), 0, image.shape[0] - 1)
    columns = np.clip(np.arange(left, right), 0, image.shape[1] - 1)
    return np.take(np.take(image, rows, axis=0), columns, axis=1)
