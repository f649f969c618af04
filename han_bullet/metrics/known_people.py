"""What was known of each person: since when, how much of the time, under how many ids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from han_bullet.messages import Posture, TrackedPerson, TruePerson
from han_bullet.metrics.perceived import MATCHED, Perceived
from han_bullet.metrics.perception_part import IdSwitches, PerceptionPart
from han_bullet.metrics.tally import STILL_SPEED, Definition, Definitions, Value, person_walks
from han_bullet.tracking.field_of_view import SMALLEST

_POSSIBLE = (
    f"from the first frame in which a standing person there could be found (whole in the image, {SMALLEST:g} px tall, "
    "no wall, furniture, robot or other person before them), or the first match where that is sooner"
)


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


class KnownPeople(PerceptionPart):
    """What was known of each person.

    Args:
        people: Names, for metrics that exist also where nothing was recorded.
    """

    definitions: ClassVar[Definitions] = {
        "tracked_share": Definition(
            "1",
            f"share of ticks in which the person is matched, {_POSSIBLE}; {MATCHED}; none if that never came",
            "higher",
        ),
        "time_to_first_track": Definition(
            "s", f"time until the person is first matched, {_POSSIBLE}; none if they never were", "lower"
        ),
        "time_to_notice_walking": Definition(
            "s",
            f"from the first tick in which the true person moves faster than {STILL_SPEED:g} m/s to the first one "
            "since in which a matched track is walking; none where either never came",
            "lower",
        ),
        "id_switches": Definition(
            "1",
            f"how often a person is matched to another id than at their previous match, all people together; {MATCHED}",
            "lower",
            "CLEAR MOT: mismatches [Bernardin2008]",
            headline=True,
        ),
    }

    def __init__(self, people: Sequence[str]) -> None:
        self._known = {name: _Knowledge() for name in people}

    def update(self, perceived: Perceived) -> None:
        """Take note of one tick."""
        track_of = {person: perceived.tracks[track] for track, person in perceived.pairs}
        for index, person in enumerate(perceived.people):
            visible = bool(perceived.shown[index])
            self._known[person.name].update(perceived.time, person, track_of.get(index), visible)

    def values(self) -> dict[str, Value]:
        """Return shares, durations and the number of switches."""
        values: dict[str, Value] = {"id_switches": sum(known.id_switches.count for known in self._known.values())}
        for name, known in self._known.items():
            values |= known.values(name)
        return values
