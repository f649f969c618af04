"""From boxes in an image to people's places on the floor, with the uncertainty that the camera's view gives them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from han_bullet.errors import check_positive
from han_bullet.geometry import Array, Pose2D, SolidBox, floor_homography
from han_bullet.messages import Detections, Frame, Scan, Seat
from han_bullet.tracking.building import BUILDING_TOLERANCE, on_floor
from han_bullet.tracking.hidden_feet import SEATED_HEIGHTS, SHORTEST_WHOLE, Readings, by_head, by_seat, feet_hidden
from han_bullet.tracking.own_image import robot_body, rows_not_of_robot
from han_bullet.tracking.seats import in_sitting_area
from han_bullet.tracking.solids import Solids
from han_bullet.world_schema import FloorArea

# Deviation of the foot point in the image, upwards, per box height: 0.1 m on the floor at 2.5 m, 0.3 m at 7.5 m.
FOOT_NOISE_ALONG = 0.05
# The same of feet whose row the camera knows [px].
KNOWN_FOOT_NOISE = 1.5
# The same sideways: 0.04 m on the floor at every distance.
FOOT_NOISE_ACROSS = 0.025
# Isotropic, added on the floor [m]: cameras disagree by that much.
BODY_DEVIATION = 0.1
# Where in a box the feet are, from its upper edge, in box heights: the detector's boxes end 1.4 % of their height below
# the annotated ones (median of 528 on the INRIA test photographs).
FOOT_FRACTION = 0.986
# How far a person's centre lies behind the foot point, which is the nearest toe [m]: fitted on 20 runs of real2 and
# sim1 with one walker, where both together take the mean error along the ray from -0.13 and -0.18 m (cameras 1 and 3)
# to within 0.03 m; the worst position error of a run falls from 0.21 to 0.14 m.
OFFSET_ALONG_RAY = 0.07
# The same where the row of the feet is known [m]: 0.11 for the heels of who walks away, 0.22 for the toes of who comes;
# the mean of 2531 such feet in 11 runs of real1, real2, real4, sim1 and sim2.
OFFSET_OF_KNOWN_FEET = 0.15
# Lower boxes are no measurement [px] unless the feet are known: the smallest is 96, the toolbox's 100, given to people
# of 84 to 113 px alike, whose foot points then err by -1.4 to +1.0 m along the ray (known ones, 11 m away, by 0.1 m).
SMALLEST_BOX = 104.0
# Foot points within the robot's radius and this of its pose [m] are the robot, a 1 m machine with a head.
OWN_BODY_MARGIN = 0.15
# Of a standing person whose box scatters by a tenth [m].
PLAUSIBLE_HEIGHTS = (1.3, 2.2)
# The lower limit where the camera knows the feet and nothing hides them [m]: a box that holds but the legs, as before a
# wall of the pullover's colour, ends above the hips, and tells the place all the same.
LEGS_HEIGHT = 0.9
# Height that must be in sight of the camera past the walls [m].
CHEST = 1.2
# A box that ends closer to the image's lower border than this, in box heights, may be cut: feet below the image leave
# only boxes that are too high, 0.3 m too far at 5 % and 0.6 m at 400 px; above, the mean error is below 0.02 m.
BORDER = 0.05


@dataclass(frozen=True)
class FootPoints:
    """Foot points of n boxes on the floor, before anything is dropped.

    Attributes:
        positions: Of the people's centres, shape (n, 2) [m].
        covariances: Shape (n, 2, 2) [m^2].
        heights: How tall a person there must be to reach the box's upper edge, shape (n,) [m].
        measurable: Whether the foot point is below the horizon, and known, or in the image and of a box large enough,
            shape (n,).
        known: Pixels (column, row) where the feet end, shape (n, 2) [px]; NaN where only the box tells it.
    """

    positions: Array
    covariances: Array
    heights: Array
    measurable: NDArray[np.bool_]
    known: Array


class GroundProjection:
    """Find where detected people stand, and drop what cannot be a person's foot point.

    Boxes whose feet are hidden by furniture or by the robot, or too short for a whole person where the camera does not
    know the feet, are placed by seat or head instead.
    Dropped: boxes too small or cut by the image's lower border (unless the feet are known), foot points above the
    horizon, the robot itself, boxes whose person would be a dwarf or a giant there, and places off the floor, in a
    solid box or behind a wall.

    Args:
        robot_radius: Of its footprint [m].
        floor: Pieces of floor that people may stand on; none: everywhere.
        obstacles: Walls and furniture.
        seats: Where people may be lower than standing ones.

    Raises:
        BadInputError: `robot_radius` is not positive.
    """

    def __init__(
        self,
        *,
        robot_radius: float,
        floor: Sequence[FloorArea] = (),
        obstacles: Sequence[SolidBox] = (),
        seats: Sequence[Seat] = (),
    ) -> None:
        check_positive("projection", robot_radius=robot_radius)
        self.robot_radius = robot_radius
        self.floor = tuple(floor)
        self.seats = tuple(seats)
        self._furniture = Solids([box for box in obstacles if box.kind == "object"])
        self._walls = Solids([box for box in obstacles if box.kind == "wall"])
        # The foot points of those on a couch lie in it.
        self._nobody_in = Solids([box for box in obstacles if not self._is_seat(box)])

    def project(self, frame: Frame, detections: Detections, pose_robot_in_world: Pose2D) -> Scan:
        """Return the people of one frame on the floor."""
        # Most frames show nobody.
        people = self._people(frame, detections, pose_robot_in_world) if len(detections.boxes) else Readings.none()
        kept = np.flatnonzero(people.valid)
        return Scan(
            frame.camera,
            frame.time,
            people.positions[kept],
            people.covariances[kept],
            kept.astype(np.int64),
            frame,
            pose_robot_in_world,
            detections.empty_seats,
            people.per_height[kept],
        )

    def _people(self, frame: Frame, detections: Detections, pose_robot_in_world: Pose2D) -> Readings:
        """Return where the people of all boxes stand, valid where they are measurements."""
        boxes = np.asarray(detections.boxes, float).reshape(-1, 4)
        feet = self.foot_points(frame, boxes, self.known_rows(frame, boxes, detections.feet, pose_robot_in_world))
        human = feet.measurable & ~self.is_robot(feet.positions, pose_robot_in_world) & self.has_human_height(feet)
        places = self.places(frame, boxes, feet, human, pose_robot_in_world)
        valid = places.valid & ~self.is_robot(places.positions, pose_robot_in_world)
        valid[valid] = self._is_in_building(frame, places.positions[valid])
        return replace(places, valid=valid)

    def places(
        self,
        frame: Frame,
        boxes: Array,
        feet: FootPoints,
        human: NDArray[np.bool_],
        pose_robot_in_world: Pose2D | None,
    ) -> Readings:
        """Return where the people of human boxes stand; those whose feet do not show by their seat or their head."""
        heads = by_head(frame, boxes, feet.positions)
        hidden = behind = feet_hidden(frame, boxes, heads, self._furniture, feet.known)
        if frame.fixed and pose_robot_in_world is not None:
            robot = Solids([robot_body(pose_robot_in_world, self.robot_radius)])
            hidden = behind | feet_hidden(frame, boxes, heads, robot, feet.known)
        human = human & ~(hidden & self._holds_legs_alone(feet))
        lost = human & (hidden | self._is_short(feet))
        # Who seems as tall as one who stands, though only the robot is before their feet, does not sit farther away.
        may_sit = lost & (behind | (feet.heights < SHORTEST_WHOLE))
        places = Readings(feet.positions, feet.covariances, human & ~lost, np.zeros_like(feet.positions))
        seats = [(by_seat(frame, boxes, feet.positions, seat), may_sit) for seat in self.seats]
        for reading, whose in (*seats, (heads, lost)):
            covariances = reading.covariances + BODY_DEVIATION**2 * np.eye(2)
            places = places.or_else(replace(reading, covariances=covariances, valid=reading.valid & whose))
        return places

    def foot_points(self, frame: Frame, boxes: Array, known_rows: Array | None = None) -> FootPoints:
        """Return the floor points of boxes, whether or not they make sense.

        Args:
            frame: The camera.
            boxes: Shape (n, 4): x, y, width, height [px].
            known_rows: Where the feet end [px], shape (n,), NaN where only the box tells it; None: nowhere known.
        """
        boxes = np.asarray(boxes, float).reshape(-1, 4)
        ends = np.full(len(boxes), np.nan) if known_rows is None else known_rows
        known = ~np.isnan(ends)
        rows = np.where(known, ends, boxes[:, 1] + FOOT_FRACTION * boxes[:, 3])
        columns = _foot_columns(frame, boxes[:, 0] + 0.5 * boxes[:, 2], boxes[:, 1], rows)
        pixels = np.column_stack([columns, rows])
        toes, jacobians, below_horizon = _to_floor(frame, pixels)
        along = np.where(known, KNOWN_FOOT_NOISE, FOOT_NOISE_ALONG * boxes[:, 3])
        scaled = jacobians * np.column_stack([FOOT_NOISE_ACROSS * boxes[:, 3], along])[:, None, :]
        covariances = scaled @ scaled.transpose(0, 2, 1) + BODY_DEVIATION**2 * np.eye(2)
        whole = known | (boxes[:, 1] + (1.0 + BORDER) * boxes[:, 3] <= frame.intrinsics.height)
        measurable = below_horizon & whole & (known | (boxes[:, 3] >= SMALLEST_BOX))
        centres = _behind(frame, toes, np.where(known, OFFSET_OF_KNOWN_FEET, OFFSET_ALONG_RAY))
        known_feet = np.where(known[:, None], pixels, np.nan)
        return FootPoints(centres, covariances, _heights(frame, toes, boxes[:, 1]), measurable, known_feet)

    def known_rows(
        self, frame: Frame, boxes: Array, rows: Array | None, pose_robot_in_world: Pose2D | None
    ) -> Array | None:
        """Return the rows where feet end, without those that may be the robot's own lower end; see `foot_points`."""
        if rows is None or pose_robot_in_world is None:
            return rows
        return rows_not_of_robot(frame, boxes, rows, pose_robot_in_world, self.robot_radius)

    def is_robot(self, positions: Array, pose_robot_in_world: Pose2D) -> NDArray[np.bool_]:
        """Tell which places, (n, 2) [m], are the robot's own."""
        distances = np.linalg.norm(positions - pose_robot_in_world.position, axis=1)
        own: NDArray[np.bool_] = distances <= self.robot_radius + OWN_BODY_MARGIN
        return own

    def has_human_height(self, feet: FootPoints) -> NDArray[np.bool_]:
        """Tell which foot points are of somebody as tall as people are, shape (n,)."""
        human: NDArray[np.bool_] = (feet.heights >= self.least_heights(feet)) & (feet.heights <= PLAUSIBLE_HEIGHTS[1])
        return human

    def least_heights(self, feet: FootPoints) -> Array:
        """Return how tall whoever stands or sits there must seem at least, shape (n,) [m]."""
        lowest = np.where(self._on_seat(feet.positions), SEATED_HEIGHTS[0], PLAUSIBLE_HEIGHTS[0])
        return np.where(_knows(feet), LEGS_HEIGHT, lowest)

    def _is_short(self, feet: FootPoints) -> NDArray[np.bool_]:
        """Tell which boxes are too short for a whole person who stands, unless their feet are known."""
        short: NDArray[np.bool_] = (feet.heights < SHORTEST_WHOLE) & ~self._on_seat(feet.positions) & ~_knows(feet)
        return short

    def _holds_legs_alone(self, feet: FootPoints) -> NDArray[np.bool_]:
        """Tell which boxes are too low for a person by their upper edge."""
        low: NDArray[np.bool_] = (feet.heights < PLAUSIBLE_HEIGHTS[0]) & ~self._on_seat(feet.positions)
        return low

    def _on_seat(self, positions: Array) -> NDArray[np.bool_]:
        on_seat = np.zeros(len(positions), bool)
        for seat in self.seats:
            on_seat |= in_sitting_area(seat, positions, BUILDING_TOLERANCE)
        return on_seat

    def _is_in_building(self, frame: Frame, positions: Array) -> NDArray[np.bool_]:
        inside = on_floor(self.floor, positions)
        if not len(positions):
            return inside
        eye = frame.camera_in_world[:3, 3]
        ray = positions - eye[:2]
        nearer = positions - BUILDING_TOLERANCE * ray / np.linalg.norm(ray, axis=1, keepdims=True)
        chests = np.column_stack([nearer, np.full(len(nearer), CHEST)])
        return inside & ~self._walls.hide(eye, chests) & ~self._nobody_in.hold(positions, -BUILDING_TOLERANCE)

    def _is_seat(self, box: SolidBox) -> bool:
        return any(in_sitting_area(seat, box.centre_in_world[:2]) for seat in self.seats)


def _knows(feet: FootPoints) -> NDArray[np.bool_]:
    """Tell of which boxes the row of the feet is known, shape (n,)."""
    known: NDArray[np.bool_] = np.isfinite(feet.known[:, 1])
    return known


def _to_floor(frame: Frame, pixels: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return floor points (n, 2) of pixels (n, 2), their Jacobians (n, 2, 2) [m/px], and which are below the horizon.

    (x, y) = (h1 p, h2 p) / (h3 p) for p = (u, v, 1) and the rows h of the homography.
    """
    homography = floor_homography(frame.intrinsics, frame.camera_in_world)
    mapped = np.column_stack([pixels, np.ones(len(pixels))]) @ homography.T
    below_horizon: NDArray[np.bool_] = mapped[:, 2] > 0.0
    scale = np.where(below_horizon, mapped[:, 2], 1.0)[:, None]
    positions = mapped[:, :2] / scale
    jacobians = (homography[None, :2, :2] - positions[:, :, None] * homography[None, 2:, :2]) / scale[:, :, None]
    return positions, jacobians, below_horizon


def _foot_columns(frame: Frame, middles: Array, upper: Array, lower: Array) -> Array:
    """Return the columns (n,) [px] of the feet of upright people whose boxes have these middles and rows (n,) [px].

    Looking down, uprights lean outward, and the middle of a box is that of foot and head. With the foot's ray
    (x, y, 1), b the world's upright in the camera's axes and t the height over the depth, the head is at
    (x + t b_x) / (1 + t b_z); its row gives t.
    """
    i, up = frame.intrinsics, frame.camera_in_world[2, :3]
    middle, head, foot = (middles - i.cx) / i.fx, (upper - i.cy) / i.fy, (lower - i.cy) / i.fy
    t = (head - foot) / (up[1] - head * up[2])
    x = (2.0 * middle * (1.0 + t * up[2]) - t * up[0]) / (2.0 + t * up[2])
    columns: Array = i.fx * x + i.cx
    return columns


def _behind(frame: Frame, toes: Array, offsets: Array) -> Array:
    """Move floor points (n, 2) away from the camera by (n,) [m], from the toes to the person's centre."""
    ray = toes - frame.camera_in_world[:2, 3]
    centres: Array = toes + offsets[:, None] * ray / np.maximum(np.linalg.norm(ray, axis=1, keepdims=True), 1e-9)
    return centres


def _heights(frame: Frame, positions: Array, rows: Array) -> Array:
    """Return the height (n,) [m] over floor points (n, 2) at which a vertical line meets image rows (n,) [px].

    With a + z b the line in the camera's axes and t = (row - cy) / fy: a_y + z b_y = t (a_z + z b_z).
    """
    axes, eye = frame.camera_in_world[:3, :3], frame.camera_in_world[:3, 3]
    foot = (np.column_stack([positions, np.zeros(len(positions))]) - eye) @ axes
    up = axes[2]
    slope = (rows - frame.intrinsics.cy) / frame.intrinsics.fy
    heights: Array = (foot[:, 1] - slope * foot[:, 2]) / (slope * up[2] - up[1])
    return heights
