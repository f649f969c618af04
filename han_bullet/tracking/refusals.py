"""Why a box gave no measurement: the questions of the ground projection, asked one by one."""

from __future__ import annotations

import numpy as np

from han_bullet.geometry import Array
from han_bullet.messages import Detections, Scan
from han_bullet.tracking.building import on_floor
from han_bullet.tracking.projection import BORDER, PLAUSIBLE_HEIGHTS, SMALLEST_BOX, FootPoints, GroundProjection


class RefusalReasons:
    """Say what is wrong with the boxes that a projection drops.

    Args:
        projection: The one to speak for.
    """

    def __init__(self, projection: GroundProjection) -> None:
        self.projection = projection

    def of(self, detections: Detections, scan: Scan) -> tuple[str | None, ...]:
        """Return a reason per box of a scan's frame; None where it became a measurement."""
        boxes = np.asarray(detections.boxes, float).reshape(-1, 4)
        rows = self.projection.known_rows(scan.frame, boxes, detections.feet, scan.pose_robot_in_world)
        feet = self.projection.foot_points(scan.frame, boxes, rows)
        kept = set(scan.sources.tolist())
        return tuple(None if row in kept else self._reason(scan, boxes, feet, row) for row in range(len(boxes)))

    def _reason(self, scan: Scan, boxes: Array, feet: FootPoints, row: int) -> str:
        x, y = feet.positions[row]
        if not feet.measurable[row]:
            return _why_not_measurable(scan, boxes[row], known=bool(np.isfinite(feet.known[row, 1])))
        if self._is_robot_at(scan, feet.positions[row]):
            return f"the foot point ({x:.2f}, {y:.2f}) belongs to the robot itself"
        if not self.projection.has_human_height(feet)[row]:
            low, high = self.projection.least_heights(feet)[row], PLAUSIBLE_HEIGHTS[1]
            return (
                f"a person at its foot point ({x:.2f}, {y:.2f}) would be {feet.heights[row]:.2f} m tall, "
                f"not {low:g} to {high:g} m"
            )
        places = self.projection.places(scan.frame, boxes, feet, np.ones(len(boxes), bool), scan.pose_robot_in_world)
        if not places.valid[row]:
            return "its feet are hidden, and neither seat nor head tells where it is"
        return self._why_not_there(scan, places.positions[row])

    def _why_not_there(self, scan: Scan, place: Array) -> str:
        x, y = place
        if self._is_robot_at(scan, place):
            return f"its place ({x:.2f}, {y:.2f}) belongs to the robot itself"
        if not on_floor(self.projection.floor, place[None])[0]:
            return f"its place ({x:.2f}, {y:.2f}) is off the floor"
        return f"its place ({x:.2f}, {y:.2f}) is in or behind a part of the building"

    def _is_robot_at(self, scan: Scan, place: Array) -> bool:
        pose = scan.pose_robot_in_world
        return pose is not None and bool(self.projection.is_robot(place[None], pose)[0])


def _why_not_measurable(scan: Scan, box: Array, *, known: bool) -> str:
    height = box[3]
    if known:
        return "its feet are above the horizon"
    if height < SMALLEST_BOX:
        return f"the box is {height:.0f} px tall, and the smallest that is measured {SMALLEST_BOX:.0f} px"
    if box[1] + (1.0 + BORDER) * height > scan.frame.intrinsics.height:
        return "the box ends at the image's lower border, below which the feet may be"
    return "its lower edge is above the horizon"
