"""The tracker on simulated measurement streams of cameras that face each other along a corridor."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from han_bullet.geometry import Array, Intrinsics, Pose2D, look_at, rotation
from han_bullet.messages import Frame, Posture, Scan, Seat, TrackedPerson
from han_bullet.tracking.association import GlobalNearestNeighbour, NearestNeighbour
from han_bullet.tracking.field_of_view import FieldOfView
from han_bullet.tracking.tracker import MultiCameraTracker
from han_bullet.world_schema import FloorArea

INTRINSICS = Intrinsics.from_vertical_field_of_view(640, 480, math.radians(45.0))
EMPTY = np.zeros((480, 640, 3), np.uint8)
VIEW = FieldOfView()
ALONG, ACROSS = 0.15, 0.05  # scatter of a measurement along and across the viewing ray [m]
TICK = 0.05  # [s]; cameras at every second tick

People = Callable[[float], list[tuple[float, float]]]


def camera(name: str, x: float, target: float) -> Frame:
    return Frame(name, 0.0, EMPTY, INTRINSICS, look_at(np.array([x, 0.0, 2.6]), np.array([target, 0.0, 0.9])), True)


# Sees x from 3.6 to 8.9 m; the other, which faces it, from 7.1 to 12.4 m.
EASTWARD, WESTWARD = camera("east", 0.2, 6.2), camera("west", 15.8, 9.8)
# Sees x from 11.6 to 16.9 m: with the first, 2.7 m remain that nobody sees.
BEYOND = camera("beyond", 8.2, 14.2)


def scan(frame: Frame, time: float, people: Sequence[tuple[float, float]], rng: np.random.Generator) -> Scan:
    """Measure whom the camera sees, nine times in ten, with anisotropic noise."""
    positions = np.array(people, float).reshape(-1, 2)
    found = positions[VIEW.sees(frame, positions) & (rng.random(len(positions)) < 0.9)]
    measured, covariances = [], []
    for place in found:
        ray = place - frame.camera_in_world[:2, 3]
        axes = rotation(math.atan2(ray[1], ray[0]))
        measured.append(place + axes @ rng.normal(0.0, [ALONG, ACROSS]))
        covariances.append(axes @ np.diag([ALONG**2, ACROSS**2]) @ axes.T)
    return at(frame, time, measured, covariances)


def at(frame: Frame, time: float, places: Sequence[Array], covariances: Sequence[Array] | None = None) -> Scan:
    """Return a scan of given places; covariance (0.1 m)^2 unless told."""
    shaped = np.array(covariances if covariances is not None else [0.01 * np.eye(2)] * len(places)).reshape(-1, 2, 2)
    positions = np.array(places, float).reshape(-1, 2)
    return Scan(frame.camera, time, positions, shaped, np.arange(len(positions)), replace(frame, time=time))


Log = list[tuple[float, tuple[TrackedPerson, ...]]]


def follow(
    people: People,
    duration: float,
    cameras: Sequence[Frame] = (EASTWARD, WESTWARD),
    seed: int = 1,
    tracker: MultiCameraTracker | None = None,
    start: float = 0.0,
) -> tuple[Log, MultiCameraTracker]:
    """Run a tracker over people who move as told, and log what it believes at every control tick."""
    rng = np.random.default_rng(seed)
    tracker = tracker or MultiCameraTracker(field_of_view=VIEW)
    log: Log = []
    for k in range(round(duration / TICK) + 1):
        time = start + k * TICK
        scans = [scan(frame, time, people(time), rng) for frame in cameras] if k % 2 == 0 else []
        log.append((time, tracker.update(scans, time)))
    return log, tracker


def errors(log: Log, people: People, since: float) -> Array:
    """Return the distances [m] between the only track and the only person."""
    return np.array([math.dist(p[0].position_in_world, people(t)[0]) for t, p in log if t >= since])


def lone_walker(speed: float, start: float = 6.6, departs: float = 0.0) -> People:
    return lambda time: [(start + speed * max(0.0, time - departs), -0.2)]


def test_a_walker_seen_by_two_facing_cameras_is_placed_within_twelve_centimetres() -> None:
    people = lone_walker(0.35)
    log, _ = follow(people, 8.0)
    assert {len(p) for t, p in log if t > 0.5} == {1}
    settled = [p[0] for t, p in log if t >= 3.0]
    assert math.sqrt(np.mean(errors(log, people, 3.0) ** 2)) < 0.12
    assert {person.posture for person in settled} == {Posture.WALKING}
    assert {person.id for person in settled} == {0}
    assert math.degrees(math.sqrt(np.mean([person.heading**2 for person in settled]))) < 12.0
    assert np.mean([person.speed for person in settled]) == pytest.approx(0.35, abs=0.06)


def test_a_track_is_as_far_from_the_truth_as_its_covariance_says() -> None:
    people, normalized = lone_walker(0.35), []
    for seed in range(12):
        log, _ = follow(people, 8.0, seed=seed)
        for time, persons in log[80::20]:
            error = np.array(
                [*(persons[0].position_in_world - people(time)[0]), *(persons[0].velocity_in_world - [0.35, 0])]
            )
            normalized.append(error @ np.linalg.solve(persons[0].covariance, error))
    # 60 values of mean 4; a walker at constant speed accelerates less than the filter allows for.
    assert len(normalized) == 60
    assert 1.5 < np.mean(normalized) < 5.5


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_walker_at_0_4_metres_per_second_is_noticed_within_two_seconds(seed: int) -> None:
    log, _ = follow(lone_walker(0.4, departs=3.0), 8.0, seed=seed)
    walking = [(t, p[0]) for t, p in log if p and p[0].posture is Posture.WALKING]
    assert 0.5 < walking[0][0] - 3.0 < 2.0
    assert abs(math.degrees(walking[0][1].heading or 9.9)) < 25.0
    assert all(p[0].posture is Posture.STANDING and p[0].heading is None for t, p in log if 0.5 < t < 3.0)


def test_a_stander_does_not_walk_in_a_minute() -> None:
    log, tracker = follow(lambda time: [(8.0, 0.3)], 60.0)
    people = [p for t, p in log if t > 0.5]
    assert {len(p) for p in people} == {1}
    assert {(p[0].id, p[0].posture, p[0].heading) for p in people} == {(0, Posture.STANDING, None)}
    living = tracker.records[-1]
    assert living.id == 0 and living.ended_time is None
    assert sum(living.hits.values()) > 1000 and sum(living.misses.values()) > 60


def test_who_stops_holds_the_heading_in_which_they_walked() -> None:
    log, _ = follow(lambda time: [(11.5 - 0.5 * min(time, 6.0), 0.2)], 12.0)
    last = log[-1][1][0]
    assert last.posture is Posture.STANDING
    assert last.heading is not None and abs(math.degrees(last.heading)) > 165.0
    noticed = next(t for t, p in log if t > 6.0 and p[0].posture is Posture.STANDING)
    assert noticed - 6.0 < 2.5


@pytest.mark.parametrize("association", [None, GlobalNearestNeighbour(), NearestNeighbour()])
def test_two_people_who_cross_keep_their_ids(association: NearestNeighbour | GlobalNearestNeighbour | None) -> None:
    def people(time: float) -> list[tuple[float, float]]:
        return [(6.8 + 0.45 * time, 0.4), (10.4 - 0.45 * time, -0.4)]

    log, _ = follow(people, 7.0, tracker=MultiCameraTracker(field_of_view=VIEW, association=association))
    early = next(p for t, p in log if t > 1.5)
    assert len(early) == 2
    late = log[-1][1]
    assert [p.id for p in late] == [0, 1]
    for before, after in zip(early, late, strict=True):
        assert np.sign(before.position_in_world[1]) == np.sign(after.position_in_world[1])
        assert math.dist(after.position_in_world, people(7.0)[0 if after.position_in_world[1] > 0 else 1]) < 0.25


def test_a_walker_keeps_the_id_across_the_gap_between_two_views() -> None:
    people = lone_walker(1.0, start=4.5)
    log, tracker = follow(people, 9.0, cameras=(EASTWARD, BEYOND))
    hidden = [t for t, _ in log if not any(VIEW.sees(f, np.array(people(t)))[0] for f in (EASTWARD, BEYOND))]
    assert hidden[-1] - hidden[0] == pytest.approx(2.7, abs=0.2)
    assert {p.id for t, ps in log if t > 1.0 for p in ps} == {0}
    assert {len(p) for t, p in log if t > 1.0} == {1}
    spread = [p[0].covariance[0, 0] for t, p in log if hidden[0] + 0.2 < t <= hidden[-1]]
    assert np.all(np.diff(spread) > 0.0)
    assert set(tracker.records[-1].hits) == {"east", "beyond"}


def test_somebody_who_sets_off_faster_than_the_model_expects_leaves_no_ghost_and_keeps_the_id() -> None:
    for seed in range(4):
        log, _ = follow(lone_walker(1.2, start=6.8, departs=3.0), 5.0, seed=seed)
        assert [p.id for p in log[-1][1]] == [0]
        assert log[-1][1][0].posture is Posture.WALKING


def test_ids_count_from_zero_in_every_tracker() -> None:
    for _ in range(2):
        log, _ = follow(lambda time: [(8.0, 0.6), (8.0, -0.6)], 1.0)
        assert [p.id for p in log[-1][1]] == [0, 1]


def test_a_person_is_confirmed_by_three_hits_within_half_a_second() -> None:
    place = [np.array([7.0, 0.0])]
    quick, slow = (MultiCameraTracker(field_of_view=VIEW) for _ in range(2))
    assert [len(quick.update([at(EASTWARD, t, place)], t)) for t in (0.0, 0.25, 0.5)] == [0, 0, 1]
    assert [len(slow.update([at(EASTWARD, t, place)], t)) for t in (0.0, 0.3, 0.6)] == [0, 0, 0]


def life_after(
    posture: Posture, seats: tuple[Seat, ...] = (), cameras: Sequence[Frame] = (EASTWARD, WESTWARD)
) -> float:
    """Return how long a person of a posture is believed in after they vanished in view [s]."""
    people = lone_walker(0.3 if posture is Posture.WALKING else 0.0, start=7.0)
    log, tracker = follow(people, 5.0, tracker=MultiCameraTracker(field_of_view=VIEW, seats=seats))
    assert [p.posture for p in log[-1][1]] == [posture]
    vanished = max(p.time for p in log[-1][1])
    after, tracker = follow(lambda time: [], 14.0, cameras=cameras, tracker=tracker, start=vanished + 0.1)
    assert not after[-1][1]
    assert tracker.records[-1].reason is not None
    return next(t for t, p in after if not p) - vanished


def test_tracks_live_as_long_without_hits_as_their_posture_allows() -> None:
    seat = Seat("couch", np.array([7.0, 0.3]), -0.5 * math.pi, 0.8, 1.9)
    assert life_after(Posture.WALKING) == pytest.approx(1.5, abs=0.2)
    assert life_after(Posture.STANDING) == pytest.approx(3.0, abs=0.2)
    assert life_after(Posture.SEATED, (seat,)) == pytest.approx(10.0, abs=0.2)


def test_somebody_seated_is_gone_a_second_after_a_camera_shows_the_seat_to_be_empty() -> None:
    seat = Seat("couch", np.array([7.0, 0.3]), -0.5 * math.pi, 0.8, 1.9)
    _, tracker = follow(lone_walker(0.0, start=7.0), 5.0, tracker=MultiCameraTracker(field_of_view=VIEW, seats=[seat]))
    scans = [replace(at(EASTWARD, 5.1 + 0.1 * k, []), empty_seats=("couch",)) for k in range(30)]
    alive = [scan.time for scan in scans if tracker.update([scan], scan.time)]
    assert alive[-1] == pytest.approx(6.0)  # without the rule it would be 15
    assert tracker.records[-1].reason == "its seat was seen to be empty for 1.00 s by east"


def test_a_young_track_dies_soon() -> None:
    log, tracker = follow(lambda time: [(8.0, 0.0)] if time < 1.0 else [], 3.0)
    gone = next(t for t, p in log if t > 1.0 and not p)
    assert gone - 0.95 == pytest.approx(0.6, abs=0.15)
    assert "in view without a hit" in (tracker.records[0].reason or "")


def test_a_frame_that_cannot_show_a_person_is_no_miss() -> None:
    """In view, a walker's track would end after 1.5 s; the camera that still delivers looks elsewhere: it lives 3 s."""
    assert life_after(Posture.WALKING, cameras=[replace(BEYOND, camera="elsewhere")]) == pytest.approx(3.0, abs=0.2)
    log, tracker = follow(lambda time: [(5.0, 0.0)], 3.0)
    assert log[-1][1] and tracker.records[-1].misses.keys() <= {"east"}


def test_somebody_hidden_behind_another_person_is_no_miss() -> None:
    def people(time: float) -> list[tuple[float, float]]:
        return [(5.0, 0.0), (5.8, 0.0)] if time < 3.0 else [(5.0, 0.0)]

    log, _ = follow(people, 5.8, cameras=[EASTWARD])
    assert len([p for t, p in log if t <= 3.0][-1]) == 2
    # A young or walking track in view would be gone; standing ones out of sight stay for three seconds.
    assert len(log[-1][1]) == 2
    assert sum(r.misses.get("east", 0) for r in follow(people, 5.8, cameras=[EASTWARD])[1].records if r.id == 1) == 0


def test_a_seated_person_is_reported_on_the_declared_seat() -> None:
    seat = Seat("couch", np.array([8.0, 0.5]), -0.5 * math.pi, 0.8, 1.9, "tv")
    log, _ = follow(lambda time: [(8.1, 0.0)], 2.0, tracker=MultiCameraTracker(field_of_view=VIEW, seats=[seat]))
    person = log[-1][1][0]
    assert (person.posture, person.seat, person.heading) == (Posture.SEATED, "couch", pytest.approx(-0.5 * math.pi))
    assert person.position_in_world.tolist() == [8.0, 0.5]
    assert person.speed == 0.0


def test_who_gets_up_from_a_seat_leaves_it_empty_and_keeps_the_id() -> None:
    seat = Seat("couch", np.array([8.0, 0.5]), -0.5 * math.pi, 0.8, 1.9, "tv")

    def people(time: float) -> list[tuple[float, float]]:
        return [(8.0, 0.0)] if time < 4.0 else [(8.0 - 0.7 * (time - 4.0), -0.6)]

    log, _ = follow(people, 7.0, tracker=MultiCameraTracker(field_of_view=VIEW, seats=[seat]))
    assert next(p for t, p in log if t > 3.0)[0].posture is Posture.SEATED
    assert [(p.id, p.posture) for p in log[-1][1]] == [(0, Posture.WALKING)]


def test_who_gets_up_keeps_the_id_though_the_seat_is_seen_to_be_empty_at_once() -> None:
    seat, rng = Seat("couch", np.array([8.0, 0.5]), -0.5 * math.pi, 0.8, 1.9, "tv"), np.random.default_rng(1)
    tracker = MultiCameraTracker(field_of_view=VIEW, seats=[seat])
    for k in range(70):
        time = 0.1 * k
        place = (8.0, 0.0) if time < 4.0 else (8.0 - 0.7 * (time - 4.0), -0.6)
        looks = [scan(frame, time, [place], rng) for frame in (EASTWARD, WESTWARD)]
        empty = ("couch",) if time >= 4.0 else ()
        people = tracker.update([replace(look, empty_seats=empty) for look in looks], time)
    assert [(person.id, person.posture) for person in people] == [(0, Posture.WALKING)]


def test_two_cameras_that_place_one_sitter_apart_make_one_person() -> None:
    seat = Seat("couch", np.array([8.0, 0.5]), -0.5 * math.pi, 0.8, 1.9, "tv")
    left, right = np.array([7.5, 0.2]), np.array([8.6, 0.2])
    apart, together = (MultiCameraTracker(field_of_view=VIEW, seats=[seat]) for _ in range(2))
    for k in range(20):
        time = 0.1 * k
        one = apart.update([at(EASTWARD, time, [left]), at(WESTWARD, time, [right])], time)
        two = together.update([at(EASTWARD, time, [left, right])], time)
    assert [(p.id, p.posture) for p in one] == [(0, Posture.SEATED)]
    assert [(p.id, p.posture) for p in two] == [(0, Posture.SEATED), (1, Posture.SEATED)]


def test_somebody_in_line_with_a_seat_whom_a_camera_places_on_it_does_not_double_the_sitter() -> None:
    """From beside the couch, the camera sees the sitter and, far behind the couch, somebody whose feet it hides."""
    seat = Seat("couch", np.array([8.0, 0.5]), -0.5 * math.pi, 0.8, 1.9, "tv")
    tracker = MultiCameraTracker(field_of_view=VIEW, seats=[seat])
    for k in range(20):
        time = 0.1 * k
        ceiling = at(EASTWARD, time, [np.array([8.02, 0.0])])
        along = np.diag([0.55**2, 0.11**2])
        beside = at(WESTWARD, time, [np.array([8.0, 0.3]), np.array([8.0, 0.55])], [along, along])
        people = tracker.update([ceiling, beside], time)
    assert [(p.id, p.posture) for p in people] == [(0, Posture.SEATED)]


def test_nobody_is_predicted_through_a_wall() -> None:
    def people(time: float) -> list[tuple[float, float]]:
        return [(5.0 + 0.8 * time, 0.0)]

    floor = FloorArea(x=(0.0, 9.0), y=(-1.5, 1.5), texture="tiles")
    log, tracker = follow(people, 8.0, [EASTWARD], tracker=MultiCameraTracker(field_of_view=VIEW, floor=[floor]))
    assert max(p[0].position_in_world[0] for t, p in log if p) == pytest.approx(9.3, abs=0.1)
    assert tracker.records[0].reason == "predicted off the floor"
    beyond, _ = follow(people, 8.0, [EASTWARD])
    assert max(p[0].position_in_world[0] for t, p in beyond if p) > 10.0


def test_a_second_box_around_one_person_makes_no_second_person() -> None:
    tracker = MultiCameraTracker(field_of_view=VIEW)
    for k in range(20):
        places = [np.array([8.0, 0.0]), np.array([8.3, 0.1])]
        people = tracker.update([at(EASTWARD, 0.1 * k, places)], 0.1 * k)
    assert [p.id for p in people] == [0]


def test_two_people_side_by_side_stay_two() -> None:
    log, _ = follow(lambda time: [(8.0, 0.3), (8.0, -0.3)], 20.0)
    assert {len(p) for t, p in log if t > 2.0} == {2}
    assert {p.id for t, ps in log if t > 2.0 for p in ps} == {0, 1}


def test_equal_scans_give_equal_people_bit_for_bit() -> None:
    people = lone_walker(0.35)
    first, second = (follow(people, 3.0)[0][-1][1][0] for _ in range(2))
    assert np.array_equal(first.position_in_world, second.position_in_world)
    assert np.array_equal(first.covariance, second.covariance)


def test_the_order_of_scans_taken_at_different_times_does_not_matter() -> None:
    early = [at(EASTWARD, 0.1 * k, [np.array([7.0 + 0.1 * k, 0.0])]) for k in range(5)]
    sorted_, reversed_ = (MultiCameraTracker(field_of_view=VIEW) for _ in range(2))
    one, other = sorted_.update(early, 0.5)[0], reversed_.update(early[::-1], 0.5)[0]
    assert np.array_equal(one.position_in_world, other.position_in_world)


def test_people_are_predicted_to_the_time_asked_for() -> None:
    people = lone_walker(0.8, start=6.0)
    log, tracker = follow(people, 4.0)
    now, later = log[-1][1][0], tracker.update([], 4.5)[0]
    assert later.time == 4.5
    assert later.position_in_world == pytest.approx(now.position_in_world + 0.5 * now.velocity_in_world)
    assert later.covariance[0, 0] > now.covariance[0, 0]


def test_the_life_of_a_track_can_be_told_afterwards() -> None:
    _, tracker = follow(lambda time: [(5.0, 0.0)] if time < 2.5 else [], 8.0)
    (record,) = [r for r in tracker.records if r.id == 0]
    assert (record.born_by, record.born_time) == ("east", 0.0)
    assert record.born_at == pytest.approx((5.0, 0.0), abs=0.5)
    assert record.confirmed_time == pytest.approx(0.2, abs=0.11)
    assert record.ended_time is not None and record.ended_time > 2.5
    assert 15 <= record.hits["east"] <= 25
    assert record.misses["east"] >= 25


def test_a_record_tells_the_recent_hits_their_boxes_and_who_missed_since() -> None:
    tracker = MultiCameraTracker(field_of_view=VIEW)
    here, other = np.array([7.5, 0.0]), np.array([7.5, 1.2])
    for k in range(40):  # the person is the second box of each image
        tracker.update([at(EASTWARD, 0.1 * k, [other, here] if k % 2 else [other])], 0.1 * k)
    for k in range(40, 43):
        tracker.update([at(EASTWARD, 0.1 * k, []), at(WESTWARD, 0.1 * k, [])], 0.1 * k)
    (record,) = [r for r in tracker.records if r.id == 1]
    assert {(hit.camera, hit.detection) for hit in record.recent_hits} == {("east", 1)}
    assert record.last_hit == record.recent_hits[-1].time == pytest.approx(3.9)
    assert record.recent_hits[0].time == pytest.approx(2.0, abs=0.11)
    assert record.hit_at == pytest.approx((7.5, 0.0), abs=0.02)
    assert record.missed_by == ("east", "west")


def test_somebody_hidden_behind_the_robot_is_no_miss() -> None:
    place = [np.array([5.7, 0.0])]
    for robot, misses in ((Pose2D(5.0, 0.0, 0.0), 0), (Pose2D(5.0, 1.2, 0.0), 5)):
        tracker = MultiCameraTracker(field_of_view=VIEW)
        for k in range(25):
            seen = at(EASTWARD, 0.1 * k, place if k < 20 else [])
            tracker.update([replace(seen, pose_robot_in_world=robot)], 0.1 * k)
        assert tracker.records[-1].misses.get("east", 0) == misses


def test_a_track_on_trial_hides_nobody() -> None:
    """A false measurement before a person must not explain why that person is not found."""
    tracker = MultiCameraTracker(field_of_view=VIEW)
    for k in range(25):
        places = [np.array([5.8, 0.0])] if k < 20 else [np.array([5.0, 0.0])] if k == 20 else []
        tracker.update([at(EASTWARD, 0.1 * k, places)], 0.1 * k)
    person, trial = (r for r in tracker.records if r.ended_time is None)
    assert (person.id, trial.id) == (0, None)
    assert person.misses == {"east": 5}


def test_confirmed_people_choose_before_tracks_on_trial() -> None:
    tracker = MultiCameraTracker(field_of_view=VIEW)
    for k in range(10):
        tracker.update([at(EASTWARD, 0.1 * k, [np.array([7.0, 0.0])])], 0.1 * k)
    tracker.update([at(EASTWARD, 1.0, [np.array([7.0, 0.0]), np.array([7.5, 0.0])])], 1.0)
    assert [r.id for r in tracker.records] == [0, None]
    # Nearer to the trial's place, and inside the gates of both.
    tracker.update([at(EASTWARD, 1.1, [np.array([7.3, 0.0])])], 1.1)
    assert [sum(r.hits.values()) for r in tracker.records if r.ended_time is None] == [12, 1]


def test_of_somebody_who_is_not_seen_nothing_new_is_known() -> None:
    """Seen for half a second, a walker is not known as one; a prediction that goes on adds way, but no evidence."""
    tracker = MultiCameraTracker(field_of_view=VIEW)
    for k in range(6):
        exact = at(EASTWARD, 0.1 * k, [np.array([5.0 + 0.035 * k, 0.0])], [1e-6 * np.eye(2)])
        people = tracker.update([exact], 0.1 * k)
    assert people[0].posture is Posture.STANDING and people[0].speed == pytest.approx(0.35, abs=0.05)
    for k in range(6, 11):
        people = tracker.update([at(BEYOND, 0.1 * k, [])], 0.1 * k)
        assert people[0].posture is Posture.STANDING
