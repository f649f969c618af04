"""Before it counts: every stage is used once, so that its compiled code is loaded and the first steps take no longer.

A process that has not run yet loads that code in a moment; one that is the first since it was installed compiles it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from han_bullet.detection.camera_detector import FrameDetector
from han_bullet.geometry import Array, Pose2D, Twist2D
from han_bullet.messages import (
    CameraImage,
    Detections,
    Frame,
    FrameDetections,
    LaserScan,
    LegScan,
    Observation,
    Odometry,
    Posture,
    Scan,
    TrackedPerson,
)
from han_bullet.mounted_camera import MountedCamera
from han_bullet.stack import NavigationStack
from han_bullet.tracking.tracker import PeopleTracker
from han_bullet.world_schema import CONTROL_PERIOD, Laser, World

STEPS = 4  # the robot has moved, and who was seen first is tracked


def rehearse(stack: NavigationStack, world: World) -> None:
    """Let a stack decide on made-up observations. It is of no use afterwards: throw it away.

    Args:
        stack: Its detector is not asked.
        world: Its cameras and laser; without a laser, one as robots usually have.
    """
    stack.detector = _SeesSomebody()
    for step in range(STEPS):
        stack.step(_observation(world, step * CONTROL_PERIOD))
    stack.tracker = _Company(world.robot.start_pose_in_world)
    stack.step(_observation(world, STEPS * CONTROL_PERIOD))


class _SeesSomebody(FrameDetector):
    """One person in the middle of every image."""

    def detect(self, frames: Sequence[Frame]) -> list[FrameDetections]:
        return [_somebody(frame).at(frame.camera, frame.time) for frame in frames]


class _Company(PeopleTracker):
    """Two metres ahead of the robot, one person of each posture."""

    def __init__(self, pose_robot_in_world: Pose2D) -> None:
        self._place = pose_robot_in_world.to_world(np.array([2.0, 0.5]))

    def update(
        self, scans: Sequence[Scan], time: float, blind: Sequence[Frame] = (), legs: LegScan | None = None
    ) -> tuple[TrackedPerson, ...]:
        return tuple(_person(self._place, posture, time) for posture in Posture)


def _somebody(frame: Frame) -> Detections:
    height, width = frame.image.shape[:2]
    box = np.array([[0.45 * width, 0.3 * height, 0.1 * width, 0.4 * height]])
    return Detections(box, np.array([100.0]), np.array([1.0]))


def _observation(world: World, time: float) -> Observation:
    """Return what a robot between near walls observes that drives straight on at 1 m/s."""
    odometry = Odometry(time, Pose2D(time, 0.0, 0.0), Twist2D(1.0, 0.0, 0.0))
    laser = world.robot.laser or Laser()
    first, step = -0.5 * math.radians(laser.field_of_view), math.radians(laser.resolution)
    ranges = np.full(laser.ray_count, 0.6)
    ranges[laser.ray_count // 3 : -(laser.ray_count // 3)] = np.inf
    scan = LaserScan(time, ranges, first, step, 0.0, laser.range_max, Pose2D(laser.forward, 0.0, 0.0))
    mounted = [MountedCamera.of_world(camera) for camera in world.cameras]
    return Observation(time, odometry, scan, tuple(_image(camera, time) for camera in mounted))


def _image(camera: MountedCamera, time: float) -> CameraImage:
    lens = camera.intrinsics
    image = np.zeros((lens.height, lens.width, 3), np.uint8)
    return CameraImage(camera.name, time, image, lens, camera.mount, camera.fixed)


def _person(place: Array, posture: Posture, time: float) -> TrackedPerson:
    speed = np.array([0.5, 0.0]) if posture is Posture.WALKING else np.zeros(2)
    return TrackedPerson(0, time, place, speed, 0.01 * np.eye(4), posture, 0.0)
