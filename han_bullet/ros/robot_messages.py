"""The robot itself as ROS messages: odometry, joints, footprint, command, pose with covariance, and its scanner."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from han_bullet.geometry import Array, Pose2D, Twist2D
from han_bullet.mecanum import WHEELS, MecanumWheels
from han_bullet.messages import LaserScan, Odometry, PoseEstimate
from han_bullet.ros.frames import BASE, LASER, MAP, ODOM
from han_bullet.ros.message_types import header, make
from han_bullet.ros.placing import planar_covariance, pose_message, vector
from han_bullet.world_schema import CONTROL_PERIOD, Slip

FOOTPRINT_CORNERS = 24
HEAD = "head_pan"
STILL = 1e-4  # variance of a twist that no slip makes worse [m^2/s^2], [rad^2/s^2]


def twist_message(twist: Twist2D) -> Any:
    """Return a body twist as a geometry_msgs/Twist."""
    return make("geometry_msgs/Twist", linear=vector(twist.vx, twist.vy), angular=vector(0.0, 0.0, twist.omega))


def odometry_message(odometry: Odometry, slip: Slip) -> Any:
    """Return a nav_msgs/Odometry: the pose in the odom frame, the twist in base_link's.

    The covariance of the twist is that of the wheels' usual slip; that of the pose, which grows without bound, is left
    at zero: the way to the map is /tf.
    """
    twist = odometry.twist_robot_in_body
    variances = [(slip.distance * twist.vx) ** 2, (slip.distance * twist.vy) ** 2, (slip.turn * twist.omega) ** 2]
    covariance = planar_covariance(np.diag(variances) + STILL * np.eye(3))
    return make(
        "nav_msgs/Odometry",
        header=header(odometry.time, ODOM),
        child_frame_id=BASE,
        pose=make("geometry_msgs/PoseWithCovariance", pose=pose_message(odometry.pose_robot_in_odom)),
        twist=make("geometry_msgs/TwistWithCovariance", twist=twist_message(twist), covariance=covariance),
    )


def estimate_message(estimate: PoseEstimate) -> Any:
    """Return where the robot believes itself to be as a geometry_msgs/PoseWithCovarianceStamped on the map."""
    covariance = planar_covariance(estimate.covariance)
    pose = pose_message(estimate.pose_robot_in_world)
    return make(
        "geometry_msgs/PoseWithCovarianceStamped",
        header=header(estimate.time, MAP),
        pose=make("geometry_msgs/PoseWithCovariance", pose=pose, covariance=covariance),
    )


def scan_message(scan: LaserScan, period: float) -> Any:
    """Return a sensor_msgs/LaserScan; inf stands for nothing within range_max, as ROS's REP 117 has it.

    Args:
        scan: One sweep.
        period: Between two [s].
    """
    last = scan.angle_min + scan.angle_increment * (len(scan.ranges) - 1)
    return make(
        "sensor_msgs/LaserScan",
        header=header(scan.time, LASER),
        angle_min=scan.angle_min,
        angle_max=last,
        angle_increment=scan.angle_increment,
        scan_time=period,
        range_min=scan.range_min,
        range_max=scan.range_max,
        ranges=scan.ranges.astype(np.float32),
    )


class Footprint:
    """The robot's outline on the map, a circle.

    Args:
        radius: [m].
    """

    def __init__(self, radius: float) -> None:
        angles = np.arange(FOOTPRINT_CORNERS) * (2.0 * math.pi / FOOTPRINT_CORNERS)
        self._corners: Array = radius * np.column_stack([np.cos(angles), np.sin(angles)])

    def at(self, pose_robot_in_world: Pose2D, time: float) -> Any:
        """Return it as a geometry_msgs/PolygonStamped in the map's frame."""
        corners = pose_robot_in_world.to_world(self._corners).tolist()
        points = [make("geometry_msgs/Point32", x=x, y=y) for x, y in corners]
        polygon = make("geometry_msgs/Polygon", points=points)
        return make("geometry_msgs/PolygonStamped", header=header(time, MAP), polygon=polygon)


class Joints:
    """How far the wheels have turned, as the odometry's twists say; the head looks straight ahead.

    Attributes:
        angles: Of the wheels, in the order of WHEELS [rad].
    """

    def __init__(self, wheels: MecanumWheels) -> None:
        self.angles: Sequence[float] = (0.0,) * len(WHEELS)
        self._rates: Sequence[float] = self.angles
        self._wheels = wheels
        self._time: float | None = None

    def advance(self, odometry: Odometry) -> None:
        """Turn the wheels on by the twist that odometry tells of the time since the last."""
        passed = CONTROL_PERIOD if self._time is None else odometry.time - self._time
        self._time = odometry.time
        self._rates = self._wheels.speeds(odometry.twist_robot_in_body)
        turned = (angle + rate * max(passed, 0.0) for angle, rate in zip(self.angles, self._rates, strict=True))
        self.angles = tuple(math.remainder(angle, 2.0 * math.pi) for angle in turned)

    def message(self, time: float) -> Any:
        """Return a sensor_msgs/JointState."""
        return make(
            "sensor_msgs/JointState",
            header=header(time, ""),
            name=[HEAD, *WHEELS],
            position=np.array([0.0, *self.angles]),
            velocity=np.array([0.0, *self._rates]),
        )
