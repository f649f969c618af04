"""Solve a camera from points marked in its image, without the one, if there is one, that all others contradict."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from han_bullet.calibration.calibration import Calibration
from han_bullet.calibration.fit import Fit, check_determined, fit_camera
from han_bullet.calibration.lens import Distortion
from han_bullet.calibration.points import MarkedPoints, check_points
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Intrinsics

CLEAR = 5.0  # [px] off: less is not worth leaving a point out
DOMINANT = 3.0  # times as far scattered are the points without any other one
FEWEST_OTHERS = 5  # four fit too many cameras to contradict anybody
MOST_SUSPECTS = 40  # among more points than these one does little harm


@dataclass(frozen=True)
class Solution:
    """A solved camera.

    Attributes:
        calibration: With all points.
        position_deviation: Of its place, shape (3,) [m].
        focal_deviation: Of its focal length [px]; None where that was given.
        left_out: Index of a point that all the others contradict, and that the camera was solved without; or None.
    """

    calibration: Calibration
    position_deviation: Array
    focal_deviation: float | None
    left_out: int | None


def solve(
    points: MarkedPoints,
    size: tuple[int, int],
    intrinsics: Intrinsics | None = None,
    distortion: Distortion | None = None,
    name: str = "camera",
) -> Solution:
    """Solve a camera.

    Args:
        points: At least four, better eight or more, spread over floor and image.
        size: Width and height of the image [px].
        intrinsics: None solves the focal length, for square pixels and a principal point in the image's middle.
        distortion: Of the lens.
        name: Of the camera.

    Raises:
        BadInputError: The points do not tell one camera above the floor.
    """
    check_points(points, size)
    lens = intrinsics or Intrinsics(*size, 1.0, 1.0, 0.5 * size[0], 0.5 * size[1])
    marked = points if distortion is None else replace(points, pixels=distortion.undistort(points.pixels, lens))
    whole, complaint = _attempt(marked, lens, intrinsics is None)
    left_out, fit = None, whole
    if whole is None or whole.camera.pixel_errors().max() > CLEAR:
        left_out, fit = _without_suspect(marked, lens, intrinsics is None, whole) or (None, whole)
    if fit is None:
        raise BadInputError(complaint)
    check_determined(fit)
    calibration = replace(fit.camera, name=name, distortion=distortion, points=points)
    return Solution(calibration, fit.position_deviation, fit.focal_deviation, left_out)


def _attempt(points: MarkedPoints, lens: Intrinsics, solve_focal: bool) -> tuple[Fit | None, str]:
    """Return the fit, or why there is none."""
    try:
        return fit_camera(points, lens, solve_focal), ""
    except BadInputError as error:
        return None, str(error)


def _without_suspect(
    points: MarkedPoints, lens: Intrinsics, solve_focal: bool, whole: Fit | None
) -> tuple[int, Fit] | None:
    """Return the point that the others contradict and the fit to these, if no other fit is nearly as good.

    Raises:
        BadInputError: There is such a point, and the camera that the others tell cannot see it there.
    """
    if not FEWEST_OTHERS < len(points) <= MOST_SUSPECTS:
        return None
    fits = sorted(_fits_without_one(points, lens, solve_focal), key=lambda pair: pair[1].scatter)
    rivals = [fit.scatter for _, fit in fits[1:]] + ([whole.scatter] if whole else [])
    if not fits or min(rivals, default=np.inf) < DOMINANT * fits[0][1].scatter:
        return None
    index, fit = fits[0]
    everything = replace(fit.camera, points=points)
    error, on_floor = float(everything.pixel_errors()[index]), np.isfinite(everything.floor_errors()[index])
    u, v = points.pixels[index].tolist()
    x, y, _ = points.points_in_world[index].tolist()
    if not (everything.depths()[index] > 0.0 and on_floor):
        raise BadInputError(
            f"point {index + 1} (u {u:g}, v {v:g}; x {x:g}, y {y:g}) contradicts the others: it would lie behind their "
            "camera or above its horizon; measured or typed wrong?"
        )
    return (index, fit) if error > CLEAR else None


def _fits_without_one(points: MarkedPoints, lens: Intrinsics, solve_focal: bool) -> Iterator[tuple[int, Fit]]:
    for index in range(len(points)):
        fit, _ = _attempt(points.without(index), lens, solve_focal)
        if fit is not None:
            yield index, fit
