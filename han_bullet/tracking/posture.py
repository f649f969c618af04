"""Standing, walking or seated, and which way a person faces: decided from a noisy track without flickering."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from han_bullet.geometry import Array, largest_deviation
from han_bullet.messages import Posture, Seat
from han_bullet.tracking.kalman import MotionState
from han_bullet.tracking.seats import in_sitting_area

# Faster than this may be walking [m/s]: a still person's track exceeds 0.1 m/s in up to half of the scans.
WALKING_SPEED = 0.2
# By how many of its own deviations the speed must differ from zero.
WALKING_SIGMAS = 3.0
# Net way within `SHIFT_TIME` [m]: noise swings to and fro, walking goes on.
WALKING_SHIFT = 0.2
# [s].
SHIFT_TIME = 1.0
# Slower than this is standing [m/s], as in [Mateus2019].
STANDING_SPEED = 0.1
# Less net way than this within `SHIFT_TIME` is standing too [m]: who stops short overshoots in the track and comes
# back, so that by the speed alone they would walk on for 2.3 s (median); so it is 1.5 s.
STANDING_SHIFT = 0.1
# For how long one of the two must hold [s].
STANDING_TIME = 0.5
# A heading is remembered once somebody has walked for so long [s]: earlier the velocity still turns.
HEADING_TIME = 1.0
# How far outside the sitting area a seated person's foot point may stray [m].
SEAT_MARGIN = 0.2


@dataclass(frozen=True)
class Stance:
    """What a person is doing.

    Attributes:
        posture: Standing, walking or seated.
        heading: Direction the person faces [rad], None where nobody knows.
        seat: Where a seated person sits.
    """

    posture: Posture
    heading: float | None = None
    seat: Seat | None = None


class PostureEstimator:
    """Follow one person's posture and heading.

    Args:
        seats: Sitting areas of the map.
    """

    def __init__(self, seats: Sequence[Seat] = ()) -> None:
        self.seats = tuple(seats)
        self.stance = Stance(Posture.STANDING)
        self._remembered_heading: float | None = None
        self._walking_since = math.inf
        self._still_since = math.inf
        self._trail: deque[tuple[float, Array]] = deque()

    def update(self, time: float, state: MotionState) -> Stance:
        """Take in the track's state at a time [s], not before the last one, and return the stance."""
        self._trail.append((time, state.position))
        while len(self._trail) > 1 and self._trail[1][0] <= time - SHIFT_TIME + 1e-9:
            self._trail.popleft()
        speed = float(np.hypot(*state.velocity))
        shift = float(np.hypot(*(state.position - self._trail[0][1])))
        still = speed < STANDING_SPEED or shift < STANDING_SHIFT
        self._still_since = min(self._still_since, time) if still else math.inf
        if self.stance.posture is Posture.WALKING:
            if time - self._still_since >= STANDING_TIME - 1e-9:
                self._walking_since = math.inf
        elif self._sets_off(speed, shift, state):
            self._walking_since = time
        self.stance = self._walking(time, speed, state) if self._walking_since <= time else self._still(state)
        return self.stance

    def _sets_off(self, speed: float, shift: float, state: MotionState) -> bool:
        """Tell whether somebody still has begun to walk."""
        significant = speed > WALKING_SIGMAS * speed_deviation(state)
        return speed > WALKING_SPEED and shift > WALKING_SHIFT and significant

    def _walking(self, time: float, speed: float, state: MotionState) -> Stance:
        heading = self.stance.heading
        if speed > WALKING_SPEED:  # slower, as when somebody stops, the velocity's direction is noise
            heading = math.atan2(state.velocity[1], state.velocity[0])
            if time - self._walking_since >= HEADING_TIME - 1e-9:
                self._remembered_heading = heading
        return Stance(Posture.WALKING, heading)

    def _still(self, state: MotionState) -> Stance:
        for seat in self.seats:
            margin = SEAT_MARGIN if seat is self.stance.seat else 0.0
            if in_sitting_area(seat, state.position, margin):
                return Stance(Posture.SEATED, seat.facing, seat)
        return Stance(Posture.STANDING, self._remembered_heading)


def speed_deviation(state: MotionState) -> float:
    """Return the standard deviation of a state's speed along its own direction [m/s]; of a still one, the largest."""
    speed = float(np.hypot(*state.velocity))
    if speed < 1e-9:
        return largest_deviation(state.velocity_covariance)
    direction = state.velocity / speed
    return math.sqrt(float(direction @ state.velocity_covariance @ direction))
