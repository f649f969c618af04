"""Whether a camera on the robot looks where it should: its bearings of people against those that others tell."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from han_bullet.geometry import Array, wrap_angle
from han_bullet.health.watch import Watch
from han_bullet.messages import Fault, LegScan, Scan, Seat, TrackedPerson

# Who is meant is whom the other sees within this of the camera's bearing and of its distance.
GATE = math.radians(15.0)
GATE_ALONG = 0.2  # of the distance: feet that only the box tells err by a tenth
WITHIN = 0.1  # [s]: a period, as cameras need not look at the same moment; people go on as they went
NEAREST = 2.0  # [m]: a decimetre of a body is 3 degrees there
APART = 0.5  # [m]: others that place somebody farther apart mean different people
# Of the last samples so many must agree. One errs by 0.4 degrees, and those of one person together: in 175 runs without
# fault four of five were never beyond 1.4 degrees to the same side.
SAMPLES, AGREEING = 5, 4
TURNED, STRAIGHT = math.radians(2.0), math.radians(1.5)  # beyond is a fault, within it is over


class Alignment:
    """Watch where one camera on the robot looks.

    A sample is how far to the left of where fixed cameras and the laser see somebody at the same time the camera sees
    them. Nobody who may sit gives one: some are placed on their seat and some before it, half a metre apart.

    Args:
        camera: Name.
        seats: Where people may sit.
    """

    def __init__(self, camera: str, seats: Sequence[Seat] = ()) -> None:
        self._seats = tuple(seats)
        self._samples: deque[float] = deque(maxlen=SAMPLES)  # [rad]
        self._watch = Watch(camera, "knocked")

    @property
    def fault(self) -> Fault | None:
        """Return that the camera is knocked, while it is."""
        return self._watch.fault

    @property
    def samples(self) -> tuple[float, ...]:
        """Return the last ones [rad], oldest first."""
        return tuple(self._samples)

    def close_tick(self, time: float) -> None:
        """Judge at a time [s] by the samples there are."""
        self._watch.update(self._is_turned(), time)

    def compare(self, scan: Scan, others: Sequence[Scan | LegScan], people: Sequence[TrackedPerson]) -> None:
        """Take samples of whom the camera and others see at the same time.

        Args:
            scan: Of the camera.
            others: The last of each fixed camera and of the laser.
            people: All who are known, doubles included that a knocked camera has made.
        """
        if not len(scan.positions):
            return
        eye = scan.frame.camera_in_world[:2, 3]
        others = [other for other in others if abs(other.time - scan.time) <= WITHIN + 1e-6]
        known = np.array([person.position_in_world for person in people]).reshape(-1, 2)
        velocities = np.array([person.velocity_in_world for person in people]).reshape(-1, 2)
        for row, position in enumerate(scan.positions):
            rivals = np.delete(scan.positions, row, axis=0)
            meant = _near(eye, position, known)
            if self._may_sit(position) or _near(eye, position, rivals).any() or _are_several(eye, known[meant]):
                continue
            velocity = velocities[meant].sum(axis=0) / max(meant.sum(), 1)
            place = _place_by(others, eye, position, scan.time, velocity)
            if place is not None and not _near(eye, place, rivals).any() and not self._may_sit(place):
                self._samples.append(_turn(eye, place, position))

    def _is_turned(self) -> bool:
        """Tell whether the samples say so; while they do not say the contrary, a knocked camera stays one."""
        if len(self._samples) < SAMPLES:
            return False
        samples = sorted(self._samples)
        if self.fault is not None:
            return abs(samples[SAMPLES // 2]) > STRAIGHT
        return samples[SAMPLES - AGREEING] > TURNED or samples[AGREEING - 1] < -TURNED

    def _may_sit(self, position: Array) -> bool:
        reaches = [(seat.position_in_world, math.hypot(0.5 * seat.width, seat.reach_in_front)) for seat in self._seats]
        return any(float(np.hypot(*(position - place))) <= reach for place, reach in reaches)


def _place_by(
    others: Sequence[Scan | LegScan], eye: Array, position: Array, time: float, velocity: Array
) -> Array | None:
    """Return where others see who is at a position, (2,) [m], at a time [s] and goes on with a velocity, (2,) [m/s].

    None: nobody sees them, or nobody can tell who it is.
    """
    places, weights = [], []
    for other in others:
        near = np.flatnonzero(_near(eye, position, other.positions))
        if len(near) > 1:
            return None
        for k in near:
            places.append(other.positions[k] + (time - other.time) * velocity)
            weights.append(np.linalg.inv(other.covariances[k]))
    if not places:
        return None
    apart = np.linalg.norm(np.array(places) - places[0], axis=1)
    mean: Array = np.linalg.solve(sum(weights), sum(w @ place for w, place in zip(weights, places, strict=True)))
    return None if apart.max() > APART else mean


def _are_several(eye: Array, places: Array) -> bool:
    """Tell whether places, (n, 2) [m], are of several people; two as far from the eye may be one and their double."""
    distances = np.hypot(places[:, 0] - eye[0], places[:, 1] - eye[1])
    return len(places) > 2 or (len(places) == 2 and bool(abs(distances[0] - distances[1]) > APART))


def _near(eye: Array, position: Array, places: Array) -> Array:
    """Tell which places, (n, 2) [m], may be of who is at a position, (2,) [m], seen from an eye; shape (n,)."""
    ray, rays = position - eye, places - eye
    distance, distances = math.hypot(*ray), np.hypot(rays[:, 0], rays[:, 1])
    if distance < NEAREST:
        return np.zeros(len(places), bool)
    turns = np.arctan2(ray[0] * rays[:, 1] - ray[1] * rays[:, 0], rays @ ray)
    near: Array = (np.abs(turns) <= GATE) & (np.abs(distances - distance) <= GATE_ALONG * distance)
    return near


def _turn(eye: Array, place: Array, position: Array) -> float:
    """Return by which angle [rad] a position, (2,) [m], is to the left of a place, (2,) [m], seen from an eye."""
    (x, y), (u, v) = place - eye, position - eye
    return wrap_angle(math.atan2(v, u) - math.atan2(y, x))
