"""Builders of single ticks for tests of what looks at a run: plain numbers in, frozen values out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from han_bullet.costmap.grid import Costmap
from han_bullet.episode import Tick
from han_bullet.geometry import Pose2D, Twist2D, floor_homography, look_at
from han_bullet.messages import (
    CameraImage,
    Contact,
    Detections,
    Frame,
    FrameDetections,
    Observation,
    Odometry,
    Path,
    PoseEstimate,
    Posture,
    RecoveryStep,
    Scan,
    Scene,
    Status,
    TrackedPerson,
    TruePerson,
    Truth,
)
from han_bullet.stack import Decision
from han_bullet.world_file import parse_world
from han_bullet.world_schema import CONTROL_PERIOD, CeilingCamera, World

CAMERA = CeilingCamera(name="ceiling", position=(0.0, 0.0, 2.6), look_at=(6.0, 0.0, 0.9))


def make_world(*people: str, **changes: object) -> World:
    """Return an empty 20 m x 4 m room with people of the given names and a robot of radius 0.3 m."""
    document: dict[str, object] = {
        "name": "room",
        "description": "an empty room",
        "floor": [{"x": [0.0, 20.0], "y": [-2.0, 2.0]}],
        "people": [{"name": name, "start": [5.0, 0.0, 0.0], "behaviour": {"kind": "stand"}} for name in people],
        "robot": {"start": [1.0, 0.0, 0.0]},
        "task": {"kind": "go_to", "pose": [18.0, 0.0, 0.0]},
    }
    return parse_world(document | changes)


def person(
    name: str = "walker",
    x: float = 0.0,
    y: float = 0.0,
    yaw: float = 0.0,
    speed: float = 0.0,
    posture: str | None = None,
) -> TruePerson:
    """Return a true person who moves straight ahead; walking where the speed is not zero."""
    velocity = speed * np.array([np.cos(yaw), np.sin(yaw)])
    state = Posture(posture) if posture else (Posture.WALKING if speed else Posture.STANDING)
    return TruePerson(name, Pose2D(x, y, yaw), velocity, state)


def track(
    key: int = 0,
    x: float = 0.0,
    y: float = 0.0,
    *,
    velocity: Sequence[float] = (0.0, 0.0),
    heading: float | None = None,
    posture: str = "standing",
    covariance: np.ndarray | None = None,
) -> TrackedPerson:
    """Return a confirmed track with a deviation of 0.1 m."""
    spread = np.diag([0.01, 0.01, 0.04, 0.04]) if covariance is None else covariance
    return TrackedPerson(key, 0.0, np.array([x, y]), np.array(velocity), spread, Posture(posture), heading)


def frame(camera: CeilingCamera = CAMERA, time: float = 0.0, image: np.ndarray | None = None) -> Frame:
    """Return a frame of a ceiling camera, black unless an image is given."""
    width, height = camera.size
    picture = np.zeros((height, width, 3), np.uint8) if image is None else image
    pose = look_at(np.array(camera.position), np.array(camera.look_at))
    return Frame(camera.name, time, picture, camera.intrinsics, pose, fixed=True)


def found(image: Frame, *boxes: Sequence[float], score: float = 60.0, probability: float = 0.9) -> FrameDetections:
    """Return detections with the given boxes (x, y, width, height) [px]."""
    rows = np.array(boxes, float).reshape(-1, 4)
    found = Detections(rows, np.full(len(rows), score), np.full(len(rows), probability))
    return found.at(image.camera, image.time)


def on_floor(image: Frame, detections: Detections) -> Scan:
    """Return the boxes' bottom centres on the floor."""
    feet = detections.boxes[:, :2] + detections.boxes[:, 2:] * [0.5, 1.0]
    rays = np.column_stack([feet, np.ones(len(feet))]) @ floor_homography(image.intrinsics, image.camera_in_world).T
    covariances = np.tile(0.01 * np.eye(2), (len(feet), 1, 1))
    return scan(rays[:, :2] / rays[:, 2:], image, covariances)


def scan(
    positions: Sequence[Sequence[float]] | np.ndarray, image: Frame, covariances: np.ndarray | None = None
) -> Scan:
    """Return foot points, (n, 2) [m]."""
    points = np.array(positions, float).reshape(-1, 2)
    spread = np.tile(0.01 * np.eye(2), (len(points), 1, 1)) if covariances is None else covariances
    return Scan(image.camera, image.time, points, spread, np.arange(len(points)), image)


def taken(frame: Frame) -> CameraImage:
    """Return the image of a fixed camera's frame as it came."""
    assert frame.fixed
    return CameraImage(frame.camera, frame.time, frame.image, frame.intrinsics, frame.camera_in_world, True)


def tick(
    index: int = 0,
    *,
    robot: Sequence[float] = (0.0, 0.0, 0.0),
    twist: Sequence[float] = (0.0, 0.0, 0.0),
    people: Sequence[TruePerson] = (),
    tracks: Sequence[TrackedPerson] = (),
    contacts: Sequence[Contact] = (),
    devices_on: Sequence[tuple[str, bool]] = (),
    frames: Sequence[Frame] = (),
    believed: Sequence[float] | None = None,
    lost: bool = False,
    detections: Sequence[FrameDetections] = (),
    scans: Sequence[Scan] = (),
    status: Status = Status.MOVING,
    step: RecoveryStep | None = None,
    gave_up: str | None = None,
    costmap: Costmap | None = None,
    path: Path | None = None,
    scene: Scene | None = None,
) -> Tick:
    """Return the tick with a number; its time is the number of control periods."""
    time = index * CONTROL_PERIOD
    pose, velocity = Pose2D(*robot), Twist2D(*twist)
    world_map = Costmap.covering([((0.0, 20.0), (-2.0, 2.0))], 0.1) if costmap is None else costmap
    return Tick(
        Observation(time, Odometry(time, pose, velocity), None, tuple(map(taken, frames))),
        Decision(
            time=time,
            estimate=PoseEstimate(time, pose if believed is None else Pose2D(*believed), lost=lost),
            detections=tuple(detections),
            scans=tuple(scans),
            people=tuple(tracks),
            scene=Scene(time, tuple(tracks)) if scene is None else scene,
            costmap=world_map,
            path=path,
            command=velocity,
            status=status,
            step=step,
            gave_up=gave_up,
        ),
        Truth(time, pose, velocity, tuple(people), tuple(devices_on), tuple(contacts)),
    )
