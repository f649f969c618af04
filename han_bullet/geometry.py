"""Poses, twists, polylines and pinhole cameras: pure numpy, no state.

Frames: *world* (x along the corridor, y to its left, z up), *body* (x forward, y left), *camera* (OpenCV: x right,
y down, z along the view).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Angle = TypeVar("Angle", float, Array)

TOUCH = 1e-4  # a box that reaches no further into a cell [m] only borders on it; world files round angles


def wrap_angle(angle: Angle) -> Angle:
    """Return the same angle, or array of angles, in [-pi, pi) [rad]."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@dataclass(frozen=True)
class Pose2D:
    """A place and a direction on the floor.

    Attributes:
        x, y: Position in the world [m].
        yaw: Direction, counter-clockwise from the world's x axis [rad].
    """

    x: float
    y: float
    yaw: float

    @property
    def position(self) -> Array:
        """Return (x, y), shape (2,) [m]."""
        return np.array([self.x, self.y])

    def to_world(self, points_in_body: Array) -> Array:
        """Map points, shape (..., 2) [m], from this pose's body frame to the world."""
        return points_in_body @ rotation(self.yaw).T + self.position

    def to_body(self, points_in_world: Array) -> Array:
        """Map points, shape (..., 2) [m], from the world to this pose's body frame."""
        return (points_in_world - self.position) @ rotation(self.yaw)

    def matrix(self) -> Array:
        """Return the same as a rigid transform, shape (4, 4)."""
        pose = np.eye(4)
        pose[:2, :2], pose[:2, 3] = rotation(self.yaw), (self.x, self.y)
        return pose

    def compose(self, other_in_self: Pose2D) -> Pose2D:
        """Map a pose from this pose's body frame to the world."""
        x, y = rotated(other_in_self.x, other_in_self.y, self.yaw)
        return Pose2D(self.x + x, self.y + y, wrap_angle(self.yaw + other_in_self.yaw))

    def relative(self, other_in_world: Pose2D) -> Pose2D:
        """Map a pose from the world to this pose's body frame."""
        x, y = rotated(other_in_world.x - self.x, other_in_world.y - self.y, -self.yaw)
        return Pose2D(x, y, wrap_angle(other_in_world.yaw - self.yaw))

    def distance_to(self, point_in_world: Array | tuple[float, float]) -> float:
        """Return the distance to a point, two numbers [m]."""
        return math.hypot(point_in_world[0] - self.x, point_in_world[1] - self.y)


@dataclass(frozen=True)
class Twist2D:
    """A planar velocity in the body frame.

    Attributes:
        vx: Forward [m/s].
        vy: To the left [m/s].
        omega: Counter-clockwise [rad/s].
    """

    vx: float = 0.0
    vy: float = 0.0
    omega: float = 0.0

    @property
    def speed(self) -> float:
        """Return the translational speed [m/s]."""
        return math.hypot(self.vx, self.vy)

    def linear_in_world(self, yaw: float) -> Array:
        """Return the translational velocity in the world, shape (2,) [m/s], of a body with this yaw [rad]."""
        return np.array(rotated(self.vx, self.vy, yaw))


def rotated(x: float, y: float, angle: float) -> tuple[float, float]:
    """Return a vector, turned counter-clockwise [rad]; as numbers, since arrays of two would take ten times as long."""
    c, s = math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


def rotation(angle: float) -> Array:
    """Return the 2 x 2 matrix that turns vectors counter-clockwise by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


def moved(pose: Pose2D, twist: Twist2D, duration: float) -> Pose2D:
    """Return where a body frame ends that keeps a twist for a duration [s]: the exponential map of SE(2).

    The way is an arc; its chord points half the turn to the side and is shorter by sin(turn / 2) / (turn / 2).
    """
    turn = twist.omega * duration
    scale = duration * _chord_to_arc(turn)
    x, y = rotated(scale * twist.vx, scale * twist.vy, pose.yaw + 0.5 * turn)
    return Pose2D(pose.x + x, pose.y + y, wrap_angle(pose.yaw + turn))


def twist_between(before: Pose2D, after: Pose2D, duration: float) -> Twist2D:
    """Return the twist that, kept for a duration [s], moves one pose to the other: the inverse of `moved`."""
    turn = wrap_angle(after.yaw - before.yaw)
    scale = duration * _chord_to_arc(turn)
    vx, vy = rotated(after.x - before.x, after.y - before.y, -(before.yaw + 0.5 * turn))
    return Twist2D(vx / scale, vy / scale, turn / duration)


def _chord_to_arc(turn: float) -> float:
    return math.sin(0.5 * turn) / (0.5 * turn) if abs(turn) > 1e-9 else 1.0


def largest_deviation(covariance: Array) -> float:
    """Return the standard deviation along the direction in which a covariance, (n, n), is largest."""
    return math.sqrt(float(np.linalg.eigvalsh(covariance)[-1]))


def arc_lengths(polyline: Array) -> Array:
    """Return how far along a polyline, (n, 2) [m], each of its points lies, shape (n,) [m]."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(polyline, axis=0).T))])


def points_at(arc: float | Array, polyline: Array, arcs: Array) -> Array:
    """Return the points, (..., 2) [m], of a polyline at arc lengths [m]; its ends beyond them.

    Args:
        arc: Where, shape (...) [m].
        polyline: Shape (n, 2) [m].
        arcs: Its `arc_lengths`, shape (n,) [m].
    """
    return np.stack([np.interp(arc, arcs, polyline[:, axis]) for axis in (0, 1)], axis=-1)


def feet_on(polyline: Array, point: Array) -> tuple[Array, Array]:
    """Return the nearest places to a point, (2,) [m], on each piece of a polyline, (n, 2) [m].

    Returns:
        Shares of the pieces, 0 at their beginnings and 1 at their ends, shape (n - 1,), and places, (n - 1, 2) [m].
    """
    starts, steps = polyline[:-1], np.diff(polyline, axis=0)
    shares = np.clip(((point - starts) * steps).sum(axis=1) / np.maximum((steps**2).sum(axis=1), 1e-12), 0.0, 1.0)
    return shares, starts + shares[:, None] * steps


@dataclass(frozen=True)
class Intrinsics:
    """A pinhole camera without distortion.

    A pixel's coordinates count from the image's upper left corner, so the first pixel covers [0, 1) x [0, 1).

    Attributes:
        width, height: Image size [px].
        fx, fy: Focal lengths [px].
        cx, cy: Principal point [px].
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    @classmethod
    def from_vertical_field_of_view(cls, width: int, height: int, angle: float) -> Intrinsics:
        """Build the intrinsics of a centred camera with square pixels from its vertical opening angle [rad]."""
        focal = 0.5 * height / math.tan(0.5 * angle)
        return cls(width, height, focal, focal, 0.5 * width, 0.5 * height)

    @property
    def matrix(self) -> Array:
        """Return the 3 x 3 calibration matrix K."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])


def look_at(position_in_world: Array, target_in_world: Array) -> Array:
    """Return the pose (4, 4) in the world of an upright camera at a position that looks at a target, both (3,) [m].

    The columns are the camera's x (right), y (down) and z (view) axes and its position.
    """
    view = np.asarray(target_in_world, float) - np.asarray(position_in_world, float)
    forward: Array = view / math.hypot(*view)
    level = math.hypot(forward[0], forward[1])
    right: Array = np.array([forward[1] / level, -forward[0] / level, 0.0])  # forward x up
    pose = np.eye(4)
    pose[:3, :] = np.column_stack([right, np.cross(forward, right), forward, position_in_world])
    return pose


def camera_on_robot(pose_robot_in_world: Pose2D, forward: float, height: float, pitch_down: float) -> Array:
    """Return the pose (4, 4) in the world of a camera mounted on the robot's centre line.

    Args:
        pose_robot_in_world: Where the robot stands.
        forward: Of the mount, ahead of the robot's centre [m].
        height: Of the mount, above the floor [m].
        pitch_down: Downward tilt of the view [rad].
    """
    x, y = pose_robot_in_world.to_world(np.array([forward, 0.0]))
    position = np.array([x, y, height])
    yaw = pose_robot_in_world.yaw
    view = np.array([math.cos(yaw) * math.cos(pitch_down), math.sin(yaw) * math.cos(pitch_down), -math.sin(pitch_down)])
    return look_at(position, position + view)


def project(points_in_world: Array, intrinsics: Intrinsics, camera_in_world: Array) -> tuple[Array, Array]:
    """Project points into an image.

    Args:
        points_in_world: Shape (..., 3) [m].
        intrinsics: The camera.
        camera_in_world: Its pose, shape (4, 4).

    Returns:
        Pixels, shape (..., 2) [px], and depths along the view, shape (...) [m]; pixels of points that are not in front
        of the camera (depth <= 0) mean nothing.
    """
    in_camera = (np.asarray(points_in_world, float) - camera_in_world[:3, 3]) @ camera_in_world[:3, :3]
    depth = in_camera[..., 2]
    safe = np.where(np.abs(depth) < 1e-9, 1e-9, depth)
    u = intrinsics.fx * in_camera[..., 0] / safe + intrinsics.cx
    v = intrinsics.fy * in_camera[..., 1] / safe + intrinsics.cy
    return np.stack([u, v], axis=-1), depth


def floor_homography(intrinsics: Intrinsics, camera_in_world: Array) -> Array:
    """Return the homography H, (3, 3), from pixels (u, v, 1) to the floor (x, y, 1) of the world, up to scale.

    H is the inverse of K [r1 r2 t], the columns of the world-to-camera transform that the plane z = 0 uses
    [Hartley2004]. The third component of H (u, v, 1) is positive for pixels below the horizon.
    """
    rotation_world_to_camera = camera_in_world[:3, :3].T
    translation = -rotation_world_to_camera @ camera_in_world[:3, 3]
    plane = np.column_stack([rotation_world_to_camera[:, 0], rotation_world_to_camera[:, 1], translation])
    homography: Array = np.asarray(np.linalg.inv(intrinsics.matrix @ plane), np.float64)
    return homography


@dataclass(frozen=True)
class SolidBox:
    """A box of the building: a wall or a piece of furniture.

    Attributes:
        name: As in the world file.
        kind: "wall" or "object".
        centre_in_world: Shape (3,) [m].
        size: Along its own x, y and z axes, shape (3,) [m].
        yaw: Turn about the vertical [rad].
    """

    name: str
    kind: str
    centre_in_world: Array
    size: Array
    yaw: float

    def contains(self, points_in_world: Array, margin: float = 0.0) -> NDArray[np.bool_]:
        """Tell which floor points, shape (..., 2) [m], lie inside the footprint grown by a margin [m]."""
        in_box = (points_in_world - self.centre_in_world[:2]) @ rotation(self.yaw)
        inside: NDArray[np.bool_] = np.all(np.abs(in_box) <= 0.5 * self.size[:2] + margin, axis=-1)
        return inside

    def touches_cells(self, x: Array, y: Array, resolution: float) -> NDArray[np.bool_]:
        """Tell which cells with centres x, (1, columns), and y, (rows, 1) [m], overlap the box (separating axes)."""
        half_box, half_cell = 0.5 * self.size[:2], 0.5 * resolution
        turn = rotation(self.yaw)
        grown = np.abs(turn)  # the half extents of a unit square of one frame along the axes of the other
        dx, dy = x - self.centre_in_world[0], y - self.centre_in_world[1]
        reach_x, reach_y = grown @ half_box + half_cell - TOUCH
        u, v = turn[0, 0] * dx + turn[1, 0] * dy, turn[0, 1] * dx + turn[1, 1] * dy
        reach_u, reach_v = half_box + grown.sum(axis=0) * half_cell - TOUCH
        overlap: NDArray[np.bool_] = (
            (np.abs(dx) < reach_x) & (np.abs(dy) < reach_y) & (np.abs(u) < reach_u) & (np.abs(v) < reach_v)
        )
        return overlap

    def blocks(self, origin_in_world: Array, targets_in_world: Array) -> NDArray[np.bool_]:
        """Tell which straight lines from one point, (3,), to targets, (n, 3) [m], pass through the box (slab test)."""
        turn = np.eye(3)
        turn[:2, :2] = rotation(self.yaw)
        start = (origin_in_world - self.centre_in_world) @ turn
        along = (targets_in_world - origin_in_world) @ turn
        along = np.where(np.abs(along) < 1e-12, 1e-12, along)
        first = (-0.5 * self.size - start) / along
        second = (0.5 * self.size - start) / along
        enter = np.minimum(first, second).max(axis=-1)
        leave = np.maximum(first, second).min(axis=-1)
        blocked: NDArray[np.bool_] = (enter < leave) & (leave > 0.0) & (enter < 1.0)
        return blocked
