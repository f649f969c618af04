"""What became of tracks, in words."""

from __future__ import annotations

from collections import Counter

from han_bullet.explain.explanation import Place, StrayExplained
from han_bullet.explain.replay import Replay
from han_bullet.messages import TrackedPerson, TruePerson
from han_bullet.metrics.perceived import MATCH_WITHIN
from han_bullet.tracking.track import CONFIRM_WITHIN, HITS_TO_CONFIRM, MEMORY, TrackRecord
from han_bullet.tracking.tracker import MultiCameraTracker


def lives(replay: Replay) -> tuple[TrackRecord, ...]:
    """Return the lives of all tracks up to now; none where the simulator told where people are."""
    tracker = replay.stack.tracker
    return tracker.records if isinstance(tracker, MultiCameraTracker) else ()


def on_trial(record: TrackRecord) -> str:
    """Tell how far a track is that has not been confirmed."""
    hits = [hit for hit in record.recent_hits if hit.time >= record.last_hit - CONFIRM_WITHIN - 1e-9]
    number = f"{len(hits)} {'hit' if len(hits) == 1 else 'hits'} of {HITS_TO_CONFIRM} within {CONFIRM_WITHIN:g} s"
    return f"a track on trial since {record.born_time:.2f} s with {number}, the last at {_last_hit(record)}"


def histories(replay: Replay, person: TruePerson) -> tuple[str, ...]:
    """Tell of the tracks that there are and were of a person who has none now."""
    records = lives(replay)
    near_now = [r for r in records if r.ended_time is None and r.id is None and _near(r.hit_at, person)]
    told = [on_trial(record) for record in near_now]
    ended = [record for record in records if record.ended_time is not None and _was_near(replay, record, person.name)]
    confirmed = [record for record in ended if record.id is not None]
    if confirmed:
        told.append(_ending(confirmed[-1]))
    since = confirmed[-1].ended_time if confirmed else None
    tried = [r for r in ended if r.id is None and (since is None or r.born_time > since)]
    if tried:
        told.append(f"{len(tried)} on trial ended unconfirmed; {_ending(tried[-1])}")
    return tuple(told) or ("no camera has measured anybody here yet",)


def explain_stray(replay: Replay, track: TrackedPerson, people: tuple[TruePerson, ...]) -> StrayExplained:
    """Tell since when a track of nobody lives and what feeds it."""
    x, y = track.position_in_world.tolist()
    distances = [(person.pose_in_world.distance_to((x, y)), person.name) for person in people]
    nearest = min(distances, default=None)
    record = next(record for record in lives(replay) if record.id == track.id)
    fed = Counter(hit.camera for hit in record.recent_hits)
    boxes = ", ".join(f"{count} of {camera}" for camera, count in fed.items())
    text = (
        f"began at {record.born_time:.2f} s by {record.born_by} at ({record.born_at[0]:.2f}, {record.born_at[1]:.2f}), "
        f"confirmed at {record.confirmed_time:.2f} s; fed by {boxes} in the {MEMORY:g} s up to {_last_hit(record)}"
    )
    return StrayExplained(track.id, (x, y), None if nearest is None else nearest[::-1], text)


def _last_hit(record: TrackRecord) -> str:
    return f"{record.last_hit:.2f} s by {record.recent_hits[-1].camera}"


def _ending(record: TrackRecord) -> str:
    name = "the last" if record.id is None else f"track {record.id}"
    missed = f" (missed since by {' and '.join(record.missed_by)})" if record.missed_by else ""
    return f"{name} ended at {record.ended_time:.2f} s, last hit at {_last_hit(record)}: {record.reason}{missed}"


def _near(place: Place, person: TruePerson) -> bool:
    return person.pose_in_world.distance_to(place) <= MATCH_WITHIN


def _was_near(replay: Replay, record: TrackRecord, name: str) -> bool:
    """Tell whether a track was last hit near to where a person then was."""
    truth = replay.run.truths[replay.run.tick_at(record.last_hit)]
    then = next(person for person in truth.people if person.name == name)
    return _near(record.hit_at, then)
