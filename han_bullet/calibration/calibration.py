"""`Calibration`: a fixed camera's lens and place, as a value and as a file that other commands read."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from han_bullet.atomic_file import write_at_once
from han_bullet.calibration.lens import Distortion
from han_bullet.calibration.points import MarkedPoints, rows_of_points
from han_bullet.detection.pictures import Image
from han_bullet.errors import BadInputError, quoted
from han_bullet.geometry import Array, Intrinsics, floor_homography, project

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")  # as the cameras of worlds are called
HOMOGRAPHY = "homography_pixel_to_floor"
NEEDED = ("name", "size", "intrinsics", "camera_in_world")
RECORDED = ("distortion", HOMOGRAPHY, "errors", "points")  # may be missing in a file that a person wrote
LENS = ("fx", "fy", "cx", "cy")
FITS = 1e-6  # how far a rotation may be from one, and a homography from that of the camera, relative
LONGEST_VALUE = 80  # characters of a field that is quoted


def _no_points() -> MarkedPoints:
    return MarkedPoints.of_rows([])


@dataclass(frozen=True)
class Calibration:
    """A fixed camera over the floor.

    Attributes:
        name: Of the camera.
        intrinsics: Of its image, once that is undistorted.
        camera_in_world: Its pose, shape (4, 4); columns right, down, along the view, position.
        distortion: Of its lens, None for none.
        points: What it was solved from, as marked in its distorted image; none: it was not.
    """

    name: str
    intrinsics: Intrinsics
    camera_in_world: Array
    distortion: Distortion | None = None
    points: MarkedPoints = field(default_factory=_no_points)

    @property
    def homography(self) -> Array:
        """Return the homography, (3, 3), from undistorted pixels to the floor, as geometry's floor_homography."""
        return floor_homography(self.intrinsics, self.camera_in_world)

    def view_angles(self) -> tuple[float, float, float]:
        """Return the view's yaw, its tilt down and the camera's turn about it, clockwise as it looks [rad]."""
        right, _, view = self.camera_in_world[:3, :3].T
        yaw, down = math.atan2(view[1], view[0]), math.asin(max(-1.0, min(1.0, -view[2])))
        level_right = np.array([math.sin(yaw), -math.cos(yaw), 0.0])
        return yaw, down, math.atan2(float(right @ np.cross(view, level_right)), float(right @ level_right))

    def looked_at(self) -> Array | None:
        """Return the floor point, (2,) [m], in the middle of the view; None above the horizon."""
        lens = self.intrinsics
        places, on_floor = self.on_plane(np.array([[lens.cx, lens.cy]]), np.zeros(1))
        return places[0] if on_floor[0] else None

    def undistort(self, image: Image) -> Image:
        """Return an image of this camera as the pinhole of its intrinsics would show it."""
        return image if self.distortion is None else self.distortion.undistort_image(image, self.intrinsics)

    def marked(self) -> Array:
        """Return where the points are marked, in the undistorted image, shape (n, 2) [px]."""
        pixels = self.points.pixels
        if self.distortion is None or not len(pixels):
            return pixels
        return self.distortion.undistort(pixels, self.intrinsics)

    def reprojected(self) -> Array:
        """Return where this camera should show the points, in the undistorted image, shape (n, 2) [px]."""
        return project(self.points.points_in_world, self.intrinsics, self.camera_in_world)[0]

    def depths(self) -> Array:
        """Return how far before the camera the points are, shape (n,) [m]."""
        return project(self.points.points_in_world, self.intrinsics, self.camera_in_world)[1]

    def pixel_errors(self) -> Array:
        """Return the distances from marked to reprojected points, shape (n,) [px]."""
        errors: Array = np.linalg.norm(self.marked() - self.reprojected(), axis=1)
        return errors

    def floor_errors(self) -> Array:
        """Return how far the marked pixels' rays pass from the points, level with these, shape (n,) [m].

        NaN where a ray does not come down, or up, to its point's height.
        """
        places, in_front = self.on_plane(self.marked(), self.points.points_in_world[:, 2])
        errors: Array = np.linalg.norm(places - self.points.points_in_world[:, :2], axis=1)
        return np.where(in_front, errors, np.nan)

    def on_plane(self, pixels: Array, heights: Array) -> tuple[Array, np.ndarray[Any, np.dtype[np.bool_]]]:
        """Return where rays meet level planes.

        Args:
            pixels: Undistorted, shape (n, 2) [px].
            heights: Of the planes above the floor, shape (n,) [m].

        Returns:
            Places, shape (n, 2) [m], and whether they are in front of the camera, shape (n,); others mean nothing.
        """
        i, pose = self.intrinsics, self.camera_in_world
        rays = np.column_stack([(pixels - (i.cx, i.cy)) / (i.fx, i.fy), np.ones(len(pixels))]) @ pose[:3, :3].T
        level = np.where(np.abs(rays[:, 2]) < 1e-12, np.nan, rays[:, 2])
        along = (heights - pose[2, 3]) / level
        return pose[:2, 3] + along[:, None] * rays[:, :2], along > 0.0

    def save(self, path: Path, remark: str) -> None:
        """Write the file that `load` reads, with a remark, one line, on top."""
        text = yaml.safe_dump(self._document(), sort_keys=False, default_flow_style=None, width=120)
        write_at_once(path, f"# {remark}\n{text}".encode())

    @classmethod
    def load(cls, path: Path) -> Calibration:
        """Read a calibration; its homography and errors must be those of its camera, or missing.

        Raises:
            BadInputError: The file is missing or not what it should be; the message has file and field.
        """
        try:
            document = yaml.safe_load(path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
            raise BadInputError(f"calibration {path}: not readable as YAML: {quoted(error)}") from error
        try:
            return cls._of_document(document)
        except BadInputError as error:
            raise BadInputError(f"calibration {path}: {error}") from error

    @classmethod
    def _of_document(cls, document: Any) -> Calibration:
        if not isinstance(document, dict) or not set(NEEDED) <= set(document) <= {*NEEDED, *RECORDED}:
            fields = ", ".join(map(str, document)) if isinstance(document, dict) else type(document).__name__
            raise BadInputError(f"holds {fields}; {', '.join(NEEDED)} and at most {', '.join(RECORDED)} would be right")
        name = check_name(document["name"])
        calibration = cls(
            name, _intrinsics(document), _pose(document), _distortion(document), rows_of_points(document.get("points"))
        )
        if HOMOGRAPHY in document:
            given, own = _numbers(document, HOMOGRAPHY, (3, 3)), calibration.homography
            if np.abs(given - own).max() > FITS * np.abs(own).max():
                raise BadInputError(f"{HOMOGRAPHY} is not that of intrinsics and camera_in_world; leave it out")
        return calibration

    def _document(self) -> dict[str, Any]:
        i = self.intrinsics
        document: dict[str, Any] = {"name": self.name, "size": [i.width, i.height]}
        document["intrinsics"] = {name: float(getattr(i, name)) for name in LENS}
        if self.distortion is not None:
            coefficients = self.distortion.coefficients.tolist()
            document["distortion"] = {"model": self.distortion.model, "coefficients": coefficients}
        document["camera_in_world"] = self.camera_in_world.tolist()
        document[HOMOGRAPHY] = self.homography.tolist()
        if len(self.points):
            pixels, floor = self.pixel_errors(), self.floor_errors()
            document["errors"] = {
                "rms_px": float(np.sqrt(np.mean(pixels**2))),
                "worst_px": float(pixels.max()),
                "points_px": [round(error, 4) for error in pixels.tolist()],
                "points_m": [round(error, 5) if math.isfinite(error) else None for error in floor.tolist()],
            }
            document["points"] = [dict(zip("uvxyz", row, strict=True)) for row in self.points.rows()]
        return document


def check_name(name: Any) -> str:
    """Return a camera's name.

    Raises:
        BadInputError: It is none.
    """
    if not isinstance(name, str) or not NAME.fullmatch(name):
        raise BadInputError(f"name of the camera is {name!r}; letters, digits and underscores would be right")
    return name


def _numbers(document: dict[str, Any], name: str, shape: tuple[int, ...]) -> Array:
    """Return a field of finite numbers as an array of a shape."""
    value = document.get(name)
    try:
        array = np.array(value, float)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != shape or not np.isfinite(array).all():
        right = " x ".join(map(str, shape))
        raise BadInputError(f"{name} is {str(value)[:LONGEST_VALUE]}; {right} finite numbers would be right")
    return array


def _intrinsics(document: dict[str, Any]) -> Intrinsics:
    size, lens = document["size"], document["intrinsics"]
    if not (isinstance(size, list) and len(size) == 2 and all(type(side) is int and side > 0 for side in size)):
        raise BadInputError(f"size is {size!r}; [width, height] in pixels would be right")
    if not isinstance(lens, dict) or set(lens) != set(LENS):
        raise BadInputError(f"intrinsics is {str(lens)[:LONGEST_VALUE]}; {', '.join(LENS)} would be right")
    fx, fy, cx, cy = (float(_numbers(lens, name, ())) for name in LENS)
    if not (fx > 0.0 and fy > 0.0):
        raise BadInputError(f"intrinsics: fx, fy are {fx:g}, {fy:g} px; positive focal lengths would be right")
    return Intrinsics(size[0], size[1], fx, fy, cx, cy)


def _pose(document: dict[str, Any]) -> Array:
    pose = _numbers(document, "camera_in_world", (4, 4))
    turn = pose[:3, :3]
    rigid = np.abs(turn.T @ turn - np.eye(3)).max() < FITS and np.linalg.det(turn) > 0.0
    if not rigid or pose[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        raise BadInputError("camera_in_world is no pose; a rotation, a position and the row 0, 0, 0, 1 would be right")
    if pose[2, 3] <= 0.0:
        raise BadInputError(f"camera_in_world has the camera at z {pose[2, 3]:g} m; above the floor would be right")
    return pose


def _distortion(document: dict[str, Any]) -> Distortion | None:
    value = document.get("distortion")
    if value is None:
        return None
    if not isinstance(value, dict) or set(value) != {"model", "coefficients"}:
        raise BadInputError(f"distortion is {str(value)[:LONGEST_VALUE]}; model and coefficients would be right")
    coefficients = value["coefficients"]
    shape = (len(coefficients) if isinstance(coefficients, list) else 0,)
    return Distortion(str(value["model"]), _numbers(value, "coefficients", shape))
