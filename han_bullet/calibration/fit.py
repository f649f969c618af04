"""Fit a camera's pose, and its focal length where nobody knows it, to points of its undistorted image.

Start: the pose that SQPnP [Terzakis2020] finds, for each of a row of focal lengths, whichever explains the points best.
Then the reprojection error is minimized; its Jacobian tells how well the points determine what was solved.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from han_bullet.calibration.calibration import Calibration
from han_bullet.calibration.points import MarkedPoints
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Intrinsics, project

CLICK = 1.0  # [px]: nobody marks a point better, even if few points happen to fit
ROBUST = 2.0  # [px]: errors beyond count in proportion, not squared
FOCAL_LENGTHS = np.geomspace(0.3, 10.0, 24)  # in image widths: fields of view from 118 to 6 degrees
MOST_STEPS = 60  # what points leave open, least squares would look for without end
NEAREST = 1e-3  # [m]: least depth of a point that is before the camera
VAGUEST_FOCAL = 0.2  # its deviation, relative, from which on it counts as open
VAGUEST_PLACE = 0.5  # the position's deviation, in heights of the camera
KNOWN_FOCAL = "--field-of-view DEG, --focal PX or --camera-matrix FILE"
TURN, PLACE, FOCAL = slice(0, 3), slice(3, 6), 6  # among the parameters


@dataclass(frozen=True)
class Fit:
    """A camera and how well its points determine it.

    Attributes:
        camera: Without distortion; its points are those it was fitted to.
        scatter: Of the points around it: their errors' deviation per coordinate [px], freedom considered.
        position_deviation: Of its place, shape (3,) [m].
        focal_deviation: Of its focal length [px]; None where that was given.
    """

    camera: Calibration
    scatter: float
    position_deviation: Array
    focal_deviation: float | None


def fit_camera(points: MarkedPoints, lens: Intrinsics, solve_focal: bool) -> Fit:
    """Fit a camera to points.

    Args:
        points: In the undistorted image; checked.
        lens: Where `solve_focal`, only its size, principal point and ratio of fx to fy count.
        solve_focal: Whether the focal length is open.

    Raises:
        BadInputError: No camera above the floor and before the points fits.
    """
    problem = _Problem(points, lens, solve_focal)
    focal_lengths = (FOCAL_LENGTHS * lens.width).tolist() if solve_focal else [lens.fx]
    start = min(_starts(points, lens, focal_lengths), key=problem.cost, default=None)
    if start is None:
        raise BadInputError(
            "no camera shows points like that; check u (column), v (row), x and y, and mark them farther apart"
        )
    _check_view(problem.camera(start))
    fit = problem.refined(start)
    _check_view(fit.camera)
    return fit


@dataclass(frozen=True)
class _Start:
    """A guess: focal length [px] and pose, shape (4, 4)."""

    focal: float
    camera_in_world: Array


def _starts(points: MarkedPoints, lens: Intrinsics, focal_lengths: Sequence[float]) -> Iterator[_Start]:
    places, pixels = map(np.ascontiguousarray, (points.points_in_world, points.pixels))
    for focal in focal_lengths:
        matrix = _with_focal(lens, focal).matrix
        try:
            found, turn, shift = cv2.solvePnP(places, pixels, matrix, None, flags=cv2.SOLVEPNP_SQPNP)
        except cv2.error:  # the points' rays are too close together
            continue
        if found and np.isfinite(turn).all() and np.isfinite(shift).all():
            world_to_camera = Rotation.from_rotvec(turn.ravel()).as_matrix()
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = world_to_camera.T, -world_to_camera.T @ shift.ravel()
            yield _Start(focal, pose)


def _with_focal(lens: Intrinsics, focal: float) -> Intrinsics:
    """Return a lens with another fx, and fy in proportion."""
    return replace(lens, fx=focal, fy=focal * lens.fy / lens.fx)


class _Problem:
    """Least squares over a step from a start: turn, place and, where it is open, the focal length's logarithm."""

    def __init__(self, points: MarkedPoints, lens: Intrinsics, solve_focal: bool) -> None:
        self._points, self._lens, self._solve_focal = points, lens, solve_focal
        self._far = float(np.hypot(lens.width, lens.height))  # [px]: error of a point that is not before the camera

    def camera(self, start: _Start, step: Array | None = None) -> Calibration:
        """Return the camera that a guess, moved by a step, stands for."""
        step = np.zeros(FOCAL + 1) if step is None else step
        pose = np.eye(4)
        pose[:3, :3] = start.camera_in_world[:3, :3] @ Rotation.from_rotvec(step[TURN]).as_matrix()
        pose[:3, 3] = start.camera_in_world[:3, 3] + step[PLACE]
        focal = start.focal * float(np.exp(step[FOCAL])) if self._solve_focal else start.focal
        return Calibration("camera", _with_focal(self._lens, focal), pose, points=self._points)

    def residuals(self, camera: Calibration) -> Array:
        """Return reprojected minus marked pixels, shape (2 n,) [px]."""
        pixels, depths = project(self._points.points_in_world, camera.intrinsics, camera.camera_in_world)
        errors = np.where(depths[:, None] > NEAREST, pixels - self._points.pixels, self._far)
        return np.asarray(errors, float).ravel()

    def cost(self, start: _Start) -> float:
        """Return how badly a guess explains the points, by the measure that `refined` minimizes."""
        return float((np.sqrt(1.0 + (self.residuals(self.camera(start)) / ROBUST) ** 2) - 1.0).sum())

    def refined(self, start: _Start) -> Fit:
        """Return the camera of the least reprojection error near a guess."""
        parameters = FOCAL + 1 if self._solve_focal else FOCAL
        found = least_squares(
            lambda step: self.residuals(self.camera(start, step)),
            np.zeros(parameters),
            jac="3-point",
            loss="soft_l1",
            f_scale=ROBUST,
            x_scale="jac",
            xtol=1e-15,
            ftol=1e-15,
            gtol=1e-15,
            max_nfev=MOST_STEPS,
        )
        camera = self.camera(start, found.x)
        freedom = max(2 * len(self._points) - parameters, 1)
        scatter = max(CLICK, float(np.sqrt((self.residuals(camera) ** 2).sum() / freedom)))
        deviations = scatter * _deviations(found.jac)
        focal = float(deviations[FOCAL]) * camera.intrinsics.fx if self._solve_focal else None
        return Fit(camera, scatter, deviations[PLACE], focal)


def _deviations(jacobian: Array) -> Array:
    """Return the deviations of parameters, (p,), for residuals of deviation 1; huge for what nothing determines."""
    _, values, axes = np.linalg.svd(jacobian, full_matrices=False)
    deviations: Array = np.sqrt(((axes / np.maximum(values, 1e-12)[:, None]) ** 2).sum(axis=0))
    return deviations


def _check_view(camera: Calibration) -> None:
    """Raise unless a camera is above the floor and sees all its points."""
    height, points = camera.camera_in_world[2, 3], camera.points
    if height <= 0.0:
        raise BadInputError(
            f"the points put the camera {-height:.2f} m under the floor; u is the column, v the row, and seen from "
            "above y points to the left of x"
        )
    heights = points.points_in_world[:, 2]
    _, depths = project(points.points_in_world, camera.intrinsics, camera.camera_in_world)
    _, on_floor = camera.on_plane(points.pixels, heights)
    for (u, v), depth, below_horizon, z in zip(points.pixels.tolist(), depths, on_floor, heights, strict=True):
        if depth <= NEAREST or (z == 0.0 and not below_horizon):
            where = "behind the camera that" if depth <= NEAREST else "above the horizon that"
            raise BadInputError(
                f"the point at u {u:g}, v {v:g} lies {where} the points put together; measured or typed wrong?"
            )


def check_determined(fit: Fit) -> None:
    """Make sure that a fit is the only one.

    Raises:
        BadInputError: The points leave the focal length or the place open.
    """
    if fit.focal_deviation is not None and not fit.focal_deviation < VAGUEST_FOCAL * fit.camera.intrinsics.fx:
        raise BadInputError(
            "the points leave the focal length open, as they do where the camera looks straight down or they are close "
            f"together; give {KNOWN_FOCAL}"
        )
    vague = float(np.linalg.norm(fit.position_deviation))
    if not vague < VAGUEST_PLACE * fit.camera.camera_in_world[2, 3]:
        raise BadInputError(
            f"the points tell the camera's place only to {vague:.2g} m; check them, and mark more and farther apart"
        )
