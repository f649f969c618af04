"""Why is there a track here, or none? Every true person at one time of a run, camera by camera."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from han_bullet.detection.overlap import intersection_over_union
from han_bullet.explain.explanation import DetectionExplained, PersonExplained, Sighting, StrayExplained
from han_bullet.explain.replay import Look, Replay
from han_bullet.explain.track_lives import explain_stray, histories
from han_bullet.geometry import Array
from han_bullet.messages import Frame, Posture, TrackedPerson, TruePerson
from han_bullet.perception_tally import MATCH_WITHIN, match
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
        boxes: Of that frame.
        view: What hides people.
    """
    others = [person for person in look.truth.people if person.name != name]
    person = next(person for person in look.truth.people if person.name == name)
    place, frame = _position(person), look.scan.frame
    height = SEATED_HEIGHT if person.posture is Posture.SEATED else BODY_HEIGHT
    expected = expected_box(frame, place, height)
    box = _box_of(person, frame, expected, [box for box in boxes if not _is_of_others(box, person, others)])
    if box is not None:
        return Sighting(frame.camera, frame.time, box.measured is not None, _of_box(box, person))
    bodies = {other.name: _position(other) for other in others}
    unseen = why_unseen(view, frame, place, look.truth.pose_robot_in_world, bodies)
    if unseen is None and expected is not None:
        unseen = f"though in view; the box would be {expected[3]:.0f} px tall"
    return Sighting(frame.camera, frame.time, False, f"no detection: {unseen}")


def _is_of_others(box: DetectionExplained, person: TruePerson, others: Sequence[TruePerson]) -> bool:
    """Tell whether a measurement is nearer to another person."""
    if box.measured is None:
        return False
    own = person.pose_in_world.distance_to(box.measured)
    return any(other.pose_in_world.distance_to(box.measured) < own for other in others)


def _of_box(box: DetectionExplained, person: TruePerson) -> str:
    if box.measured is None:
        return f"detection refused: {box.text}"
    x, y = box.measured
    off = person.pose_in_world.distance_to(box.measured)
    return f"detection at ({x:.2f}, {y:.2f}), {off:.2f} m off: {box.text}"


def _box_of(
    person: TruePerson, frame: Frame, expected: Array | None, boxes: Sequence[DetectionExplained]
) -> DetectionExplained | None:
    """Return the box that covers where the person should be in the image, else the measurement nearest to them."""
    if expected is not None and boxes:
        size = np.array([frame.intrinsics.width, frame.intrinsics.height])
        low, high = np.clip([expected[:2], expected[:2] + expected[2:]], 0.0, size)
        in_image = np.concatenate([low, high - low])
        overlaps = intersection_over_union(np.array([box.box for box in boxes]), in_image)[:, 0]
        if overlaps.max() >= SAME_BOX:
            return boxes[int(overlaps.argmax())]
    measured = [(person.pose_in_world.distance_to(b.measured), b) for b in boxes if b.measured is not None]
    distance, nearest = min(measured, key=lambda pair: pair[0], default=(np.inf, None))
    return nearest if distance <= MATCH_WITHIN else None
