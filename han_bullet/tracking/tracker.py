"""From scans of several cameras to people with ids: the contract and the tracker itself."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from han_bullet.messages import Frame, LegScan, Scan, Seat, TrackedPerson
from han_bullet.tracking.association import Association, gate
from han_bullet.tracking.building import on_floor
from han_bullet.tracking.field_of_view import FieldOfView
from han_bullet.tracking.kalman import ConstantVelocity
from han_bullet.tracking.nnjpda import Nnjpda
from han_bullet.tracking.track import LONGEST_FRAME_GAP, Track, TrackRecord
from han_bullet.world_schema import FloorArea

# Of ended tracks, so that a run of days does not fill the memory.
KEPT_RECORDS = 1000


class PeopleTracker(ABC):
    """Something that knows where people are from what the cameras found."""

    @abstractmethod
    def update(
        self, scans: Sequence[Scan], time: float, blind: Sequence[Frame] = (), legs: LegScan | None = None
    ) -> tuple[TrackedPerson, ...]:
        """Take in one tick and return the people at a time [s], in the order of their ids.

        Args:
            scans: Of the tick, often none.
            time: Now [s].
            blind: Frames of cameras that do not work now: what they would see.
            legs: Of people near the robot, if the laser has something to say.
        """


class MultiCameraTracker(PeopleTracker):
    """Track people over several cameras: predict, associate, correct, count misses, begin and end [Mateus2019].

    The scans of a tick are applied one after another in time order. A frame that should have shown a person and does
    not is a miss; a person outside a camera's view, or hidden from it, is none of its business. Legs that the laser
    sees near the robot place people whom cameras know, and keep them for a while (`track.LEGS_ALONE`).

    Args:
        field_of_view: What the cameras can see.
        seats: Sitting areas of the map.
        floor: Pieces of floor that people may be on; none: everywhere.
        association: Which track takes which measurement; None: NNJPDA.
        motion: How people move; None: constant velocity with its usual acceleration.
    """

    def __init__(
        self,
        *,
        field_of_view: FieldOfView,
        seats: Sequence[Seat] = (),
        floor: Sequence[FloorArea] = (),
        association: Association | None = None,
        motion: ConstantVelocity | None = None,
    ) -> None:
        self.field_of_view = field_of_view
        self.seats = tuple(seats)
        self.floor = tuple(floor)
        self.association = association or Nnjpda()
        self.motion = motion or ConstantVelocity()
        self._tracks: list[Track] = []
        self._next_id = 0
        self._delay, self._seen_at = 0.0, -math.inf  # of the newest scan, and when it came [s]
        self._ended: deque[TrackRecord] = deque(maxlen=KEPT_RECORDS)

    @property
    def records(self) -> tuple[TrackRecord, ...]:
        """Return the lives of all tracks, confirmed or not: those that ended, in that order, then the living."""
        return (*self._ended, *(track.record() for track in self._tracks))

    def update(
        self, scans: Sequence[Scan], time: float, blind: Sequence[Frame] = (), legs: LegScan | None = None
    ) -> tuple[TrackedPerson, ...]:
        """Return the confirmed people; see `PeopleTracker.update`."""
        for scan in sorted(scans, key=lambda scan: scan.time):
            self._take(scan)
            self._merge(scan.time)
            self._delay, self._seen_at = time - scan.time, time
        cameras_late = self._delay > LONGEST_FRAME_GAP and time - self._seen_at <= LONGEST_FRAME_GAP
        if legs is not None and not cameras_late:  # else their next scan would come too late to be taken in
            self._take_legs(legs)
        for track in self._tracks:
            hit = track.time in (track.last_hit, track.legs_hit)
            if hit and (scans or legs is not None):  # coasting says nothing new of what a person does
                track.posture.update(track.time, track.state)
        self._keep_unseen(blind, time)
        self._end(time)
        return tuple(sorted((t.person(time) for t in self._tracks if t.id is not None), key=lambda person: person.id))

    def _take(self, scan: Scan) -> None:
        """Apply one scan to all tracks, and begin tracks for what is left of it."""
        for track in self._tracks:
            track.advance(scan.time)
        pairs = self._assign(scan)
        unseen = [track for row, track in enumerate(self._tracks) if row not in pairs]
        for track, in_view in zip(unseen, self._in_view(unseen, scan), strict=True):
            track.note_seat(scan)
            if in_view:
                track.miss(scan)
        for row, measurement in sorted(pairs.items()):
            self._tracks[row].hit(scan, measurement)
            self._name(self._tracks[row])
        for measurement in sorted(set(range(len(scan.positions))) - set(pairs.values())):
            self._tracks.append(Track(scan, measurement, self.motion, self.seats))

    def _take_legs(self, legs: LegScan) -> None:
        """Apply legs to the people whom cameras know; nobody begins with them."""
        known = [track for track in self._tracks if track.takes_legs(legs.time)]
        for track in known:
            track.advance(legs.time)
        means = np.array([track.state.position for track in known]).reshape(-1, 2)
        covariances = np.array([track.state.position_covariance for track in known]).reshape(-1, 2, 2)
        pairs = dict(self.association.assign(gate(means, covariances, legs.positions, legs.covariances)))
        for row, track in enumerate(known):
            if row in pairs:
                track.hit_legs(legs, pairs[row])
            elif track.id in legs.vacant:
                track.miss(legs)

    def _assign(self, scan: Scan) -> dict[int, int]:
        """Return track row -> measurement row: confirmed people choose first, tracks on trial among what they leave."""
        pairs: dict[int, int] = {}
        for confirmed in (True, False):
            rows = [row for row, track in enumerate(self._tracks) if track.confirmed is confirmed]
            left = [k for k in range(len(scan.positions)) if k not in pairs.values()]
            if rows and left:
                means = np.array([self._tracks[row].state.position for row in rows])
                covariances = np.array([self._tracks[row].state.position_covariance for row in rows])
                chosen = self.association.assign(gate(means, covariances, scan.positions[left], scan.covariances[left]))
                pairs.update({rows[i]: left[j] for i, j in chosen})
        return pairs

    def _in_view(self, tracks: Sequence[Track], scan: Scan) -> NDArray[np.bool_]:
        """Tell which tracks the scan's camera would show, shape (number of tracks,)."""
        positions = np.array([track.state.position for track in tracks]).reshape(-1, 2)
        in_view = self.field_of_view.sees(scan.frame, positions, robot=scan.pose_robot_in_world)
        if in_view.any():
            people = np.array([track.state.position for track in self._tracks if track.confirmed]).reshape(-1, 2)
            in_view &= ~self.field_of_view.hidden_by_people(scan.frame, positions, people)
        return in_view

    def _keep_unseen(self, blind: Sequence[Frame], time: float) -> None:
        """Let nobody be forgotten for not being seen where a camera would see them, if it worked."""
        confirmed = [track for track in self._tracks if track.confirmed]
        positions = np.array([track.motion.predict(track.state, time - track.time).position for track in confirmed])
        for frame in blind:
            for track, seen in zip(confirmed, self.field_of_view.sees(frame, positions.reshape(-1, 2)), strict=True):
                if seen:
                    track.excuse(time)

    def _name(self, track: Track) -> None:
        """Give a track its id at its confirmation."""
        if track.confirmed and track.id is None:
            track.id = self._next_id
            self._next_id += 1

    def _merge(self, time: float) -> None:
        """Let the older of two tracks of one person absorb the younger."""
        by_age = sorted(self._tracks, key=lambda t: (not t.confirmed, t.id or 0, t.born_time))
        for k, older in enumerate(by_age):
            for younger in by_age[k + 1 :]:
                if younger.is_duplicate_of(older):
                    reason = "the same person as an older track"
                elif younger.continues(older):
                    reason = "where the person of an older track went"
                else:
                    continue  # asked first: nearly all pairs, of which there are many in a crowd, end here
                if older in self._tracks and younger in self._tracks:
                    self._join(older, younger, time, reason)

    def _join(self, older: Track, younger: Track, time: float, reason: str) -> None:
        older.absorb(younger)
        self._remove(younger, time, f"{reason}, {older.id}" if older.confirmed else reason)

    def _end(self, time: float) -> None:
        """End the tracks that have been without a hit for too long, or that coast off the floor."""
        positions = np.array([track.state.position for track in self._tracks]).reshape(-1, 2)
        for track, inside in zip(tuple(self._tracks), on_floor(self.floor, positions), strict=True):
            reason = track.reason_to_end(time)
            if (
                not inside and max(track.last_hit, track.legs_hit) < track.time
            ):  # nobody walks through a wall, so nobody is known there
                reason = "predicted off the floor"
            if reason is not None:
                self._remove(track, time, reason)

    def _remove(self, track: Track, time: float, reason: str) -> None:
        self._tracks.remove(track)
        self._ended.append(track.record(time, reason))
