"""Why there is a track or none: every reason, on runs whose boxes are made up."""

from collections.abc import Sequence

import pytest
from made_runs import Place, made_run, replayed

from han_bullet.explain.boxes import explain_boxes
from han_bullet.explain.explanation import PersonExplained, StrayExplained
from han_bullet.explain.people import explain_people
from han_bullet.explain.recorded_run import RecordedRun

HERE = (6.0, 0.0)


def told(run: RecordedRun) -> tuple[tuple[PersonExplained, ...], tuple[StrayExplained, ...]]:
    replay = replayed(run)
    return explain_people(replay, explain_boxes(replay))


def anna(run: RecordedRun) -> PersonExplained:
    (person,), strays = told(run)
    assert strays == ()
    return person


def of_camera(person: PersonExplained, camera: str) -> str:
    return next(sighting.text for sighting in person.sightings if sighting.camera == camera)


def seen_by_camera1_until(end: float, *places: Place) -> "Boxes":
    return Boxes("camera1", end, places)


class Boxes:
    """Boxes of one camera at some places up to a time [s], exclusive."""

    def __init__(self, camera: str, end: float, places: Sequence[Place]) -> None:
        self.camera, self.end, self.places = camera, end, places

    def __call__(self, camera: str, time: float) -> Sequence[Place]:
        return self.places if camera == self.camera and time < self.end - 1e-6 else ()


def test_somebody_who_is_tracked_has_a_track_with_its_distance_and_the_cameras_that_see_them() -> None:
    person = anna(made_run({"anna": HERE}, 21, seen_by_camera1_until(9.0, HERE)))
    assert (person.track, person.history) == (0, ())
    assert person.distance == pytest.approx(0.2, abs=0.2)
    assert [sighting.camera for sighting in person.sightings if sighting.measured] == ["camera1"]
    assert of_camera(person, "camera1").startswith("detection at (") and of_camera(person, "camera1").endswith(
        "track 0"
    )
    assert of_camera(person, "camera2") == "no detection: behind the camera"


def test_somebody_whom_nobody_has_found_is_not_detected_though_in_view() -> None:
    person = anna(made_run({"anna": HERE}, 21, lambda camera, time: ()))
    assert (person.track, person.distance) == (None, None)
    assert of_camera(person, "camera1") == "no detection: though in view; the box would be 161 px tall"
    assert person.history == ("no camera has measured anybody here yet",)


def test_a_box_that_is_too_small_is_a_refused_detection() -> None:
    far = (9.9, 0.0)
    person = anna(made_run({"anna": far}, 21, seen_by_camera1_until(9.0, far)))
    assert of_camera(person, "camera1") == (
        "detection refused: the box is 102 px tall, and the smallest that is measured 104 px"
    )
    assert not any(sighting.measured for sighting in person.sightings)


def test_somebody_behind_another_person_is_hidden_by_them_and_their_box_is_not_mixed_up() -> None:
    people, _ = told(made_run({"anna": (5.2, 0.0), "bob": (5.9, 0.0)}, 21, seen_by_camera1_until(9.0, (5.2, 0.0))))
    assert people[0].track == 0
    assert people[1].track is None
    assert of_camera(people[1], "camera1") == "no detection: hidden by anna"


def test_somebody_behind_the_robot_is_hidden_by_it() -> None:
    person = anna(made_run({"anna": (5.8, 0.0)}, 21, lambda camera, time: (), robot=(5.1, 0.0)))
    assert of_camera(person, "camera1") == "no detection: hidden by the robot"


def test_two_hits_are_a_track_on_trial() -> None:
    person = anna(made_run({"anna": HERE}, 4, seen_by_camera1_until(0.2, HERE)))
    words = "a track on trial since 0.00 s with 2 hits of 3 within 0.5 s, the last at 0.10 s by camera1"
    assert person.history == (words,)
    assert of_camera(person, "camera1").endswith(words)


def test_a_track_that_ended_says_when_why_and_who_missed_last() -> None:
    person = anna(made_run({"anna": HERE}, 120, seen_by_camera1_until(2.5, HERE)))
    (words,) = person.history
    assert words.startswith("track 0 ended at 5.50 s, last hit at 2.40 s by camera1: in view without a hit for 3.10 s")
    assert words.endswith("(missed since by onboard and camera1)")


def test_trials_that_ended_are_counted() -> None:
    def now_and_then(camera: str, time: float) -> Sequence[Place]:
        return [HERE] if camera == "camera1" and round(10.0 * time) % 20 == 0 else []

    person = anna(made_run({"anna": HERE}, 80, now_and_then))
    (words,) = person.history
    assert words.startswith("2 on trial ended unconfirmed; the last ended at 2.70 s, last hit at 2.00 s by camera1")


def test_a_track_of_nobody_says_since_when_and_which_boxes_feed_it() -> None:
    (person,), (stray,) = told(made_run({"anna": (13.0, 0.0)}, 21, seen_by_camera1_until(0.8, HERE)))
    assert person.track is None
    assert stray.track == 0 and stray.nearest == ("anna", pytest.approx(7.0, abs=0.4))
    assert "began at 0.00 s by camera1 at (" in stray.text
    assert "confirmed at 0.20 s; fed by 8 of camera1 in the 2 s up to 0.70 s by camera1" in stray.text


def test_every_box_says_what_it_became() -> None:
    off_floor = (6.0, 2.2)
    run = made_run({"anna": HERE}, 21, seen_by_camera1_until(9.0, HERE, off_floor, (9.9, 0.0)))
    boxes = explain_boxes(replayed(run))
    assert [box.text.split("(")[0] for box in boxes] == [
        "track 0",
        "its place ",
        "the box is 102 px tall, and the smallest that is measured 104 px",
    ]
    assert boxes[1].text.endswith("is off the floor")
    assert boxes[0].measured is not None and boxes[1].measured is None
    assert boxes[1].foot_point == pytest.approx(off_floor, abs=0.6)


def test_a_refused_box_is_that_of_whom_it_covers_most_and_of_nobody_else() -> None:
    people, _ = told(made_run({"anna": (9.9, 0.0), "bob": (10.3, 0.25)}, 21, seen_by_camera1_until(9.0, (9.9, 0.0))))
    assert of_camera(people[0], "camera1").startswith("detection refused: the box is 102 px tall")
    assert of_camera(people[1], "camera1").startswith("no detection: too far: the box would be ")
