"""The numbers of a run that compare what the robot believed of people with the truth."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import linear_sum_assignment

from han_bullet.episode import Tick
from han_bullet.geometry import Array, wrap_angle
from han_bullet.messages import Frame, Posture, TrackedPerson, TruePerson
from han_bullet.tallies import Tally, Value, person_walks
from han_bullet.tracking.field_of_view import FieldOfView
from han_bullet.world_schema import CONTROL_PERIOD

MATCH_WITHIN = 1.0  # [m] between a track or a foot point and a true person; two people abreast are about that far apart
STEADY_AFTER = 1.0  # [s] of a confirmed track's life; its velocity has settled by then
TIME_SLACK = 1e-6  # [s] for comparing sums of control periods


def match(positions: Array, true_positions: Array) -> list[tuple[int, int]]:
    """Pair tracks with people: as many pairs within `MATCH_WITHIN` as can be, of the least sum of distances.

    Args:
        positions: Of the tracks, shape (n, 2) [m].
        true_positions: Of the people, shape (m, 2) [m].

    Returns:
        (track, person) index pairs, ordered by track; each index at most once.
    """
    distances = distances_between(positions, true_positions)
    near = distances <= MATCH_WITHIN
    never = 1.0 + MATCH_WITHIN * (min(distances.shape) + 1)  # dearer than any number of allowed pairs
    rows, columns = linear_sum_assignment(np.where(near, distances, never))
    return [(int(i), int(j)) for i, j in zip(rows, columns, strict=True) if near[i, j]]


def distances_between(first: Array, second: Array) -> Array:
    """Return all distances, shape (n, m) [m], between points of shapes (n, 2) and (m, 2) [m]."""
    difference = first.reshape(-1, 1, 2) - second.reshape(1, -1, 2)
    return np.hypot(difference[..., 0], difference[..., 1])


@dataclass
class IdSwitches:
    """How often one person is matched to another id than at their previous match."""

    count: int = 0
    last_id: int | None = None

    def update(self, track_id: int) -> None:
        """Take note of the id that the person is matched to."""
        self.count += self.last_id is not None and self.last_id != track_id
        self.last_id = track_id


@dataclass
class _Knowledge:
    """What has been known of one true person so far; times in [s]."""

    possible_since: float | None = None
    ticks_possible: int = 0
    ticks_tracked: int = 0
    first_track: float | None = None
    walking_since: float | None = None
    noticed_walking: float | None = None
    id_switches: IdSwitches = field(default_factory=IdSwitches)

    def update(self, time: float, person: TruePerson, track: TrackedPerson | None, visible: bool) -> None:
        if self.possible_since is None and (visible or track is not None):
            self.possible_since = time
        self.ticks_possible += self.possible_since is not None
        if self.walking_since is None and person_walks(person):
            self.walking_since = time
        if track is not None:
            self._take_track(time, track)

    def _take_track(self, time: float, track: TrackedPerson) -> None:
        self.ticks_tracked += 1
        self.first_track = time if self.first_track is None else self.first_track
        self.id_switches.update(track.id)
        if self.walking_since is not None and self.noticed_walking is None and track.posture is Posture.WALKING:
            self.noticed_walking = time

    def values(self, name: str) -> dict[str, Value]:
        return {
            f"tracked_share.{name}": self.ticks_tracked / self.ticks_possible if self.ticks_possible else None,
            f"time_to_first_track.{name}": _difference(self.first_track, self.possible_since),
            f"time_to_notice_walking.{name}": _difference(self.noticed_walking, self.walking_since),
        }


def _difference(later: float | None, earlier: float | None) -> float | None:
    return None if later is None or earlier is None else later - earlier


@dataclass
class _Strays:
    """Tracks that stand for nobody: how long each id, and how long at a stretch [ticks]."""

    total: Counter[int] = field(default_factory=Counter)
    longest: int = 0
    running: dict[int, int] = field(default_factory=dict)

    def update(self, ids: Sequence[int]) -> None:
        self.total.update(ids)
        self.running = {key: self.running.get(key, 0) + 1 for key in ids}
        self.longest = max(self.longest, *self.running.values(), 0)


class PerceptionTally(Tally):
    """How well people were seen inside the loop.

    Args:
        people: Names, for metrics that exist also where nothing was recorded.
        view: Tells which floor points a frame sees a whole person at.
    """

    def __init__(self, people: Sequence[str], view: FieldOfView) -> None:
        self._view = view
        self._known = {name: _Knowledge() for name in people}
        self._births: dict[int, float] = {}
        self._phantoms = _Strays()
        self._duplicates = _Strays()
        self._position_errors: list[float] = []  # [m]
        self._heading_errors: list[float] = []  # [rad]
        self._frames = 0
        self._detections = 0
        self._false_detections = 0

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        people, tracks = tick.truth.people, tick.decision.people
        true_positions = np.array([p.pose_in_world.position for p in people]).reshape(-1, 2)
        positions = np.array([t.position_in_world for t in tracks]).reshape(-1, 2)
        pairs = match(positions, true_positions)
        visible = self._visible(tick.observation.frames, true_positions)
        track_of = {person: tracks[track] for track, person in pairs}
        for index, person in enumerate(people):
            self._known[person.name].update(tick.truth.time, person, track_of.get(index), bool(visible[index]))
        self._count_strays(tracks, {track for track, _ in pairs}, distances_between(positions, true_positions))
        self._take_errors(tick, [(tracks[i], people[j]) for i, j in pairs])
        self._count_detections(tick, true_positions)

    def _visible(self, frames: Sequence[Frame], true_positions: Array) -> Array:
        """Tell for each person whether some frame shows them whole, shape (m,)."""
        seen = np.zeros(len(true_positions), bool)
        if any(known.possible_since is None for known in self._known.values()):
            for frame in frames:
                seen |= self._view.sees(frame, true_positions)
        return seen

    def _count_strays(self, tracks: Sequence[TrackedPerson], matched: set[int], distances: Array) -> None:
        nearest = distances.min(axis=1, initial=math.inf)
        strays = [i for i in range(len(tracks)) if i not in matched]
        self._phantoms.update([tracks[i].id for i in strays if nearest[i] > MATCH_WITHIN])
        self._duplicates.update([tracks[i].id for i in strays if nearest[i] <= MATCH_WITHIN])

    def _take_errors(self, tick: Tick, pairs: Sequence[tuple[TrackedPerson, TruePerson]]) -> None:
        for track in tick.decision.people:
            self._births.setdefault(track.id, tick.truth.time)
        for track, person in pairs:
            if tick.truth.time - self._births[track.id] > STEADY_AFTER + TIME_SLACK:
                self._position_errors.append(person.pose_in_world.distance_to(track.position_in_world))
            if person_walks(person) and track.heading is not None:
                self._heading_errors.append(wrap_angle(track.heading - person.pose_in_world.yaw))

    def _count_detections(self, tick: Tick, true_positions: Array) -> None:
        self._frames += len(tick.decision.detections)
        self._detections += sum(len(found.boxes) for found in tick.decision.detections)
        for scan in tick.decision.scans:
            nearest = distances_between(scan.positions, true_positions).min(axis=1, initial=math.inf)
            self._false_detections += int((nearest > MATCH_WITHIN).sum())

    def values(self) -> dict[str, Value]:
        """Return errors, shares and counts."""
        values: dict[str, Value] = {
            "person_position_rmse": _root_mean_square(self._position_errors),
            "heading_error_rmse": _root_mean_square(self._heading_errors),
            "id_switches": sum(known.id_switches.count for known in self._known.values()),
            "phantom_tracks": len(self._phantoms.total),
            "phantom_time_total": self._phantoms.total.total() * CONTROL_PERIOD,
            "phantom_time_longest": self._phantoms.longest * CONTROL_PERIOD,
            "duplicate_time_total": self._duplicates.total.total() * CONTROL_PERIOD,
            "detections_per_frame": self._detections / self._frames if self._frames else None,
            "false_detections_per_frame": self._false_detections / self._frames if self._frames else None,
        }
        for name, known in self._known.items():
            values |= known.values(name)
        return values


def _root_mean_square(errors: Sequence[float]) -> float | None:
    return float(np.sqrt(np.mean(np.square(errors)))) if errors else None
