"""Lenses that bend straight lines: what ROS's camera_info files say of one, and pixels and images without it.

OpenCV and ROS count pixels from the middle of the first one, han_bullet from its corner; so principal points differ by
half a pixel, and only this module knows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml

from han_bullet.detection.pictures import Image
from han_bullet.errors import BadInputError, quoted
from han_bullet.geometry import Array, Intrinsics

FISHEYE = "equidistant"
COEFFICIENTS = {"plumb_bob": (4, 5), "rational_polynomial": (8,), FISHEYE: (4,)}  # how many each model may have
HALF = 0.5  # [px]
PRECISION = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-12)
AGREEMENT = 0.1  # [px] within which distorting an undistorted pixel must give it again


@dataclass(frozen=True)
class Distortion:
    """A lens distortion as ROS and OpenCV write it.

    Attributes:
        model: One of COEFFICIENTS.
        coefficients: Shape (k,).

    Raises:
        BadInputError: There is no such model, or it has another number of coefficients.
    """

    model: str
    coefficients: Array

    def __post_init__(self) -> None:
        if self.model not in COEFFICIENTS:
            raise BadInputError(f"distortion model is {self.model!r}; {', '.join(COEFFICIENTS)} would be right")
        counts = COEFFICIENTS[self.model]
        if self.coefficients.shape not in {(count,) for count in counts} or not np.isfinite(self.coefficients).all():
            right = " or ".join(map(str, counts))
            raise BadInputError(
                f"distortion coefficients are {self.coefficients.tolist()}; {right} numbers would be right for "
                f"{self.model}"
            )

    def undistort(self, pixels: Array, intrinsics: Intrinsics) -> Array:
        """Return where pixels, (n, 2) [px], are in the image of a lens without distortion, shape (n, 2) [px].

        Raises:
            BadInputError: A pixel is so far out that the coefficients do not describe it.
        """
        matrix, marked = _opencv_matrix(intrinsics), (pixels - HALF)[:, None]
        if self.model == FISHEYE:
            straight = cv2.fisheye.undistortPoints(marked, matrix, self.coefficients, P=matrix, criteria=PRECISION)
        else:
            straight = cv2.undistortPointsIter(marked, matrix, self.coefficients, np.eye(3), matrix, PRECISION)
        undistorted: Array = np.asarray(straight, float)[:, 0] + HALF
        off = np.linalg.norm(self.distort(undistorted, intrinsics) - pixels, axis=1)
        for (u, v), lost in zip(pixels.tolist(), ~(off < AGREEMENT), strict=True):
            if lost:
                raise BadInputError(
                    f"the distortion of the lens cannot be undone at u {u:g}, v {v:g}; mark points nearer the middle"
                )
        return undistorted

    def distort(self, pixels: Array, intrinsics: Intrinsics) -> Array:
        """Return where pixels, (n, 2) [px], of an image without distortion are in the lens's own, shape (n, 2) [px]."""
        matrix = _opencv_matrix(intrinsics)
        rays = np.column_stack([pixels - HALF, np.ones(len(pixels))]) @ np.linalg.inv(matrix).T
        nothing = np.zeros(3)
        project = cv2.fisheye.projectPoints if self.model == FISHEYE else cv2.projectPoints
        bent, _ = project(rays[:, None], nothing, nothing, matrix, self.coefficients)
        distorted: Array = np.asarray(bent, float)[:, 0] + HALF
        return distorted

    def undistort_image(self, image: Image, intrinsics: Intrinsics) -> Image:
        """Return an image as a lens without distortion and with the same intrinsics would show it."""
        matrix = _opencv_matrix(intrinsics)
        if self.model == FISHEYE:
            return np.asarray(cv2.fisheye.undistortImage(image, matrix, self.coefficients, Knew=matrix), np.uint8)
        return np.asarray(cv2.undistort(image, matrix, self.coefficients), np.uint8)


def _opencv_matrix(intrinsics: Intrinsics) -> Array:
    matrix = intrinsics.matrix
    matrix[:2, 2] -= HALF
    return matrix


def read_camera_info(path: Path) -> tuple[Intrinsics, Distortion | None]:
    """Read a ROS camera_info: the YAML file of camera_calibration, or what `rostopic echo` prints of the topic.

    Raises:
        BadInputError: It is missing or not what it should be; the message has file and field.
    """
    try:
        document = next(yaml.safe_load_all(path.read_text(encoding="utf-8")), None)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise BadInputError(f"camera_info {path}: not readable as YAML: {quoted(error)}") from error
    if not isinstance(document, dict):
        raise BadInputError(f"camera_info {path}: holds {type(document).__name__}, not fields such as camera_matrix")
    width, height = (_pixels(document, name, path) for name in ("width", "height"))
    matrix = _numbers(document, "camera_matrix", "K", path)
    if matrix.shape != (9,) or not (matrix[0] > 0.0 and matrix[4] > 0.0) or matrix[[1, 3, 6, 7]].any():
        raise BadInputError(
            f"camera_info {path}: camera_matrix is {matrix.tolist()}; [fx, 0, cx, 0, fy, cy, 0, 0, 1] would be right"
        )
    fx, _, cx, _, fy, cy = matrix[:6].tolist()
    intrinsics = Intrinsics(width, height, fx, fy, cx + HALF, cy + HALF)
    coefficients = _numbers(document, "distortion_coefficients", "D", path)
    if not coefficients.any():
        return intrinsics, None
    try:
        return intrinsics, Distortion(str(document.get("distortion_model")), coefficients)
    except BadInputError as error:
        raise BadInputError(f"camera_info {path}: {error}") from error


def _pixels(document: dict[str, Any], name: str, path: Path) -> int:
    value = document.get(f"image_{name}", document.get(name))
    if not isinstance(value, int) or isinstance(value, bool) or value <= 0:
        raise BadInputError(f"camera_info {path}: image_{name} is {value!r}; a whole number of pixels would be right")
    return value


def _numbers(document: dict[str, Any], name: str, topic_name: str, path: Path) -> Array:
    """Return the numbers of a field, shape (n,), as files (`data` in a mapping) or topics (a list) have it."""
    value = document.get(name, document.get(topic_name))
    data = value.get("data") if isinstance(value, dict) else value
    right = isinstance(data, list) and all(isinstance(v, int | float) and math.isfinite(v) for v in data)
    if not right:
        raise BadInputError(f"camera_info {path}: {name} is {value!r}; a list of finite numbers would be right")
    return np.array(data, float)
