"""Odometry of four mecanum wheels, with a slip of its own.

Rollers slip and floors differ: what the wheels tell of a way differs from the way. The model keeps to what can be
stated and tested, with `Slip` as the standard deviations: ways forward and sideways are each wrong by a factor that is
drawn once for the run, and so is the angle turned; besides, the heading walks at random with the distance driven.
"""

from __future__ import annotations

import math

import numpy as np

from han_bullet.geometry import Pose2D, Twist2D, moved, twist_between
from han_bullet.mecanum import MecanumWheels
from han_bullet.messages import Odometry
from han_bullet.world_schema import CONTROL_PERIOD, Slip


class WheelOdometry:
    """Add up the robot's way as its wheels tell it.

    Pose and twist agree: a pose follows from the last one by its twist, held over the control period. The twist is
    thus the mean over that period. Without slip, the pose is the way itself.
    """

    def __init__(
        self, wheels: MecanumWheels, slip: Slip, start_pose_in_world: Pose2D, rng: np.random.Generator
    ) -> None:
        """Stand still at the start, the odom frame's origin.

        Args:
            wheels: Their geometry.
            slip: Standard deviations of the errors.
            start_pose_in_world: Where the robot truly is.
            rng: For the slip.
        """
        self._wheels = wheels
        self._heading_deviation = slip.heading
        self._rng = rng
        deviations = [slip.distance, slip.distance, slip.turn]
        self._errors: list[float] = rng.normal(0.0, deviations).tolist()  # forward, sideways, of turns; relative
        self._true_pose = start_pose_in_world
        self._pose_in_odom = Pose2D(0.0, 0.0, 0.0)
        self._twist = Twist2D()

    def read(self, time: float) -> Odometry:
        """Return what is known at a time [s]."""
        return Odometry(time, self._pose_in_odom, self._twist)

    def advance(self, pose_robot_in_world: Pose2D, times: float = 1.0) -> None:
        """Add the way of one control period, to where the robot truly is now, with so many times the usual slip."""
        true_twist = twist_between(self._true_pose, pose_robot_in_world, CONTROL_PERIOD)
        self._true_pose = pose_robot_in_world
        self._twist = self._slipped(self._wheels.twist(self._wheels.speeds(true_twist)), times)
        self._pose_in_odom = moved(self._pose_in_odom, self._twist, CONTROL_PERIOD)

    def _slipped(self, twist: Twist2D, times: float) -> Twist2D:
        """Return a period's twist with its errors, so many times as large."""
        deviation = times * self._heading_deviation * math.sqrt(twist.speed * CONTROL_PERIOD)
        drift = deviation * float(self._rng.standard_normal()) / CONTROL_PERIOD
        forward, sideways, turn = ((1.0 + times * error) for error in self._errors)
        return Twist2D(twist.vx * forward, twist.vy * sideways, twist.omega * turn + drift)
