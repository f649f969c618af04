"""How well the tracks agree with the people: places, headings, strays, MOTA and OSPA."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from han_bullet.geometry import wrap_angle
from han_bullet.metrics.perceived import CUT_OFF, MATCH_WITHIN, MATCHED, ORDER, Perceived, ospa_of_distances
from han_bullet.metrics.perception_part import IdSwitches, PerceptionPart
from han_bullet.metrics.tally import (
    STILL_SPEED,
    TIME_SLACK,
    Definition,
    Definitions,
    Value,
    person_walks,
    root_mean_square,
)
from han_bullet.world_schema import CONTROL_PERIOD

STEADY_AFTER = 1.0  # [s] of a confirmed track's life; its velocity has settled by then

_COUNTED = (
    "over all ticks and, at each, the true people whom the newest frame of some camera shows: whole in the image, tall "
    "enough, hidden by no wall, furniture, robot or other person (everybody in a run without cameras)"
)


class TrackErrors(PerceptionPart):
    """How far matched tracks are from their people, and how they are turned."""

    definitions: ClassVar[Definitions] = {
        "person_position_rmse": Definition(
            "m",
            "root mean square distance of matched tracks from their true person's centre, over all ticks in which the "
            f"track has been confirmed for more than {STEADY_AFTER:g} s; {MATCHED}; none if there never was one",
            "lower",
            headline=True,
        ),
        "heading_error_rmse": Definition(
            "rad",
            "root mean square difference of a matched track's heading from the person's true yaw while the person "
            f"walks faster than {STILL_SPEED:g} m/s and the track has a heading; none if there never was one",
            "lower",
            headline=True,
        ),
    }

    def __init__(self) -> None:
        self._births: dict[int, float] = {}
        self._position_errors: list[float] = []  # [m]
        self._heading_errors: list[float] = []  # [rad]

    def update(self, perceived: Perceived) -> None:
        """Take note of one tick."""
        for track in perceived.tracks:
            self._births.setdefault(track.id, perceived.time)
        for track, person in perceived.matched():
            if perceived.time - self._births[track.id] > STEADY_AFTER + TIME_SLACK:
                self._position_errors.append(person.pose_in_world.distance_to(track.position_in_world))
            if person_walks(person) and track.heading is not None:
                self._heading_errors.append(wrap_angle(track.heading - person.pose_in_world.yaw))

    def values(self) -> dict[str, Value]:
        """Return the two errors."""
        return {
            "person_position_rmse": root_mean_square(self._position_errors),
            "heading_error_rmse": root_mean_square(self._heading_errors),
        }


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


class StrayTracks(PerceptionPart):
    """Tracks of nobody, and second tracks of somebody."""

    definitions: ClassVar[Definitions] = {
        "phantom_tracks": Definition(
            "1",
            f"false tracks: number of track ids that, while confirmed, ever had no true person within {MATCH_WITHIN:g} "
            "m between the centres",
            "lower",
            headline=True,
        ),
        "phantom_time_total": Definition(
            "s",
            f"time, summed over tracks, that a confirmed track had no true person within {MATCH_WITHIN:g} m",
            "lower",
        ),
        "phantom_time_longest": Definition(
            "s", f"longest unbroken time that one confirmed track had no true person within {MATCH_WITHIN:g} m", "lower"
        ),
        "duplicate_time_total": Definition(
            "s",
            f"time, summed over tracks, that a confirmed track had a true person within {MATCH_WITHIN:g} m but was not "
            "the one matched",
            "lower",
        ),
    }

    def __init__(self) -> None:
        self._phantoms = _Strays()
        self._duplicates = _Strays()

    def update(self, perceived: Perceived) -> None:
        """Take note of one tick."""
        nearest = perceived.distances.min(axis=1, initial=math.inf)
        strays = perceived.unmatched_tracks()
        self._phantoms.update([perceived.tracks[i].id for i in strays if nearest[i] > MATCH_WITHIN])
        self._duplicates.update([perceived.tracks[i].id for i in strays if nearest[i] <= MATCH_WITHIN])

    def values(self) -> dict[str, Value]:
        """Return numbers and durations."""
        return {
            "phantom_tracks": len(self._phantoms.total),
            "phantom_time_total": self._phantoms.total.total() * CONTROL_PERIOD,
            "phantom_time_longest": self._phantoms.longest * CONTROL_PERIOD,
            "duplicate_time_total": self._duplicates.total.total() * CONTROL_PERIOD,
        }


class TrackingScores(PerceptionPart):
    """The two figures that say how well all people were followed at once."""

    definitions: ClassVar[Definitions] = {
        "mota": Definition(
            "1",
            "multiple object tracking accuracy, 1 - (misses + false positives + ID switches) / people, each summed "
            f"{_COUNTED}. Misses: counted people not matched; false positives: confirmed tracks matched to nobody, "
            "counted or not; switches: a counted person is matched to another id than when last matched. "
            f"{MATCHED[0].upper()}{MATCHED[1:]}. May be negative; none if nobody was ever counted [Bernardin2008]",
            "higher",
            "CLEAR MOT, which keeps earlier pairs while they are near enough",
            headline=True,
        ),
        "ospa": Definition(
            "m",
            f"mean over all ticks of the optimal subpattern assignment distance, order {ORDER:g}, cut-off "
            f"{CUT_OFF:g} m, between confirmed tracks and the counted people, counted as for mota; a track matched to "
            "somebody not counted is left out; 0 at ticks with neither [Schuhmacher2008]",
            "lower",
            headline=True,
        ),
    }

    def __init__(self) -> None:
        self._people = 0
        self._errors = 0
        self._ospa: list[float] = []  # [m]
        self._switches: dict[str, IdSwitches] = {}

    def update(self, perceived: Perceived) -> None:
        """Take note of one tick."""
        counted, matched, switches = perceived.counted, {person for _, person in perceived.pairs}, 0
        for row, person in perceived.pairs:
            known = self._switches.setdefault(perceived.people[person].name, IdSwitches())
            switches += known.update(perceived.tracks[row].id) and bool(counted[person])
        misses = sum(bool(one) and i not in matched for i, one in enumerate(counted))
        self._people += int(counted.sum())
        self._errors += misses + len(perceived.unmatched_tracks()) + switches
        asked = np.ones(len(perceived.tracks), bool)
        asked[[track for track, person in perceived.pairs if not counted[person]]] = False
        self._ospa.append(ospa_of_distances(perceived.distances[asked][:, counted]))

    def values(self) -> dict[str, Value]:
        """Return accuracy and distance."""
        return {
            "mota": 1.0 - self._errors / self._people if self._people else None,
            "ospa": float(np.mean(self._ospa)) if self._ospa else None,
        }
