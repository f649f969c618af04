"""A person's motion: constant velocity, driven by white acceleration; filterpy does the algebra."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from filterpy.kalman import predict, update

from han_bullet.geometry import Array

POSITION = slice(0, 2)
VELOCITY = slice(2, 4)

# Of a person's acceleration during one frame [m/s^2]: with twice that, still people seem to move three times as often.
ACCELERATION_DEVIATION = 0.3
# How long one random acceleration lasts [s]: a frame, so that the model means the same at every tick length.
ACCELERATION_INTERVAL = 0.1
# Of each velocity component of a new track [m/s]: indoors people stand or stroll; 1.4 m/s is brisk, and three of these.
INITIAL_SPEED_DEVIATION = 0.5

_MEASURES_POSITION = np.eye(2, 4)
# Of a state's matrices, the blocks of the positions, of the velocities, and from velocities to positions.
_POSITIONS, _VELOCITIES = np.diag([1.0, 1.0, 0.0, 0.0]), np.diag([0.0, 0.0, 1.0, 1.0])
_FROM_VELOCITY = np.eye(4, k=2)


@dataclass(frozen=True)
class MotionState:
    """Where a person is and how they move, with its uncertainty.

    Attributes:
        mean: (x, y, vx, vy), shape (4,) [m, m/s].
        covariance: Shape (4, 4).
    """

    mean: Array
    covariance: Array

    @property
    def position(self) -> Array:
        """Return (x, y), shape (2,) [m]."""
        return self.mean[POSITION]

    @property
    def velocity(self) -> Array:
        """Return (vx, vy), shape (2,) [m/s]."""
        return self.mean[VELOCITY]

    @property
    def position_covariance(self) -> Array:
        """Return the covariance of the position, shape (2, 2) [m^2]."""
        return self.covariance[POSITION, POSITION]

    @property
    def velocity_covariance(self) -> Array:
        """Return the covariance of the velocity, shape (2, 2) [m^2/s^2]."""
        return self.covariance[VELOCITY, VELOCITY]


class ConstantVelocity:
    """Predict and correct motion states under white acceleration [BarShalom2001].

    The process noise is the continuous model's, q [[t^3/3, t^2/2], [t^2/2, t]] per axis with q = deviation^2 *
    `ACCELERATION_INTERVAL`: two short predictions are the same as one long one.

    Args:
        acceleration_deviation: [m/s^2].
        initial_speed_deviation: Of each velocity component of a new state [m/s].
    """

    def __init__(
        self,
        *,
        acceleration_deviation: float = ACCELERATION_DEVIATION,
        initial_speed_deviation: float = INITIAL_SPEED_DEVIATION,
    ) -> None:
        self.density = acceleration_deviation**2 * ACCELERATION_INTERVAL
        self.initial_speed_deviation = initial_speed_deviation

    def start(self, position: Array, covariance: Array) -> MotionState:
        """Return the state of someone seen once, at a position (2,) [m] with a covariance (2, 2), velocity unknown."""
        whole = np.zeros((4, 4))
        whole[POSITION, POSITION] = covariance
        whole[VELOCITY, VELOCITY] = self.initial_speed_deviation**2 * np.eye(2)
        return MotionState(np.array([*position, 0.0, 0.0]), whole)

    def predict(self, state: MotionState, duration: float) -> MotionState:
        """Return the state after a duration [s]; a duration of zero or less changes nothing."""
        if duration <= 0.0:
            return state
        transition = np.eye(4) + duration * _FROM_VELOCITY
        across = self.density * duration**2 / 2.0
        noise = (self.density * duration**3 / 3.0) * _POSITIONS + (self.density * duration) * _VELOCITIES
        noise += across * (_FROM_VELOCITY + _FROM_VELOCITY.T)
        return MotionState(*predict(state.mean, state.covariance, F=transition, Q=noise))

    def correct(self, state: MotionState, position: Array, covariance: Array) -> MotionState:
        """Return the state after a position (2,) [m] was measured with a covariance (2, 2) (Joseph form)."""
        mean, whole = update(state.mean, state.covariance, position, covariance, H=_MEASURES_POSITION)
        return MotionState(mean, 0.5 * (whole + whole.T))
