"""Legs help cameras: what the laser says of people, and what the tracker makes of it."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from simulated_laser import SCANNER_IN_BODY, Laser
from test_tracker import EASTWARD, VIEW, at
from ticks import track

from benchmarks.legs import compare, scanner_before
from han_bullet.geometry import Array, Pose2D, SolidBox
from han_bullet.messages import LaserScan, LegScan, PoseEstimate, Posture, Seat, TrackedPerson
from han_bullet.sim.gait import Gait
from han_bullet.tracking.building import BUILDING_TOLERANCE
from han_bullet.tracking.legs import LaserLegs
from han_bullet.tracking.track import LEGS_ALONE, OUTSIDE_LIFE
from han_bullet.tracking.tracker import MultiCameraTracker
from han_bullet.world_schema import FloorArea

ROBOT = Pose2D(5.0, 0.0, 0.0)
SCANNER = ROBOT.compose(SCANNER_IN_BODY)
HERE = PoseEstimate(0.0, ROBOT)
FINDER = LaserLegs()
LEG = 0.06  # [m]
BESIDE, BEHIND = 0.1, 0.2  # half of what is between legs, and how far a hidden leg is behind the other [m]

Place = tuple[float, float]


def sweep(*legs: Place, time: float = 0.0, boxes: tuple[SolidBox, ...] = (), seed: int = 0) -> LaserScan:
    discs = np.array([(*leg, LEG) for leg in legs]).reshape(-1, 3)
    return Laser(boxes).scan(time, ROBOT, discs, np.random.default_rng(seed))


def pair(x: float, y: float) -> tuple[Place, Place]:
    """The legs of somebody who faces along x."""
    return (x, y + BESIDE), (x, y - BESIDE)


def measured(*legs: Place, estimate: PoseEstimate = HERE, **more: int) -> LegScan:
    scan = FINDER.find(sweep(*legs, **more), estimate, ())
    assert scan is not None
    return scan


def test_two_legs_are_one_person_between_them() -> None:
    legs = measured(*pair(7.0, 0.3))
    assert legs.positions == pytest.approx(np.array([[7.0, 0.3]]), abs=0.03)
    assert math.sqrt(legs.covariances[0, 0, 0]) == pytest.approx(0.05)


def test_a_single_leg_hides_the_other_and_its_person_is_behind_its_axis() -> None:
    front = SCANNER.x + 2.0
    legs, both = measured((front, 0.0), (front + BEHIND, 0.0)), measured(*pair(front, 0.0))
    assert len(legs.positions) == 1
    assert legs.positions[0] == pytest.approx([front + 0.5 * BEHIND, 0.0], abs=0.04)
    assert np.all(np.linalg.eigvalsh(legs.covariances[0]) > 2.0 * np.linalg.eigvalsh(both.covariances[0]))


def test_the_pose_of_the_robot_makes_legs_less_sure() -> None:
    turned = PoseEstimate(0.0, ROBOT, np.diag([0.0, 0.0, 0.05]) ** 2)
    moved = PoseEstimate(0.0, ROBOT, np.diag([0.2, 0.0, 0.0]) ** 2)
    exact, by_turn, by_way = (measured(*pair(8.2, 0.0), estimate=e).covariances[0] for e in (HERE, turned, moved))
    assert by_turn - exact == pytest.approx(np.diag([0.0, 0.15**2]), abs=1e-3)
    assert by_way - exact == pytest.approx(np.diag([0.04, 0.0]), abs=1e-3)


@pytest.mark.parametrize("posture", [Posture.STANDING, Posture.WALKING])
def test_legs_are_as_far_from_the_true_person_as_they_claim(posture: Posture) -> None:
    errors, total = compare(posture, 1.0, 3.0, people=8, seed=1)
    assert total > 100 and len(errors) > 0.98 * total
    assert abs(np.mean([error.along for error in errors])) < 0.02
    assert math.sqrt(np.mean([error.along**2 + error.across**2 for error in errors])) < 0.07
    assert 0.03 < 0.5 * np.mean([error.squared for error in errors]) < 1.0


def test_somebody_beside_a_post_is_measured_without_it() -> None:
    """Nearest legs pair first: the post, as far from a leg as a stride, is a candidate of its own."""
    legs = measured(*pair(7.0, 0.0), (7.0, 0.5))
    assert len(legs.positions) == 2
    assert legs.positions[0] == pytest.approx([7.0, 0.0], abs=0.03)


def test_nothing_is_told_without_a_sweep_or_a_pose() -> None:
    assert FINDER.find(None, HERE, ()) is None
    assert FINDER.find(sweep(*pair(7.0, 0.0)), replace(HERE, lost=True), ()) is None
    assert FINDER.find(sweep(), HERE, ()) is None


def test_in_a_sitting_area_legs_are_left_to_the_cameras() -> None:
    seat = Seat("couch", np.array([7.4, 0.0]), math.pi, 0.8, 1.9)
    finder = LaserLegs(seats=[seat])
    assert finder.find(sweep(*pair(6.9, 0.0)), HERE, ()) is None
    assert finder.find(sweep(*pair(6.9, 1.5)), HERE, ()) is not None
    assert finder.find(sweep(), HERE, [track(3, 6.9, 0.0)]) is None


def vacant(person: TrackedPerson, *legs: Place, boxes: tuple[SolidBox, ...] = ()) -> bool:
    legs_found = FINDER.find(sweep(*legs, boxes=boxes), HERE, [person])
    return legs_found is not None and legs_found.vacant == (person.id,)


def test_a_place_is_vacant_where_rays_pass_all_over_it() -> None:
    wall = SolidBox("wall", "wall", np.array([8.0, 0.0, 1.0]), np.array([0.1, 6.0, 2.0]), 0.0)
    near = track(4, 6.7, 0.1)
    assert vacant(near) and vacant(near, boxes=(wall,))
    assert not vacant(near, *pair(6.7, 0.1))
    assert not vacant(near, (6.85, 0.45))  # as far off as the track may be
    assert not vacant(near, (6.0, 0.1))  # something stands before
    assert not vacant(track(4, 7.6, 0.1))  # too far to be sure
    assert not vacant(track(4, 4.4, 0.0))  # behind the robot, where the scanner does not look
    assert not vacant(replace(near, posture=Posture.SEATED))
    assert not vacant(track(4, 6.7, 0.1, covariance=np.eye(4)))  # may be anywhere


def test_a_walker_is_looked_for_where_they_have_got_to() -> None:
    walker = track(4, 6.2, 0.0, velocity=(1.0, 0.0))
    later = sweep(*pair(7.0, 0.0), time=0.8)
    assert FINDER.find(later, replace(HERE, time=0.8), [walker]).vacant == ()  # type: ignore[union-attr]
    gone = sweep(*pair(6.0, -0.9), time=0.8)
    assert FINDER.find(gone, replace(HERE, time=0.8), [walker]).vacant == (4,)  # type: ignore[union-attr]


# The tracker.

Log = list[tuple[float, tuple[TrackedPerson, ...]]]
Legs = Callable[[float], Sequence[Place]]
Seen = Callable[[float], Sequence[Place] | None]


def follow(tracker: MultiCameraTracker, legs: Legs, seen: Seen, until: float, seed: int = 0) -> Log:
    """Sweep at 10 Hz and photograph, where `seen` is not None; the camera errs by 0.1 m."""
    rng, log, people = np.random.default_rng(seed), [], ()
    for k in range(round(until / 0.1) + 1):
        time = 0.1 * k
        shown = seen(time)
        scans = [at(EASTWARD, time, [np.array(place) + rng.normal(0.0, 0.1, 2) for place in shown or ()])]
        found = FINDER.find(sweep(*legs(time), time=time, seed=k), replace(HERE, time=time), people)
        people = tracker.update(scans if shown is not None else [], time, legs=found)
        log.append((time, people))
    return log


def tracker_of(**more: Sequence[Seat]) -> MultiCameraTracker:
    return MultiCameraTracker(field_of_view=VIEW, **more)


def test_while_cameras_are_late_alike_their_frames_still_place_and_the_walker_still_walks() -> None:
    """The frames come 0.4 s late, in order; the laser speaks of now, and says only that somebody else is not there."""
    tracker = tracker_of()
    for k in range(40):
        time = 0.1 * k
        taken = time - 0.4
        scans = [at(EASTWARD, taken, [(6.0 + 0.8 * taken, 0.3)])] if taken >= 0.0 else []
        people = tracker.update(scans, time, legs=LegScan(time, np.zeros((0, 2)), np.zeros((0, 2, 2)), vacant=(77,)))
    (walker,) = people
    assert walker.posture is Posture.WALKING
    assert walker.position_in_world[0] == pytest.approx(6.0 + 0.8 * time, abs=0.1)


def test_somebody_whom_only_legs_show_is_not_off_the_floor_for_a_hairs_breadth() -> None:
    tracker = MultiCameraTracker(field_of_view=VIEW, floor=[FloorArea(x=(0.0, 20.0), y=(-2.0, 0.5))])
    for k in range(40):
        time = 0.1 * k
        seen = [at(EASTWARD, time, [(7.0, 0.45)])] if time < 1.0 else []
        legs = LegScan(time, np.array([[7.0, 0.5 + BUILDING_TOLERANCE + 0.02]]), 1e-4 * np.eye(2)[None])
        people = tracker.update(seen, time, legs=legs if time >= 1.0 else None)
    (person,) = people
    assert person.position_in_world[1] > 0.5 + BUILDING_TOLERANCE


def nobody(time: float) -> None:
    """No camera looks."""


def test_legs_alone_are_nobody() -> None:
    tracker = tracker_of()
    log = follow(tracker, lambda time: pair(7.0, 0.0), nobody, 5.0)
    assert not any(people for _, people in log)
    assert tracker.records == ()
    once = follow(tracker, lambda time: pair(7.0, 0.0), lambda time: [(7.0, 0.0)] if time < 0.15 else None, 3.0)
    assert not any(people for _, people in once)  # not confirmed by cameras


def gone_at(log: Log) -> float:
    return next((time for time, people in log if time > 2.0 and not people), math.inf)


def test_legs_keep_somebody_whom_no_camera_sees_any_more_for_a_while() -> None:
    def seen(time: float) -> Sequence[Place] | None:
        return [(7.0, 0.0)] if time <= 3.0 else None

    assert gone_at(follow(tracker_of(), nobody_near, seen, 8.0)) == pytest.approx(3.0 + OUTSIDE_LIFE, abs=0.15)
    log = follow(tracker_of(), lambda time: pair(7.0, 0.0), seen, 20.0)
    assert gone_at(log) == pytest.approx(3.0 + LEGS_ALONE + OUTSIDE_LIFE, abs=0.15)
    assert {person.id for _, people in log for person in people} == {0}
    late = np.array([p[0].position_in_world for t, p in log if 5.0 < t <= 3.0 + LEGS_ALONE])
    assert np.abs(late - [7.0, 0.0]).max() < 0.03


def test_legs_keep_somebody_whom_a_camera_misses_no_longer_than_that() -> None:
    def seen(time: float) -> Sequence[Place]:
        return [(7.0, 0.0)] if time <= 3.0 else []

    assert gone_at(follow(tracker_of(), nobody_near, seen, 8.0)) == pytest.approx(3.0 + 3.0, abs=0.2)
    log = follow(tracker_of(), lambda time: pair(7.0, 0.0), seen, 20.0)
    assert gone_at(log) == pytest.approx(3.0 + LEGS_ALONE + 3.0, abs=0.2)


def nobody_near(time: float) -> Sequence[Place]:
    """A post behind which nothing is hidden, so that the sweep has something to say that is of no use."""
    return [(6.0, -2.5)]


def test_with_legs_somebody_is_placed_more_than_twice_as_well() -> None:
    def error(legs: Legs, seed: int) -> float:
        log = follow(tracker_of(), legs, lambda time: [(7.0, 0.0)], 6.0, seed)
        return float(np.mean([np.sum((p[0].position_in_world - [7.0, 0.0]) ** 2) for t, p in log if t > 2.0]))

    bare, helped = (
        math.sqrt(np.mean([error(legs, seed) for seed in range(4)]))
        for legs in (nobody_near, lambda time: pair(7.0, 0.0))
    )
    assert bare > 0.03
    assert helped < 0.5 * bare


def test_a_vacant_place_near_the_robot_is_a_miss() -> None:
    def seen(time: float) -> Sequence[Place] | None:
        return [(6.8, 0.0)] if time <= 3.0 else None

    tracker = tracker_of()
    log = follow(tracker, lambda time: pair(6.8, 0.0) if time <= 3.0 else [(6.0, -2.5)], seen, 9.0)
    (record,) = tracker.records
    assert record.reason is not None and record.reason.startswith("in view without a hit for 3.")
    assert record.missed_by == ("laser",) and record.misses["laser"] > 20
    assert 5.9 < gone_at(log) < 6.5


def test_a_post_beside_somebody_does_not_steal_them() -> None:
    """They stand 0.35 m beside a post that the map does not know, and walk off; the post stays alone."""
    post = (7.0, 0.45)

    def place(time: float) -> Place:
        return (7.0, -0.5 * max(0.0, min(time - 4.0, 3.0)))

    def legs(time: float) -> Sequence[Place]:
        return (*pair(*place(time)), post)

    for seed in range(3):
        log = follow(tracker_of(), legs, lambda time: [place(time)] if time <= 3.0 else None, 8.0, seed)
        errors = [math.dist(p[0].position_in_world, place(t)) for t, p in log if t > 1.0]
        assert len(errors) == 70
        assert [p[0].posture for t, p in log if 5.9 < t < 6.8] == 8 * [Posture.WALKING]  # told by legs alone
        assert max(errors) < 0.25
        assert errors[-1] < 0.06


def test_somebody_seated_is_the_cameras_business() -> None:
    seat = Seat("couch", np.array([7.0, 0.3]), -0.5 * math.pi, 0.8, 1.9)
    tracker = tracker_of(seats=[seat])
    log = follow(tracker, lambda time: pair(7.0, 0.0), lambda time: [(7.0, 0.0)], 4.0)
    assert log[-1][1][0].posture is Posture.SEATED
    (record,) = tracker.records
    assert record.hits == {"east": 41}


# Walking: legs swing, and hide one another.


def walk(build: str, start: Array, yaw: float, speed: float, seed: int) -> tuple[Log, list[Array]]:
    """Somebody walks (or stands) near a robot at the origin; cameras see them for 2.5 s, then only the laser does."""
    rng, gait = np.random.default_rng(seed), Gait(build)
    scanner, tracker, still = scanner_before(build, rng), tracker_of(), Pose2D(0.0, 0.0, 0.0)
    posture = Posture.WALKING if speed else Posture.STANDING
    log, places, people = [], [], ()
    for tick in range(-40, 140):
        place = start + 0.05 * tick * speed * np.array([math.cos(yaw), math.sin(yaw)])
        body = gait.advance(Pose2D(float(place[0]), float(place[1]), yaw), speed, 0.05, posture)
        if tick < 0 or tick % 2:
            continue
        time = 0.05 * tick
        legs = FINDER.find(scanner.scan(time, still, [body]), PoseEstimate(time, still), people)
        seen = time <= 2.5
        people = tracker.update(
            [at(EASTWARD, time, [place + rng.normal(0.0, 0.1, 2)])] if seen else [], time, legs=legs
        )
        log.append((time, people))
        places.append(place)
    return log, places


@pytest.mark.parametrize("speed", [0.4, 0.8])
@pytest.mark.parametrize("build", ["slim", "broad"])
@pytest.mark.parametrize("way", ["across", "towards"])
def test_swinging_legs_that_hide_one_another_make_no_jumps(build: str, way: str, speed: float) -> None:
    start, yaw = {
        "across": (np.array([1.5, -3.5 * speed]), 0.5 * math.pi),
        "towards": (np.array([0.7 + 7.0 * speed * 0.9, 0.3]), math.pi),
    }[way]
    velocity = speed * np.array([math.cos(yaw), math.sin(yaw)])
    far = 0
    for seed in range(3):
        log, places = walk(build, start, yaw, speed, seed)
        for (time, people), place in zip(log, places, strict=True):
            if time < 3.0 or np.hypot(*place) > 3.7:
                far += time >= 3.0
                continue
            (person,) = people
            assert person.posture is Posture.WALKING
            assert np.hypot(*(person.velocity_in_world - velocity)) < 0.25
            assert math.dist(person.position_in_world, place) < 0.15
    assert far < 40


def test_somebody_who_stands_does_not_walk_by_their_legs() -> None:
    for seed, yaw in enumerate(np.linspace(0.0, math.pi, 6)):
        log, _ = walk("broad", np.array([2.0, 0.0]), float(yaw), 0.0, seed)
        assert {person.posture for time, people in log if time > 0.5 for person in people} == {Posture.STANDING}
        assert max(person.speed for time, people in log if time > 3.5 for person in people) < 0.1
