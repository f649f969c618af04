"""A camera's image with what its calibration says: the floor's metre grid, the points as marked and as reprojected."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np

from han_bullet.atomic_file import write_at_once
from han_bullet.calibration.calibration import Calibration
from han_bullet.detection.pictures import Image
from han_bullet.drawing import disc, line
from han_bullet.geometry import Array, project
from han_bullet.lettering import Lettering

GRID, MARKED, REPROJECTED, LETTERS, HALO = (70, 200, 255), (255, 220, 0), (255, 60, 60), (255, 255, 255), (0, 0, 0)
AROUND = 2.0  # [m] that the grid reaches beyond the points
MOST_LINES = 60  # per direction; of a larger floor only every second, fifth, ... metre
STEPS = (1, 2, 5, 10, 20, 50, 100)  # [m]
FINE = 0.05  # [m] between the points of a line, of which only those before the camera are drawn
NEAREST = 0.2  # [m] of depth
ROOM = 55.0  # [px] between neighbours that have room for their coordinates
USUAL_WIDTH = 1000.0  # [px]: shapes grow with wider images


def draw(image: Image, calibration: Calibration) -> Image:
    """Return a copy of a camera's image, undistorted, with the grid of the floor and the points on it."""
    picture = np.ascontiguousarray(calibration.undistort(image)).copy()
    scale = max(1, round(picture.shape[1] / USUAL_WIDTH))
    letters = Lettering()
    _draw_grid(picture, calibration, scale, letters)
    for number, (marked, back) in enumerate(zip(calibration.marked(), calibration.reprojected(), strict=True), 1):
        line(picture, np.array([marked, back]), REPROJECTED, scale)
        for turn in (0.25 * math.pi, 0.75 * math.pi):
            arm = 6.0 * scale * np.array([math.cos(turn), math.sin(turn)])
            line(picture, np.array([back - arm, back + arm]), REPROJECTED, scale)
        disc(picture, marked, 3.0 * scale, MARKED, rim=HALO)
        place = marked + np.array([9.0, -9.0]) * scale
        letters.write(picture, str(number), place, 13 * scale, MARKED, bold=True, halo=HALO)
    return picture


def _draw_grid(picture: Image, calibration: Calibration, scale: int, letters: Lettering) -> None:
    lower, upper = _extent(calibration)
    step = next((step for step in STEPS if (upper - lower).max() <= step * MOST_LINES), STEPS[-1])
    lines = [np.arange(math.ceil(lower[a] / step) * step, upper[a] + 1e-9, step) for a in (0, 1)]
    for axis in (0, 1):
        fine = np.arange(lower[1 - axis], upper[1 - axis] + FINE, FINE * step)
        for value in lines[axis]:
            places = np.insert(fine[:, None], axis, value, axis=1)
            _draw_visible(picture, calibration, places, scale)
    crossings = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 2)
    for place in crossings[_have_room(calibration, crossings, step, ROOM * scale)]:
        pixel = _pixels(calibration, place[None])[0][0]
        text = f"{place[0]:g}, {place[1]:g}"
        letters.write(picture, text, pixel + np.array([4.0, 9.0]) * scale, 11 * scale, LETTERS, halo=HALO)


def _extent(calibration: Calibration) -> tuple[Array, Array]:
    """Return the corners of the floor, (2,) [m], on which the grid is drawn."""
    places = calibration.points.points_in_world[:, :2]
    return np.floor(places.min(axis=0) - AROUND), np.ceil(places.max(axis=0) + AROUND)


def _pixels(calibration: Calibration, places: Array) -> tuple[Array, Array]:
    """Return the pixels, (n, 2), and depths, (n,) [m], of floor points, (n, 2) [m]."""
    on_floor = np.column_stack([places, np.zeros(len(places))])
    return project(on_floor, calibration.intrinsics, calibration.camera_in_world)


def _draw_visible(picture: Image, calibration: Calibration, places: Array, scale: int) -> None:
    """Draw the pieces of a line through floor points, (n, 2) [m], that lie in the image or just beside it."""
    pixels, depths = _pixels(calibration, places)
    shown = (depths > NEAREST) & (np.abs(pixels) < 3.0 * max(picture.shape)).all(axis=1)
    for piece in np.split(np.arange(len(places)), np.flatnonzero(~shown)):
        piece = piece[shown[piece]]
        if len(piece) > 1:
            line(picture, pixels[piece], GRID, scale)


def _have_room(calibration: Calibration, places: Array, step: int, room: float) -> Array:
    """Tell of which crossings, (n, 2) [m], the neighbours are a distance [px] away or more, shape (n,)."""
    pixels, depths = _pixels(calibration, places)
    near = [_pixels(calibration, places + np.array(shift))[0] for shift in ((step, 0.0), (0.0, step))]
    wide = np.minimum(*(np.abs(other - pixels).max(axis=1) for other in near))
    fits: Array = (depths > NEAREST) & (wide >= 0.4 * room) & (np.abs(near[1] - pixels).max(axis=1) >= room)
    return fits


def write_picture(picture: Image, path: Path) -> None:
    """Write a picture as its ending says, in one go."""
    write_at_once(path, cv2.imencode(path.suffix.lower(), np.ascontiguousarray(picture[:, :, ::-1]))[1].tobytes())
