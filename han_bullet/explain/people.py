"""Why is there a track here, or none? Every true person at one time of a run, camera by camera."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from han_bullet.detection.overlap import intersection_over_union
from han_bullet.explain.explanation import DetectionExplained, PersonExplained, Sighting, StrayExplained
from han_bullet.explain.replay import Look, Replay
from han_bullet.explain.track_lives import explain_stray, histories
from han_bullet.geometry import Array
from han_bullet.messages import Frame, Posture, TrackedPerson, TruePerson
from han_bullet.metrics.perceived import MATCH_WITHIN, match
from han_bullet.tracking.field_of_view import BODY_HEIGHT, FieldOfView
from han_bullet.tracking.sight import expected_box, why_unseen
from han_bullet.tracking.tracker import MultiCameraTracker

# Overlap from which on a box is that of the person whom one expects there.
SAME_BOX = 0.3
# From the floor to the crown [m].
SEATED_HEIGHT = 1.25


def explain_people(
    replay: Replay, boxes: Sequence[DetectionExplained]
) -> tuple[tuple[PersonExplained, ...], tuple[StrayExplained, ...]]:
    """Return every true person, and every track without one of its own."""
    people, tracks = replay.tick.truth.people, replay.tick.decision.people
    pairs = match(_places(track.position_in_world for track in tracks), _places(_position(p) for p in people))
    track_of = {person: tracks[track] for track, person in pairs}
    strays = [track for number, track in enumerate(tracks) if number not in dict(pairs)]
    return (
        tuple(_person(replay, person, track_of.get(number), boxes) for number, person in enumerate(people)),
        tuple(explain_stray(replay, track, people) for track in strays),
    )


def _places(positions: Iterable[Array]) -> Array:
    return np.array(list(positions)).reshape(-1, 2)


def _position(person: TruePerson) -> Array:
    return person.pose_in_world.position


def _person(
    replay: Replay, person: TruePerson, track: TrackedPerson | None, boxes: Sequence[DetectionExplained]
) -> PersonExplained:
    x, y = _position(person).tolist()
    return PersonExplained(
        person.name,
        (x, y),
        person.posture.value,
        None if track is None else track.id,
        None if track is None else person.pose_in_world.distance_to(track.position_in_world),
        _sightings(replay, person.name, boxes),
        histories(replay, person) if track is None else (),
    )


def _sightings(replay: Replay, name: str, boxes: Sequence[DetectionExplained]) -> tuple[Sighting, ...]:
    tracker = replay.stack.tracker
    if not isinstance(tracker, MultiCameraTracker):
        return ()
    cameras = [camera.name for camera in replay.run.world.cameras]
    looks = [replay.looks.get(camera) for camera in cameras]
    return tuple(
        Sighting(camera, None, False, "no image yet")
        if look is None
        else sighting(look, name, [box for box in boxes if box.camera == camera], tracker.field_of_view)
        for camera, look in zip(cameras, looks, strict=True)
    )


def sighting(look: Look, name: str, boxes: Sequence[DetectionExplained], view: FieldOfView) -> Sighting:
    """Tell what a camera's frame had of a person.

    Args:
        look: The frame.
        name: Of the person.
        boxes: Of that frame, by falling score.
        view: What hides people.
    """
    people, frame = look.truth.people, look.scan.frame
    person = next(person for person in people if person.name == name)
    box = next((box for box in boxes if _owner(box, frame, people) is person), None)
    if box is not None:
        return Sighting(frame.camera, frame.time, box.measured is not None, _of_box(box, person))
    others = {other.name: _position(other) for other in people if other is not person}
    unseen = why_unseen(view, frame, _position(person), look.truth.pose_robot_in_world, others)
    if unseen is None:
        expected = _expected(frame, person)
        unseen = f"though in view; the box would be {0.0 if expected is None else expected[3]:.0f} px tall"
    return Sighting(frame.camera, frame.time, False, f"no detection: {unseen}")


def _owner(box: DetectionExplained, frame: Frame, people: Sequence[TruePerson]) -> TruePerson | None:
    """Return the person nearest to a measurement; else, and of other boxes, who should be there in the image."""
    if box.measured is not None:
        distances = [person.pose_in_world.distance_to(box.measured) for person in people]
        if min(distances, default=math.inf) <= MATCH_WITHIN:
            return people[int(np.argmin(distances))]
    overlaps = [_overlap(box, frame, person) for person in people]
    return people[int(np.argmax(overlaps))] if max(overlaps, default=0.0) >= SAME_BOX else None


def _overlap(box: DetectionExplained, frame: Frame, person: TruePerson) -> float:
    """Return how much a box overlaps with what the image should show of a person, in [0, 1]."""
    expected = _expected(frame, person)
    if expected is None:
        return 0.0
    size = np.array([frame.intrinsics.width, frame.intrinsics.height])
    low, high = np.clip([expected[:2], expected[:2] + expected[2:]], 0.0, size)
    return float(intersection_over_union(np.array(box.box), np.concatenate([low, high - low]))[0, 0])


def _expected(frame: Frame, person: TruePerson) -> Array | None:
    height = SEATED_HEIGHT if person.posture is Posture.SEATED else BODY_HEIGHT
    return expected_box(frame, _position(person), height)


def _of_box(box: DetectionExplained, person: TruePerson) -> str:
    if box.measured is None:
        return f"detection refused: {box.text}"
    x, y = box.measured
    off = person.pose_in_world.distance_to(box.measured)
    return f"detection at ({x:.2f}, {y:.2f}), {off:.2f} m off: {box.text}"
