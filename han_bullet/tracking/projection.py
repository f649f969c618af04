"""From boxes in an image to people's places on the floor, with the uncertainty that the camera's view gives them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Pose2D, SolidBox, floor_homography
from han_bullet.messages import Detections, Frame, Scan, Seat
from han_bullet.tracking.seats import in_sitting_area
from han_bullet.world_schema import FloorArea

# Deviation of the foot point in the image, upwards, per box height: 0.1 m on the floor at 2.5 m, 0.3 m at 7.5 m.
FOOT_NOISE_ALONG = 0.05
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
# Lower boxes are no measurement [px]: the smallest is 96, the toolbox's 100, given to people of 84 to 113 px alike,
# whose foot points then err by -1.4 to +1.0 m along the ray; from its next scale on the error is that of above.
SMALLEST_BOX = 104.0
# Foot points within the robot's radius and this of its pose [m] are the robot, a 1 m machine with a head.
OWN_BODY_MARGIN = 0.15
# Of a standing person whose box scatters by a tenth [m].
PLAUSIBLE_HEIGHTS = (1.3, 2.2)
# Of somebody in a sitting area [m]: head at 1.2 m, box sometimes without the lower legs.
LOWEST_SEATED = 0.9
# How far a foot point may err into a wall, a table or off the floor [m]: a large but common error along the ray.
BUILDING_TOLERANCE = 0.3
# Height that must be in sight of the camera past the walls [m].
CHEST = 1.2
# A box that ends closer to the image's lower border than this is cut [px].
BORDER = 2.0


@dataclass(frozen=True)
class FootPoints:
    """Foot points of n boxes on the floor, before anything is dropped.

    Attributes:
        positions: Of the people's centres, shape (n, 2) [m].
        covariances: Shape (n, 2, 2) [m^2].
        heights: How tall a person there must be to reach the box's upper edge, shape (n,) [m].
        measurable: Whether the foot point is in the image, below the horizon, and of a box large enough, shape (n,).
    """

    positions: Array
    covariances: Array
    heights: Array
    measurable: NDArray[np.bool_]


class GroundProjection:
    """Find where detected people stand, and drop what cannot be a person's foot point.

    Dropped: boxes too small or cut by the image's lower border, foot points above the horizon, the robot itself, boxes
    whose person would be a dwarf or a giant there, and places off the floor, in a solid box or behind a wall.

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
        if not robot_radius > 0.0:
            raise BadInputError(f"robot_radius is {robot_radius} m; a positive length would be right")
        self.robot_radius = robot_radius
        self.floor = tuple(floor)
        self.obstacles = tuple(obstacles)
        self.seats = tuple(seats)

    def project(self, frame: Frame, detections: Detections, pose_robot_in_world: Pose2D) -> Scan:
        """Return the people of one frame on the floor."""
        feet = self.foot_points(frame, detections.boxes)
        human = feet.measurable & ~self._is_robot(feet.positions, pose_robot_in_world) & self._has_human_height(feet)
        kept = np.flatnonzero(human)
        kept = kept[self._is_in_building(frame, feet.positions[kept])]
        return Scan(
            frame.camera,
            frame.time,
            feet.positions[kept],
            feet.covariances[kept],
            kept.astype(np.int64),
            frame,
            pose_robot_in_world,
        )

    def foot_points(self, frame: Frame, boxes: Array) -> FootPoints:
        """Return the floor points of boxes, shape (n, 4): x, y, width, height [px], whether or not they make sense."""
        boxes = np.asarray(boxes, float).reshape(-1, 4)
        pixels = np.column_stack([boxes[:, 0] + 0.5 * boxes[:, 2], boxes[:, 1] + FOOT_FRACTION * boxes[:, 3]])
        toes, jacobians, below_horizon = _to_floor(frame, pixels)
        deviations = boxes[:, 3, None] * np.array([FOOT_NOISE_ACROSS, FOOT_NOISE_ALONG])
        scaled = jacobians * deviations[:, None, :]
        covariances = scaled @ scaled.transpose(0, 2, 1) + BODY_DEVIATION**2 * np.eye(2)
        whole = boxes[:, 1] + boxes[:, 3] <= frame.intrinsics.height - BORDER
        measurable = below_horizon & whole & (boxes[:, 3] >= SMALLEST_BOX)
        return FootPoints(_behind(frame, toes), covariances, _heights(frame, toes, boxes[:, 1]), measurable)

    def _is_robot(self, positions: Array, pose_robot_in_world: Pose2D) -> NDArray[np.bool_]:
        distances = np.linalg.norm(positions - pose_robot_in_world.position, axis=1)
        own: NDArray[np.bool_] = distances <= self.robot_radius + OWN_BODY_MARGIN
        return own

    def _has_human_height(self, feet: FootPoints) -> NDArray[np.bool_]:
        lowest = np.full(len(feet.heights), PLAUSIBLE_HEIGHTS[0])
        for seat in self.seats:
            lowest[in_sitting_area(seat, feet.positions, BUILDING_TOLERANCE)] = LOWEST_SEATED
        human: NDArray[np.bool_] = (feet.heights >= lowest) & (feet.heights <= PLAUSIBLE_HEIGHTS[1])
        return human

    def _is_in_building(self, frame: Frame, positions: Array) -> NDArray[np.bool_]:
        inside = np.full(len(positions), not self.floor)
        if not len(positions):
            return inside
        for area in self.floor:
            lower = np.array([area.x[0], area.y[0]]) - BUILDING_TOLERANCE
            upper = np.array([area.x[1], area.y[1]]) + BUILDING_TOLERANCE
            inside |= np.all((positions >= lower) & (positions <= upper), axis=1)
        eye = frame.camera_in_world[:3, 3]
        ray = positions - eye[:2]
        nearer = positions - BUILDING_TOLERANCE * ray / np.linalg.norm(ray, axis=1, keepdims=True)
        chests = np.column_stack([nearer, np.full(len(nearer), CHEST)])
        for box in self.obstacles:
            if box.kind == "wall" and not box.contains(eye[:2]):  # a camera may be let into a wall
                inside &= ~box.blocks(eye, chests)
            if not any(in_sitting_area(seat, box.centre_in_world[:2]) for seat in self.seats):
                inside &= ~box.contains(positions, -BUILDING_TOLERANCE)
        return inside


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


def _behind(frame: Frame, toes: Array) -> Array:
    """Move floor points (n, 2) away from the camera, from the toes to the person's centre."""
    ray = toes - frame.camera_in_world[:2, 3]
    centres: Array = toes + OFFSET_ALONG_RAY * ray / np.maximum(np.linalg.norm(ray, axis=1, keepdims=True), 1e-9)
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
