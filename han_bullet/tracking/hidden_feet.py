"""People whose feet an image does not show: found out by the map's furniture, placed by their head or their seat.

The lower edge of such a box lies on the couch that hides the feet, or at the hips, so its floor point is behind the
person, by a metre and more. The upper edge is the head all the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array
from han_bullet.messages import Frame, Seat
from han_bullet.tracking.field_of_view import BODY_HEIGHT
from han_bullet.tracking.kalman import HEIGHT_DEVIATION
from han_bullet.tracking.seats import in_sitting_area
from han_bullet.tracking.solids import Solids

# Standing, of a whole person [m]: of 1055 boxes of whole people in real2 and sim2 none was below 1.61; of 25 below 1.6
# every one had lost its feet.
SHORTEST_WHOLE = 1.5
# A head says where its person stands if it does so to this deviation [m], the tracker's distance gate; one level with
# the camera says nothing.
LARGEST_DEVIATION = 1.0
# Across the ray [m], as of a foot point.
ACROSS_DEVIATION = 0.04
# Of the head of a seated person [m]; the lower limit allows for a box without the lower legs.
SEATED_HEIGHTS = (0.9, 1.45)
# Where in a box to look for furniture below its lower edge: left, middle and right in box widths from the middle, as
# wide as feet in a stride, and down in box heights, the deviation of a foot point.
STRIDE, BELOW = 0.25, 0.05
# The same below a lowest pixel that is known: twice its deviation [px].
BELOW_KNOWN = 3.0


@dataclass(frozen=True)
class Readings:
    """Places of n people without feet; those that make no sense are not `valid`.

    Attributes:
        positions: Shape (n, 2) [m].
        covariances: Shape (n, 2, 2) [m^2].
        valid: Shape (n,).
        per_height: How far positions are off per metre that the person looks taller than assumed, shape (n, 2).
    """

    positions: Array
    covariances: Array
    valid: NDArray[np.bool_]
    per_height: Array

    @classmethod
    def none(cls) -> Readings:
        """Return the places of nobody."""
        return cls(np.zeros((0, 2)), np.zeros((0, 2, 2)), np.zeros(0, bool), np.zeros((0, 2)))

    def or_else(self, other: Readings) -> Readings:
        """Return these, and the others' where these are not valid."""
        return Readings(
            np.where(self.valid[:, None], self.positions, other.positions),
            np.where(self.valid[:, None, None], self.covariances, other.covariances),
            self.valid | other.valid,
            np.where(self.valid[:, None], self.per_height, other.per_height),
        )


def feet_hidden(
    frame: Frame, boxes: Array, heads: Readings, furniture: Solids, known_feet: Array | None = None
) -> NDArray[np.bool_]:
    """Tell of which people furniture of the map hides the feet.

    It does so where the image shows it below the box's lower edge, and where it stands before the feet of an adult who
    reaches the upper edge: a detector that sees no legs may end its box well above what hides them. Somebody short who
    stands close behind furniture looks the same, and is then placed too near, within the deviation of heads. Where the
    pixel is known at which somebody ends, only what the image shows below it counts.

    Args:
        frame: The camera.
        boxes: Shape (n, 4): x, y, width, height [px].
        heads: The people's places by their heads.
        furniture: What may hide feet.
        known_feet: Lowest pixels (column, row) of the people, shape (n, 2) [px], NaN where nobody knows; None: nowhere.
    """
    ends = np.full((len(boxes), 2), np.nan) if known_feet is None else known_feet
    known = np.isfinite(ends[:, 1])
    eye = frame.camera_in_world[:3, 3]
    feet = np.column_stack([heads.positions, np.zeros(len(boxes))])
    hidden = ~known & heads.valid & furniture.hide(eye, feet)
    rows = np.where(known, ends[:, 1] + BELOW_KNOWN, boxes[:, 1] + (1.0 + BELOW) * boxes[:, 3])
    for share in (0.5 - STRIDE, 0.5, 0.5 + STRIDE):
        rays = _rays(frame, np.where(known, ends[:, 0], boxes[:, 0] + share * boxes[:, 2]), rows)
        falling = rays[:, 2] < 0.0
        to_floor = np.where(falling, -eye[2] / np.where(falling, rays[:, 2], -1.0), 0.0)
        hidden |= falling & furniture.hide(eye, eye + to_floor[:, None] * rays)
    return hidden


def by_head(frame: Frame, boxes: Array, foot_points: Array) -> Readings:
    """Place standing people where the upper edge of their box is at an adult's height.

    Feet that are hidden are nearer than what hides them, so a head that is farther than the foot point is not that of a
    standing person.

    Args:
        frame: The camera.
        boxes: Shape (n, 4): x, y, width, height [px].
        foot_points: Of the boxes' lower edges, shape (n, 2) [m].
    """
    eye, directions, reach = _bearings(frame, foot_points)
    slopes = _head_slopes(frame, boxes)
    steep = np.where(np.abs(slopes) < 1e-9, 1e-9, slopes)
    distances = (BODY_HEIGHT - eye[2]) / steep
    deviations = HEIGHT_DEVIATION / np.abs(steep)
    valid = (distances > 0.0) & (distances <= reach + deviations) & (deviations <= LARGEST_DEVIATION)
    positions = eye[:2] + np.minimum(distances, reach)[:, None] * directions
    return Readings(positions, _along(directions, deviations), valid, -directions / steep[:, None])


def by_seat(frame: Frame, boxes: Array, foot_points: Array, seat: Seat) -> Readings:
    """Place people on a seat that their bearing crosses, where their head is as high there as one who sits.

    Args:
        frame: The camera.
        boxes: Shape (n, 4): x, y, width, height [px].
        foot_points: Of the boxes' lower edges, shape (n, 2) [m].
        seat: The sitting area.
    """
    eye, directions, _ = _bearings(frame, foot_points)
    distances = directions @ (seat.position_in_world - eye[:2])
    positions = eye[:2] + distances[:, None] * directions
    heights = eye[2] + distances * _head_slopes(frame, boxes)
    seated = (heights >= SEATED_HEIGHTS[0]) & (heights <= SEATED_HEIGHTS[1])
    valid = (distances > 0.0) & in_sitting_area(seat, positions) & seated
    deviation = seat.width / np.sqrt(12.0)  # anywhere on it
    return Readings(positions, _along(directions, np.full(len(boxes), deviation)), valid, np.zeros((len(boxes), 2)))


def _rays(frame: Frame, columns: Array, rows: Array) -> Array:
    """Return the directions (n, 3) in the world in which pixels lie."""
    i = frame.intrinsics
    in_camera = np.column_stack([(columns - i.cx) / i.fx, (rows - i.cy) / i.fy, np.ones(len(rows))])
    directions: Array = in_camera @ frame.camera_in_world[:3, :3].T
    return directions


def _bearings(frame: Frame, foot_points: Array) -> tuple[Array, Array, Array]:
    """Return the camera's place (3,), the level unit directions to floor points (n, 2), and their distances (n,)."""
    eye = frame.camera_in_world[:3, 3]
    ray = foot_points - eye[:2]
    reach = np.maximum(np.linalg.norm(ray, axis=1), 1e-9)
    return eye, ray / reach[:, None], reach


def _head_slopes(frame: Frame, boxes: Array) -> Array:
    """Return how much the line of sight to the boxes' upper edges rises per metre of floor, shape (n,)."""
    rays = _rays(frame, boxes[:, 0] + 0.5 * boxes[:, 2], boxes[:, 1])
    slopes: Array = rays[:, 2] / np.maximum(np.hypot(rays[:, 0], rays[:, 1]), 1e-9)
    return slopes


def _along(directions: Array, deviations: Array) -> Array:
    """Return covariances (n, 2, 2) [m^2] with deviations (n,) [m] along unit directions (n, 2)."""
    outer = directions[:, :, None] * directions[:, None, :]
    across = np.eye(2) - outer
    return deviations[:, None, None] ** 2 * outer + ACROSS_DEVIATION**2 * across
