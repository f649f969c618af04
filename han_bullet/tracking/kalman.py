"""A person's motion: constant velocity, driven by white acceleration; filterpy does the algebra.

Beside it, how much taller they look than people are assumed to be: an error that all places by their head share, so
that a hundred of these know no more of the distance than one, but show every step towards the camera or away from it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from filterpy.kalman import predict, update

from han_bullet.errors import check_positive
from han_bullet.geometry import Array

POSITION = slice(0, 2)
VELOCITY = slice(2, 4)
MOTION = slice(0, 4)
HEIGHT = 4

# Of a person's acceleration during one frame [m/s^2]: with twice that, still people seem to move three times as often.
ACCELERATION_DEVIATION = 0.3
# How long one random acceleration lasts [s]: a frame, so that the model means the same at every tick length.
ACCELERATION_INTERVAL = 0.1
# Of each velocity component of a new track [m/s]: indoors people stand or stroll; 1.4 m/s is brisk, and three of these.
INITIAL_SPEED_DEVIATION = 0.5
# Of adults' heights together with the upper edge of their box [m]: 1055 boxes of whole people have 0.07.
HEIGHT_DEVIATION = 0.1
# How long such an error lasts [s]: a body's for ever, a box's until the detector takes to another scale.
HEIGHT_TIME = 10.0

# Of a state's matrices, the blocks of the positions, of the velocities, and from velocities to positions.
_POSITIONS, _VELOCITIES = np.diag([1.0, 1.0, 0.0, 0.0, 0.0]), np.diag([0.0, 0.0, 1.0, 1.0, 0.0])
_FROM_VELOCITY = np.diag([1.0, 1.0, 0.0], k=2)
# Of a position that is not told by the head.
NO_SHIFT: Array = np.zeros(2)


@dataclass(frozen=True)
class MotionState:
    """Where a person is and how they move, with its uncertainty.

    Attributes:
        mean: (x, y, vx, vy, taller), shape (5,) [m, m/s, m]; the last one is by how much they look taller than assumed.
        covariance: Shape (5, 5).
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

    @property
    def motion_covariance(self) -> Array:
        """Return the covariance of (x, y, vx, vy), shape (4, 4)."""
        return self.covariance[MOTION, MOTION]


class ConstantVelocity:
    """Predict and correct motion states under white acceleration [BarShalom2001].

    The process noise is the continuous model's, q [[t^3/3, t^2/2], [t^2/2, t]] per axis with q = deviation^2 *
    `ACCELERATION_INTERVAL`: two short predictions are the same as one long one.

    Args:
        acceleration_deviation: [m/s^2].
        initial_speed_deviation: Of each velocity component of a new state [m/s].

    Raises:
        BadInputError: One of them is not positive.
    """

    def __init__(
        self,
        *,
        acceleration_deviation: float = ACCELERATION_DEVIATION,
        initial_speed_deviation: float = INITIAL_SPEED_DEVIATION,
    ) -> None:
        check_positive("motion model", acceleration_deviation=acceleration_deviation)
        check_positive("motion model", initial_speed_deviation=initial_speed_deviation)
        self.density = acceleration_deviation**2 * ACCELERATION_INTERVAL
        self.initial_speed_deviation = initial_speed_deviation

    def start(self, position: Array, covariance: Array, per_height: Array = NO_SHIFT) -> MotionState:
        """Return the state of someone seen once, velocity unknown.

        Args:
            position: Measured, shape (2,) [m].
            covariance: Of it, whatever the person's height, shape (2, 2) [m^2].
            per_height: How far the position is off per metre that the person looks taller than assumed, shape (2,).
        """
        variance = HEIGHT_DEVIATION**2
        whole = np.diag([0.0, 0.0, *2 * [self.initial_speed_deviation**2], variance])
        whole[POSITION, POSITION] = covariance
        whole[POSITION, HEIGHT] = whole[HEIGHT, POSITION] = -variance * per_height
        return MotionState(np.array([*position, 0.0, 0.0, 0.0]), whole)

    def predict(self, state: MotionState, duration: float) -> MotionState:
        """Return the state after a duration [s]; a duration of zero or less changes nothing."""
        if duration <= 0.0:
            return state
        kept = math.exp(-duration / HEIGHT_TIME)
        transition = np.diag([1.0, 1.0, 1.0, 1.0, kept]) + duration * _FROM_VELOCITY
        across = self.density * duration**2 / 2.0
        noise = (self.density * duration**3 / 3.0) * _POSITIONS + (self.density * duration) * _VELOCITIES
        noise += across * (_FROM_VELOCITY + _FROM_VELOCITY.T)
        noise[HEIGHT, HEIGHT] = (1.0 - kept**2) * HEIGHT_DEVIATION**2
        return MotionState(*predict(state.mean, state.covariance, F=transition, Q=noise))

    def correct(
        self, state: MotionState, position: Array, covariance: Array, per_height: Array = NO_SHIFT
    ) -> MotionState:
        """Return the state after a position was measured (Joseph form); for the arguments see `start`."""
        measures = np.column_stack([np.eye(2, 4), per_height])
        own = covariance - HEIGHT_DEVIATION**2 * np.outer(per_height, per_height)
        mean, whole = update(state.mean, state.covariance, position, own, H=measures)
        return MotionState(mean, 0.5 * (whole + whole.T))
