"""Recall, MOTA, OSPA and the age of frames, on ticks whose figures can be worked out by hand."""

import math
from collections.abc import Iterable

import pytest
from ticks import CAMERA, frame, make_world, person, scan, tick, track

from han_bullet.episode import Tick
from han_bullet.metrics import Metrics, Value


def measure(ticks: Iterable[Tick], *people: str) -> dict[str, Value]:
    metrics = Metrics(make_world(*people))
    for one in ticks:
        metrics.record(one)
    return {metric.name: metric.value for metric in metrics.results()}


ROBOT = (19.0, 1.5, 0.0)  # far from what the camera at x = 0 looks at


def test_mota_takes_misses_false_tracks_and_switches_from_one() -> None:
    anna, bob = person("anna"), person("bob", x=5.0)
    ticks = [
        tick(0, people=[anna, bob], tracks=[track(0, 0.1), track(1, 5.1)]),
        tick(1, people=[anna, bob], tracks=[track(0, 0.1)]),  # a miss
        tick(2, people=[anna, bob], tracks=[track(0, 0.1), track(1, 5.1), track(7, 9.0)]),  # a false track
        tick(3, people=[anna, bob], tracks=[track(0, 0.1), track(1, 5.1), track(8, 5.4)]),  # a duplicate
        tick(4, people=[anna, bob], tracks=[track(0, 0.1), track(9, 5.1)]),  # a switch
    ]
    assert measure(ticks, "anna", "bob")["mota"] == pytest.approx(1.0 - 4.0 / 10.0)


def test_mota_counts_only_people_whom_a_camera_shows() -> None:
    # 1 m before the camera a person is cut off, 5 m before it whole; frames come at every second tick and hold.
    places = [1.0] * 4 + [5.0] * 6
    ticks = [
        tick(
            i,
            robot=ROBOT,
            people=[person(x=x)],
            frames=[frame(time=0.05 * i)] if i % 2 == 0 else [],
            tracks=[track(0, x)] if i >= 7 else [],
        )
        for i, x in enumerate(places)
    ]
    values = measure(ticks, "walker")
    assert values["mota"] == pytest.approx(1.0 - 3.0 / 6.0)  # ticks 4 to 9, missed at 4, 5 and 6
    # OSPA: 0 at ticks 0 to 3 with neither, 1 m at the three misses, 0 then.
    assert values["ospa"] == pytest.approx(3.0 / 10.0)


def test_a_track_of_somebody_no_camera_shows_is_neither_right_nor_wrong() -> None:
    ticks = [tick(i, robot=ROBOT, people=[person(x=1.0)], tracks=[track(0, 1.2)], frames=[frame()]) for i in range(3)]
    values = measure(ticks, "walker")
    assert (values["mota"], values["ospa"]) == (None, 0.0)


def test_ospa_is_the_mean_over_ticks() -> None:
    someone = person()
    ticks = [
        tick(0, people=[someone], tracks=[track(0, 0.3)]),  # 0.3 m
        tick(1, people=[someone], tracks=[track(0, 0.0), track(1, 4.0)]),  # sqrt(1/2 * 1^2)
        tick(2, people=[someone]),  # 1 m
    ]
    assert measure(ticks, "walker")["ospa"] == pytest.approx((0.3 + math.sqrt(0.5) + 1.0) / 3.0)


def test_recall_is_counted_by_frame_and_person_shown() -> None:
    image = frame(CAMERA)
    anna, bob, cut = person("anna", 5.0, 1.2), person("bob", 6.5, -1.0), person("cut", 1.0)
    people = [anna, bob, cut]
    foot_points = [
        [(5.0, 1.5), (6.5, -0.5)],  # both found
        [(5.0, 1.3)],  # anna
        [(9.0, 0.0)],  # nobody
    ]
    ticks = [
        tick(i, robot=ROBOT, people=people, frames=[image], scans=[scan(points, image)])
        for i, points in enumerate(foot_points)
    ]
    ticks.append(tick(3, robot=ROBOT, people=people))  # no frame
    values = measure(ticks, "anna", "bob", "cut")
    assert values["detection_recall.anna"] == pytest.approx(2.0 / 3.0)
    assert values["detection_recall.bob"] == pytest.approx(1.0 / 3.0)
    assert values["detection_recall.cut"] is None
    assert values["detection_recall"] == pytest.approx(3.0 / 6.0)


def test_one_foot_point_finds_one_person() -> None:
    image = frame(CAMERA)
    people = [person("anna", 5.0, 0.4), person("bob", 5.0, -0.4)]
    values = measure(
        [tick(0, robot=ROBOT, people=people, frames=[image], scans=[scan([(5.0, 0.0)], image)])], "anna", "bob"
    )
    assert values["detection_recall"] == 0.5


def test_nobody_is_missed_behind_somebody_else_or_behind_the_robot() -> None:
    image = frame(CAMERA)
    pair = [person("front", 5.0), person("behind", 5.8)]
    values = measure([tick(0, robot=ROBOT, people=pair, frames=[image])], "front", "behind")
    assert (values["detection_recall.front"], values["detection_recall.behind"]) == (0.0, None)
    hidden = measure([tick(0, robot=(5.2, 0.0, 0.0), people=pair[1:], frames=[image])], "front", "behind")
    assert hidden["detection_recall.behind"] is None


def test_the_age_of_a_frame_counts_from_its_exposure_to_the_command_that_heeds_it() -> None:
    # Exposed at 0, come at once, the next at 0.1 s come a tick late.
    ticks = [
        tick(0, frames=[frame(time=0.0)]),
        tick(1),
        tick(2),
        tick(3, frames=[frame(time=0.1)]),
    ]
    values = measure(ticks)
    assert values["frame_age_mean"] == pytest.approx((0.0 + 0.05 + 0.10 + 0.05) / 4.0)
    assert values["frame_age_max"] == pytest.approx(0.10)
    assert measure([tick(0)])["frame_age_mean"] is None
