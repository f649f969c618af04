"""Every value that passes between the stages of the loop; read this file first.

All are frozen dataclasses in SI units. Names say the frame. Arrays have the stated shape; state vectors are 1-D.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array, Intrinsics, Pose2D, Twist2D


@dataclass(frozen=True)
class CameraImage:
    """One image as it comes from a camera, which knows how it is mounted and not where the robot is.

    Attributes:
        camera: Name of the camera.
        time: Moment of exposure [s].
        image: RGB, shape (height, width, 3), uint8.
        intrinsics: Calibration.
        mount: Pose of the camera, shape (4, 4): in the world if it is fixed there, else in the robot's body.
        fixed: Whether the camera never moves.
    """

    camera: str
    time: float
    image: NDArray[np.uint8]
    intrinsics: Intrinsics
    mount: Array
    fixed: bool

    def placed(self, pose_robot_in_world: Pose2D) -> Frame:
        """Return the same as of a camera in the world, the robot having been at a pose when it was exposed."""
        camera_in_world = self.mount if self.fixed else pose_robot_in_world.matrix() @ self.mount
        return Frame(self.camera, self.time, self.image, self.intrinsics, camera_in_world, self.fixed)


@dataclass(frozen=True)
class Frame:
    """One image of one camera, with what is known of the camera.

    Attributes:
        camera: Name of the camera.
        time: Moment of exposure [s].
        image: RGB, shape (height, width, 3), uint8.
        intrinsics: Calibration.
        camera_in_world: Pose, shape (4, 4); of an onboard camera as the robot's localization has it.
        fixed: Whether the camera never moves.
    """

    camera: str
    time: float
    image: NDArray[np.uint8]
    intrinsics: Intrinsics
    camera_in_world: Array
    fixed: bool


@dataclass(frozen=True)
class DeviceMessage:
    """What a networked device says of itself.

    Attributes:
        device: Name.
        time: When it was sent, by the sender's clock [s].
        on: Whether it is switched on.
        session: Names the sender, anew whenever its clock begins anew; may be empty.
    """

    device: str
    time: float
    on: bool
    session: str = ""


@dataclass(frozen=True)
class LaserScan:
    """One sweep of a planar laser scanner, level with the floor; the terms are those of ROS's sensor_msgs/LaserScan.

    Attributes:
        time: Of the sweep, which takes none [s].
        ranges: From the scanner, counter-clockwise, shape (n,) [m]; inf where nothing is within range_max.
        angle_min: Direction of the first ray in the scanner's frame [rad].
        angle_increment: Between neighbouring rays [rad].
        range_min: What is nearer shows at this range [m].
        range_max: Farther than this nothing is measured [m].
        scanner_in_body: Where the scanner is on the robot.
    """

    time: float
    ranges: Array
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    scanner_in_body: Pose2D

    @functools.cached_property
    def angles(self) -> Array:
        """Return the directions of the rays in the scanner's frame, shape (n,) [rad]."""
        angles: Array = self.angle_min + self.angle_increment * np.arange(len(self.ranges), dtype=np.float64)
        return angles

    @functools.cached_property
    def points_in_body(self) -> Array:
        """Return where the rays that met something ended, shape (m, 2) [m]."""
        met = np.isfinite(self.ranges)
        ranges, angles = self.ranges[met, None], self.angles[met]
        return self.scanner_in_body.to_world(ranges * np.column_stack([np.cos(angles), np.sin(angles)]))


@dataclass(frozen=True)
class Odometry:
    """Where the wheels say that the robot is: smooth, and drifting.

    Attributes:
        time: [s].
        pose_robot_in_odom: Since the start, which is the odom frame's origin.
        twist_robot_in_body: As the wheels turn.
    """

    time: float
    pose_robot_in_odom: Pose2D
    twist_robot_in_body: Twist2D


@dataclass(frozen=True)
class PoseEstimate:
    """Where the robot believes itself to be.

    Attributes:
        time: [s].
        pose_robot_in_world: The best guess.
        covariance: Of (x, y, yaw) in the world, shape (3, 3) [m^2, m rad, rad^2].
        lost: Whether what is sensed does not fit to this pose, or to too many: the robot must not drive by it.
    """

    time: float
    pose_robot_in_world: Pose2D
    covariance: Array = field(default_factory=lambda: np.zeros((3, 3)))
    lost: bool = False


@dataclass(frozen=True)
class Observation:
    """All that the robot may know at one control tick. Nothing of the simulator's truth is in here.

    Attributes:
        time: Simulation time [s].
        odometry: Of the wheels, at this tick.
        laser: The sweep that ended at this tick; None between two, and without a scanner.
        images: Those that became available at this tick, in the order of the cameras; often none.
        device_messages: Payloads that arrived since the last tick, as they came (`device_payload`).
    """

    time: float
    odometry: Odometry
    laser: LaserScan | None = None
    images: tuple[CameraImage, ...] = ()
    device_messages: tuple[bytes, ...] = ()


@dataclass(frozen=True)
class ImageHealth:
    """What the pixels of one frame tell of the camera itself; small, so that it travels where the image does not.

    Attributes:
        checksum: Of a sample of the pixels; two images with noise have the same by a chance of 1 in 4e9.
        brightness: Mean of the image [grey levels].
        contrast: Standard deviation of its coarse parts, whose noise is averaged away [grey levels].
        shift: How far the scene that a fixed camera knows has moved in the image, to the right and down, [px]; (0, 0)
            where no shift explains what differs, and for a camera without a known scene.
    """

    checksum: int
    brightness: float
    contrast: float
    shift: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Fault:
    """What the robot has noticed of one of its sensors.

    Attributes:
        sensor: A camera or a device by its name, or "laser", "wheels".
        kind: Such as "frozen", "black", "dropped", "late", "knocked", "slip", "silent".
        since: When it was noticed [s].
    """

    sensor: str
    kind: str
    since: float


@dataclass(frozen=True)
class Detections:
    """People found in one image, by falling score.

    Attributes:
        boxes: Shape (n, 4): x, y of the upper left corner, width, height [px].
        scores: How sure the detector is, on a scale of its own, shape (n,).
        probabilities: Of being a person, shape (n,), in [0, 1]; 1 where the detector gives none.
        feet: Rows of the image where the feet end [px], where the camera knows them better than by the box; NaN where
            not, shape (n,). None: nowhere.
        empty_seats: Names of sitting areas that the image shows to be empty; of others it tells nothing.
    """

    boxes: Array
    scores: Array
    probabilities: Array
    feet: Array | None = field(default=None, kw_only=True)
    empty_seats: tuple[str, ...] = field(default=(), kw_only=True)

    @classmethod
    def none(cls) -> Detections:
        """Return the detections of an image without people."""
        return cls(np.zeros((0, 4)), np.zeros(0), np.zeros(0))

    def select(self, rows: NDArray[np.bool_] | NDArray[np.int64]) -> Detections:
        """Return some of them: a mask, shape (n,), or row numbers in their new order."""
        feet = None if self.feet is None else self.feet[rows]
        return Detections(
            self.boxes[rows], self.scores[rows], self.probabilities[rows], feet=feet, empty_seats=self.empty_seats
        )

    def at(self, camera: str, time: float, health: ImageHealth | None = None) -> FrameDetections:
        """Return the same as those of a camera's frame, exposed at a time [s], with what its pixels tell."""
        return FrameDetections(
            self.boxes,
            self.scores,
            self.probabilities,
            camera,
            time,
            health,
            feet=self.feet,
            empty_seats=self.empty_seats,
        )


@dataclass(frozen=True)
class FrameDetections(Detections):
    """People found in one frame of one camera.

    Attributes:
        camera: Name of the camera.
        time: Moment of exposure [s].
        health: What its pixels tell of the camera; None where nobody looked.
    """

    camera: str
    time: float
    health: ImageHealth | None = None


@dataclass(frozen=True)
class Scan:
    """The detections of one frame on the floor.

    Attributes:
        camera: Name of the camera.
        time: Moment of exposure [s].
        positions: Foot points in the world, shape (n, 2) [m].
        covariances: Shape (n, 2, 2) [m^2].
        sources: Row of the detection behind each measurement, shape (n,), int.
        frame: The image's camera, for what it can see.
        pose_robot_in_world: Of the robot, which may stand in the view; None where it is not known.
        empty_seats: Names of sitting areas that the image shows to be empty.
        per_height: How far positions are off per metre that the person looks taller than assumed, shape (n, 2); zero
            where the head did not tell them. The covariances hold what people's heights make of it. None: all zero.
    """

    camera: str
    time: float
    positions: Array
    covariances: Array
    sources: NDArray[np.int64]
    frame: Frame
    pose_robot_in_world: Pose2D | None = None
    empty_seats: tuple[str, ...] = ()
    per_height: Array | None = None


@dataclass(frozen=True)
class LegScan:
    """What one sweep of the laser says of people near the robot.

    Attributes:
        time: Of the sweep [s].
        positions: Of people by their legs, or of what looks like legs, in the world, shape (n, 2) [m].
        covariances: Shape (n, 2, 2) [m^2].
        vacant: Ids of the people whose place is empty.
        camera: Stands for the laser where cameras have their names.
    """

    time: float
    positions: Array
    covariances: Array
    vacant: tuple[int, ...] = ()
    camera: str = "laser"


class Posture(str, Enum):
    """What a person is doing, as the layers distinguish it."""

    STANDING = "standing"
    WALKING = "walking"
    SEATED = "seated"


@dataclass(frozen=True)
class TrackedPerson:
    """A person as the tracker believes them to be.

    Attributes:
        id: Counts from 0 within one tracker.
        time: Of this estimate [s].
        position_in_world: Shape (2,) [m]; for a seated person the declared seat.
        velocity_in_world: Shape (2,) [m/s].
        covariance: Of (x, y, vx, vy), shape (4, 4).
        posture: Standing, walking or seated.
        heading: Direction the person faces [rad]; None where nobody knows.
        seat: Name of the sitting area for a seated person, else None.
    """

    id: int
    time: float
    position_in_world: Array
    velocity_in_world: Array
    covariance: Array
    posture: Posture
    heading: float | None
    seat: str | None = None

    @property
    def speed(self) -> float:
        """Return the speed [m/s]."""
        return float(np.hypot(*self.velocity_in_world))


@dataclass(frozen=True)
class Device:
    """A device as the robot knows it: place from the map, state from its messages.

    Attributes:
        name: As in the world file.
        position_in_world: Shape (2,) [m].
        on: Last reported state.
    """

    name: str
    position_in_world: Array
    on: bool


@dataclass(frozen=True)
class Seat:
    """A sitting area of the map.

    Attributes:
        name: As in the world file.
        position_in_world: Where a seated person's body is, shape (2,) [m].
        facing: Direction in which they sit [rad].
        reach_in_front: How far before the seat a seated person's feet are looked for [m].
        width: Extent along the seat [m].
        watches: Name of the device they look at, or None.
    """

    name: str
    position_in_world: Array
    facing: float
    reach_in_front: float
    width: float
    watches: str | None = None


@dataclass(frozen=True)
class GoTo:
    """Task: reach a pose.

    Attributes:
        pose_in_world: The goal.
    """

    pose_in_world: Pose2D

    @property
    def goal_in_world(self) -> Array:
        """Return where the task leads, shape (2,) [m]."""
        return self.pose_in_world.position


@dataclass(frozen=True)
class HandOver:
    """Task: approach the person near a place from the front and stop before them.

    Attributes:
        place_in_world: Where the person is expected, shape (2,) [m].
        distance: Between the centres at the stop [m].
        person: Id of the chosen track while there is one; of an order, whom it is for, wherever they are.
        heading: Direction that the chosen person is taken to face [rad], once it is known.
        position_in_world: Where the chosen person was last believed to be, shape (2,) [m], once it is known.
    """

    place_in_world: Array
    distance: float = 0.9
    person: int | None = None
    heading: float | None = None
    position_in_world: Array | None = None

    @property
    def goal_in_world(self) -> Array:
        """Return where the task leads, shape (2,) [m]."""
        return self.place_in_world if self.position_in_world is None else self.position_in_world


Task = GoTo | HandOver


@dataclass(frozen=True)
class Order:
    """What somebody outside told the running robot.

    Attributes:
        name: "go_to", "hand_over", "cancel", "clear_obstacles" or "drive".
        task: Of the first two; a hand-over to a person by id has the place where they were then.
    """

    name: str
    task: Task | None = None


@dataclass(frozen=True)
class Scene:
    """All that a costmap layer may look at.

    Attributes:
        time: [s].
        people: Confirmed tracks.
        devices: Known devices.
        seats: Sitting areas of the map.
        task: What the robot is doing.
        pose_robot_in_world: Where it is; None where it is not known.
        laser: The scan that has come, or None.
        pose_robot_at_scan: Where the robot was in the world when it was taken; None: where it is.
    """

    time: float
    people: tuple[TrackedPerson, ...] = ()
    devices: tuple[Device, ...] = ()
    seats: tuple[Seat, ...] = ()
    task: Task | None = None
    pose_robot_in_world: Pose2D | None = None
    laser: LaserScan | None = None
    pose_robot_at_scan: Pose2D | None = None


@dataclass(frozen=True)
class Path:
    """A way on the floor; it may end short of the goal, at the edge of somebody's space.

    Attributes:
        points_in_world: Shape (n, 2) [m], start first. A planned one begins at the robot, the rest are cell centres one
            cell apart; to the first of them, and where a kept way was led on to a goal that has moved, it may be as far
            as the planner's JOIN and a cell. What A* found alone has cell centres only; what the follower makes, at a
            goal that is blocked, is the robot's place and the goal's.
        cost: Integral of 1 + weight * cost / 252 along it, in blocked cells of A*'s ESCAPE_COST [m]; the follower's
            has 0.
        expanded: Cells that a search took from its queue; 0 where the way was kept without one.
    """

    points_in_world: Array
    cost: float
    expanded: int = 0


class Status(str, Enum):
    """What the robot is up to."""

    MOVING = "moving"
    WAITING = "waiting: the way or the goal is not free"
    YIELDING = "yielding: a person is in the way"
    LOOKING = "looking for the person of the task"
    ARRIVED = "arrived"
    LOST = "lost: what the laser sees does not fit to the map"
    BLOCKED = "blocked"
    PROTECTIVE_STOP = "braking: something is too near"
    BLIND = "stopped: no sensor works"
    IDLE = "idle: it has no task"
    TELEOPERATED = "teleoperated: somebody drives it"


class RecoveryStep(str, Enum):
    """What a robot does that cannot go on, in the order in which it is tried."""

    WAIT = "waits"
    CLEAR = "clears the obstacle layer"
    ASK = "asks people to make way"
    RELOCALIZE = "looks for itself on the whole map"
    GIVE_UP = "gives up"


@dataclass(frozen=True)
class TruePerson:
    """A person as the simulator knows them; goes to metrics and video only.

    Attributes:
        name: As in the world file.
        pose_in_world: Position and direction faced.
        velocity_in_world: Shape (2,) [m/s].
        posture: Standing, walking or seated.
    """

    name: str
    pose_in_world: Pose2D
    velocity_in_world: Array
    posture: Posture


@dataclass(frozen=True)
class Contact:
    """The robot touches something.

    Attributes:
        body: Name of the person, piece of furniture or wall.
        kind: "person", "object" or "wall".
        distance: Signed gap, <= 0 [m].
    """

    body: str
    kind: str
    distance: float


@dataclass(frozen=True)
class Truth:
    """The simulator's own state; reaches metrics, trace and video, never the stack.

    Attributes:
        time: [s].
        pose_robot_in_world: The robot.
        twist_robot_in_body: Its velocity.
        people: In the order of the world file.
        devices_on: State of each device.
        contacts: What the robot touches.
        taken_away: Names of the furniture that is no longer there.
    """

    time: float
    pose_robot_in_world: Pose2D
    twist_robot_in_body: Twist2D
    people: tuple[TruePerson, ...]
    devices_on: tuple[tuple[str, bool], ...] = ()
    contacts: tuple[Contact, ...] = ()
    taken_away: tuple[str, ...] = ()
