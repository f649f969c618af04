"""The pose between scans: a Kalman filter of the pose and of the wheels' slip."""

from __future__ import annotations

import numpy as np

from han_bullet.geometry import Array, Pose2D, rotation, wrap_angle
from han_bullet.localization.odometry_model import OdometryModel


class PoseFilter:
    """Believe in a Gaussian of x, y, yaw and the factors by which the wheels measure ways forward and sideways wrong.

    The factors are the same for long, so after ten metres along a bare corridor the place is as uncertain as they are:
    its deviation grows with the way, not with the way's square root. Where scans tell the place again, they tell the
    factors, too.

    Attributes:
        pose: In the world.
    """

    def __init__(self, pose: Pose2D, covariance: Array, model: OdometryModel) -> None:
        """Start with a pose, its covariance, (3, 3) [m^2, m rad, rad^2], and unknown slip."""
        self.pose = pose
        self._model = model
        self._slip = np.zeros(2)  # what is to be added per metre measured, forward and sideways
        self._covariance = np.diag([0.0, 0.0, 0.0, model.slip**2, model.slip**2])
        self._covariance[:3, :3] = covariance

    @property
    def covariance(self) -> Array:
        """Return the covariance of x, y and yaw, shape (3, 3) [m^2, m rad, rad^2]."""
        return self._covariance[:3, :3].copy()

    def move(self, step: Pose2D) -> None:
        """Go a step that the odometry measured in the body frame."""
        x, y = np.array([step.x, step.y]) * (1.0 + self._slip)
        after = self.pose.compose(Pose2D(float(x), float(y), step.yaw))
        jacobian, turn = np.eye(5), rotation(self.pose.yaw)
        jacobian[:2, 2] = self.pose.y - after.y, after.x - self.pose.x
        jacobian[:2, 3:] = turn * [step.x, step.y]
        self._covariance = jacobian @ self._covariance @ jacobian.T
        noise = np.diag(self._model.variances(step))
        noise[:2, :2] = turn @ noise[:2, :2] @ turn.T
        self._covariance[:3, :3] += noise
        self.pose = after

    def take_in(self, pose: Pose2D, covariance: Array) -> None:
        """Believe a pose with covariance that a scan made of the believed one; what depends on the pose follows.

        With P the covariance before and G = P_all,pose P_pose,pose^-1, the mean moves by G times the pose's move, and
        P <- P - G (P_pose,pose - covariance) G^T.
        """
        before = self._covariance[:3, :3]
        gain = np.linalg.solve(before, self._covariance[:3, :]).T
        moved = np.array([pose.x - self.pose.x, pose.y - self.pose.y, wrap_angle(pose.yaw - self.pose.yaw)])
        self._slip = self._slip + gain[3:] @ moved
        after = self._covariance - gain @ (before - covariance) @ gain.T
        self._covariance = 0.5 * (after + after.T)
        self.pose = pose
