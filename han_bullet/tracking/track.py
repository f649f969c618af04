"""One track: what the tracker believes about one person, and what became of that belief."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from han_bullet.geometry import Array
from han_bullet.messages import LegScan, Posture, Scan, Seat, TrackedPerson
from han_bullet.tracking.association import MAHALANOBIS_GATE
from han_bullet.tracking.kalman import NO_SHIFT, ConstantVelocity, MotionState
from han_bullet.tracking.posture import PostureEstimator
from han_bullet.tracking.seats import has_room_for, in_sitting_area

HITS_TO_CONFIRM = 3
# Time that the hits of a confirmation may span [s]: one frame in five may be missing at 10 Hz.
CONFIRM_WITHIN = 0.5
# [s].
YOUNG_AGE = 2.0
# Without a hit while in view, of a track younger than `YOUNG_AGE` [s]: ghosts go soon.
YOUNG_LIFE = 0.6
# Without a hit while in view [s]: a walker is soon elsewhere, a seated person is the hardest to detect.
LIVES = {Posture.WALKING: 1.5, Posture.STANDING: 3.0, Posture.SEATED: 10.0}
# Without a hit, of somebody seated whose seat one camera shows to be empty in each of its frames [s]: twice as long as
# a confirmation may take, so that whoever got up is known again by then and takes over the id (`continues`).
EMPTY_SEAT_LIFE = 1.0
# Outside every view, or hidden [s]; a seated person's is as long as in view, for they stay.
OUTSIDE_LIFE = 3.0
# Standard deviation of a place up to which somebody is remembered whom a camera would show if it worked [m].
WIDEST_SPREAD = 1.5
# Closer than this two people cannot walk [m].
DUPLICATE_DISTANCE = 0.4
# Who appears this near to somebody who is no longer where they were, is that somebody [m].
STEP_ASIDE = 1.0
# In view without a hit for so long is "no longer where they were" [s]: with one frame in ten missed, a chance of 1e-3.
LOST_AFTER = 0.3
# How long it is remembered that one image showed two people [s].
MEMORY = 2.0
# Two frames farther apart than this do not show what was between them [s].
LONGEST_FRAME_GAP = 0.25
# For how long legs alone, without a hit of a camera, say where somebody is and keep their track [s]: the last two
# metres before somebody take half of it, and legs of furniture that the map does not know keep a ghost no longer.
LEGS_ALONE = 10.0


@dataclass(frozen=True)
class Hit:
    """A measurement that a track took.

    Attributes:
        time: Of the exposure [s].
        camera: Name.
        detection: Row among the frame's detections.
    """

    time: float
    camera: str
    detection: int


@dataclass(frozen=True)
class TrackRecord:
    """The life of a track, as plain data.

    Attributes:
        id: None if it was never confirmed.
        born_time: [s].
        born_by: Camera of the first hit.
        born_at: Position of the first hit in the world, (x, y) [m].
        confirmed_time: [s], None if never.
        hits, misses: Camera, or the laser -> number of scans.
        recent_hits: Those of the `MEMORY` before the last one, that one included; also of tracks that it absorbed.
        last_hit: [s].
        missed_by: Cameras with a miss since then.
        hit_at: Where the person was believed to be at that hit, in the world, (x, y) [m].
        ended_time: [s], None while it lives.
        reason: Why it ended, None while it lives.
    """

    id: int | None
    born_time: float
    born_by: str
    born_at: tuple[float, float]
    confirmed_time: float | None
    hits: dict[str, int]
    misses: dict[str, int]
    recent_hits: tuple[Hit, ...]
    last_hit: float
    missed_by: tuple[str, ...]
    hit_at: tuple[float, float]
    ended_time: float | None = None
    reason: str | None = None


class Track:
    """Somebody whom the cameras may have seen; belongs to one tracker.

    Args:
        scan: Of the first hit.
        measurement: Row of the first hit in it.
        motion: How people move.
        seats: Sitting areas of the map.
    """

    def __init__(self, scan: Scan, measurement: int, motion: ConstantVelocity, seats: Sequence[Seat]) -> None:
        self.id: int | None = None
        self.motion = motion
        self.posture = PostureEstimator(seats)
        self.time = self.born_time = scan.time
        self.born_by = scan.camera
        self.born_at = scan.positions[measurement]
        self.state = motion.start(*_measured(scan, measurement))
        self.confirmed_time: float | None = None
        self.hits: dict[str, int] = {}
        self.misses: dict[str, int] = {}
        self._excused_until = self._in_view_until = scan.time
        self.last_hit = scan.time
        self.missed_for = 0.0  # since the last hit, while in view [s]
        self.legs_hit = -math.inf
        self._hit_at = self.state.position
        self._missed_by: tuple[str, ...] = ()
        self._seat_empty: dict[str, tuple[float, float]] = {}  # camera -> since and until when it shows so
        self._images: dict[tuple[float, str], int] = {}  # that showed the person -> the detection's row
        self._note_hit(scan, measurement)

    @property
    def confirmed(self) -> bool:
        """Tell whether the track has had enough hits to be a person."""
        return self.confirmed_time is not None

    def advance(self, time: float) -> None:
        """Predict to a time [s]; an earlier one than the track's changes nothing."""
        self.state = self.motion.predict(self.state, time - self.time)
        self.time = max(self.time, time)

    def hit(self, scan: Scan, measurement: int) -> None:
        """Correct by a measurement of a scan at the track's time."""
        self.state = self.motion.correct(self.state, *_measured(scan, measurement))
        self._note_hit(scan, measurement)

    def takes_legs(self, time: float) -> bool:
        """Tell whether legs may be this person's: of who is on their feet, and whom cameras saw not long ago [s]."""
        seated = self.posture.stance.posture is Posture.SEATED
        return self.confirmed and not seated and time - self.last_hit <= LEGS_ALONE + 1e-9

    def hit_legs(self, legs: LegScan, measurement: int) -> None:
        """Correct by legs at the track's time; they are no sighting by a camera."""
        self.state = self.motion.correct(self.state, legs.positions[measurement], legs.covariances[measurement])
        self.legs_hit = legs.time
        self._in_view_until = max(self._in_view_until, legs.time)
        self._missed_by = ()
        self.missed_for = 0.0
        self.hits[legs.camera] = self.hits.get(legs.camera, 0) + 1

    def _note_hit(self, scan: Scan, measurement: int) -> None:
        self.last_hit = self._in_view_until = scan.time
        self._hit_at = self.state.position
        self._missed_by = ()
        self._seat_empty = {}
        self.missed_for = 0.0
        self.hits[scan.camera] = self.hits.get(scan.camera, 0) + 1
        self._images = {image: row for image, row in self._images.items() if image[0] >= scan.time - MEMORY}
        self._images[scan.time, scan.camera] = int(scan.sources[measurement])
        recent = [time for time, _ in self._images if time >= scan.time - CONFIRM_WITHIN - 1e-9]
        if not self.confirmed and len(recent) >= HITS_TO_CONFIRM:
            self.confirmed_time = scan.time

    def miss(self, scan: Scan | LegScan) -> None:
        """Take note that a scan should have shown the person and did not."""
        self.missed_for += min(max(scan.time - self._in_view_until, 0.0), LONGEST_FRAME_GAP)
        self._in_view_until = max(self._in_view_until, scan.time)
        if scan.camera not in self._missed_by:
            self._missed_by += (scan.camera,)
        self.misses[scan.camera] = self.misses.get(scan.camera, 0) + 1

    def note_seat(self, scan: Scan) -> None:
        """Take note of whether a scan that has not hit somebody seated shows their seat to be empty."""
        seat = self.posture.stance.seat
        if seat is None or seat.name not in scan.empty_seats:
            self._seat_empty.pop(scan.camera, None)
            return
        since, until = self._seat_empty.get(scan.camera, (scan.time, scan.time))
        if scan.time - until > LONGEST_FRAME_GAP + 1e-9:
            since = scan.time
        self._seat_empty[scan.camera] = since, scan.time

    def excuse(self, time: float) -> None:
        """Take note that a camera that does not work would show the person at a time [s], if still roughly known."""
        covariance = self.motion.predict(self.state, time - self.time).position_covariance
        if float(np.linalg.eigvalsh(covariance)[-1]) <= WIDEST_SPREAD**2:
            self._excused_until = time

    def reason_to_end(self, time: float) -> str | None:
        """Return why the track should end at a time [s], or None."""
        life = LIVES[self.posture.stance.posture]
        if self.last_hit - self.born_time < YOUNG_AGE:
            life = YOUNG_LIFE
        if self.missed_for > life + 1e-9:
            return f"in view without a hit for {self.missed_for:.2f} s"
        for camera, (since, until) in self._seat_empty.items():
            if until - since > EMPTY_SEAT_LIFE - 1e-9:
                return f"its seat was seen to be empty for {until - since:.2f} s by {camera}"
        outside = time - max(self._in_view_until, self._excused_until)
        if outside > max(OUTSIDE_LIFE, life) + 1e-9:
            return f"outside every view for {outside:.2f} s"
        return None

    def is_duplicate_of(self, older: Track) -> bool:
        """Tell whether an older track is the same person: close, as fast, and not apart in one image.

        Of a track that is not confirmed, an image of both is taken for a second box around the same person. Two on one
        seat are one person, however far apart on it, unless one image showed both side by side: a camera that looks
        along a seat places everybody on it who is in line with it and whose feet it does not see.
        """
        seat = self._shared_seat(older)
        if seat is not None and not (
            self._shares_image_with(older) and has_room_for(seat, self.state.position, older.state.position)
        ):
            return True
        if self._distance_to(older.state.position) >= DUPLICATE_DISTANCE:
            return False
        if self.confirmed and self._shares_image_with(older):
            return False
        difference = self.state.velocity - older.state.velocity
        spread = self.state.velocity_covariance + older.state.velocity_covariance
        return bool(difference @ np.linalg.solve(spread, difference) <= MAHALANOBIS_GATE)

    def continues(self, older: Track) -> bool:
        """Tell whether this track is the person whom an older one has lost, having set off or got up from a seat.

        It must have begun not long ago, close to the older one, which since then is in view without hits.
        """
        if not self.confirmed or self.time - self.born_time > YOUNG_AGE or older.missed_for < LOST_AFTER - 1e-9:
            return False
        if self._shares_image_with(older):
            return False
        seat = older.posture.stance.seat
        if seat is not None and in_sitting_area(seat, self.born_at, STEP_ASIDE):
            return True
        return bool(np.hypot(*(older.state.position - self.born_at)) < STEP_ASIDE)

    def _distance_to(self, position: Array) -> float:
        # Two numbers at a time, for numpy takes ten times as long; every pair of tracks is asked at every scan.
        x, y = self.state.mean[:2].tolist()
        return math.hypot(x - position[0], y - position[1])

    def _shared_seat(self, other: Track) -> Seat | None:
        seat = self.posture.stance.seat
        return seat if seat is other.posture.stance.seat else None

    def _shares_image_with(self, other: Track) -> bool:
        """Tell whether one image of the last seconds showed two people, this one and the other."""
        return not self._images.keys().isdisjoint(other._images)

    def absorb(self, other: Track) -> None:
        """Take over what another track of the same person knows better."""
        if np.trace(other.state.position_covariance) < np.trace(self.state.position_covariance):
            self.state = other.state
        self._images = dict(sorted({**other._images, **self._images}.items()))
        if other.last_hit > self.last_hit:
            self.last_hit, self._hit_at = other.last_hit, other._hit_at
            self._seat_empty = other._seat_empty
        self.legs_hit = max(self.legs_hit, other.legs_hit)
        self._in_view_until = max(self._in_view_until, other._in_view_until)
        self._excused_until = max(self._excused_until, other._excused_until)
        self.missed_for = min(self.missed_for, other.missed_for)

    def person(self, time: float) -> TrackedPerson:
        """Return the confirmed track as a person at a time [s]."""
        assert self.id is not None, "only confirmed tracks are people"
        state, stance = self.motion.predict(self.state, time - self.time), self.posture.stance
        if stance.seat is not None:
            state = MotionState(np.array([*stance.seat.position_in_world, 0.0, 0.0, 0.0]), state.covariance)
        name = None if stance.seat is None else stance.seat.name
        return TrackedPerson(
            self.id, time, state.position, state.velocity, state.motion_covariance, stance.posture, stance.heading, name
        )

    def record(self, ended_time: float | None = None, reason: str | None = None) -> TrackRecord:
        """Return the track's life so far."""
        born_at = (float(self.born_at[0]), float(self.born_at[1]))
        x, y = self._hit_at.tolist()
        return TrackRecord(
            self.id,
            self.born_time,
            self.born_by,
            born_at,
            self.confirmed_time,
            dict(self.hits),
            dict(self.misses),
            tuple(Hit(*image, row) for image, row in self._images.items()),
            self.last_hit,
            self._missed_by,
            (x, y),
            ended_time,
            reason,
        )


def _measured(scan: Scan, measurement: int) -> tuple[Array, Array, Array]:
    """Return a measurement of a scan: its position, its covariance, and its shift per metre of the person's height."""
    per_height = NO_SHIFT if scan.per_height is None else scan.per_height[measurement]
    return scan.positions[measurement], scan.covariances[measurement], per_height
