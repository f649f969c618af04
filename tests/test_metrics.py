import math
from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ticks import CAMERA, found, frame, make_world, person, scan, tick, track

from han_bullet.episode import Tick
from han_bullet.messages import Contact, RecoveryStep, Status
from han_bullet.metrics import DEFINITIONS, Metrics, Value
from han_bullet.metrics.intrusion import personal_space
from han_bullet.metrics.perceived import match
from han_bullet.world_file import load_world


def measure(ticks: Iterable[Tick], *people: str, **world: object) -> dict[str, Value]:
    metrics = Metrics(make_world(*people, **world))
    for one in ticks:
        metrics.record(one)
    return {metric.name: metric.value for metric in metrics.results()}


# How the robot moved


def test_a_run_that_arrives_has_the_time_from_its_first_tick_to_the_first_arrival():
    ticks = [tick(i, status=Status.ARRIVED if i >= 30 else Status.MOVING) for i in range(10, 32)]
    values = measure(ticks)
    assert values["outcome"] == "arrived"
    assert values["time_to_goal"] == pytest.approx(1.0)  # ticks 10 to 30, 0.05 s each


@pytest.mark.parametrize(
    ("last", "outcome"), [(Status.BLOCKED, "blocked"), (Status.WAITING, "timeout"), (Status.MOVING, "timeout")]
)
def test_a_run_that_does_not_arrive_has_no_time_to_goal(last: Status, outcome: str):
    values = measure([tick(0), tick(1, status=last)])
    assert (values["outcome"], values["time_to_goal"]) == (outcome, None)


def test_a_robot_that_gave_up_since_it_was_lost_ends_as_lost_and_one_that_still_looks_as_timeout():
    lost = tick(1, status=Status.LOST, step=RecoveryStep.RELOCALIZE)
    assert measure([tick(0), lost])["outcome"] == "timeout"
    assert measure([lost, tick(2, status=Status.LOST, gave_up="lost for 11 s")])["outcome"] == "lost"


def test_path_length_and_turning_add_up_between_ticks():
    robots = [(0.0, 0.0, 3.0), (3.0, 4.0, -3.0), (3.0, 5.0, -3.1)]
    values = measure(tick(i, robot=robot) for i, robot in enumerate(robots))
    assert values["path_length"] == pytest.approx(5.0 + 1.0)
    assert values["cumulative_heading_change"] == pytest.approx((2.0 * math.pi - 6.0) + 0.1)


def test_speeds_and_accelerations_are_those_of_the_velocity_in_the_world():
    # In the body always (0.4, 0.0); turned by a right angle the velocity in the world changes by 0.4 sqrt(2).
    ticks = [tick(0, twist=(0.4, 0.0, 0.0)), tick(1, robot=(0.0, 0.0, math.pi / 2), twist=(0.4, 0.0, 0.0))]
    values = measure([*ticks, tick(2, robot=(0.0, 0.0, math.pi / 2), twist=(0.7, 0.0, 0.0))])
    assert values["mean_speed"] == pytest.approx(0.5)
    assert values["max_speed"] == pytest.approx(0.7)
    assert values["max_acceleration"] == pytest.approx(0.4 * math.sqrt(2.0) / 0.05)


def test_stalled_time_counts_standing_after_the_first_motion_and_before_arrival():
    speeds = [0.0, 0.04, 0.05, 0.04, 0.0, 0.3, 0.049, 0.0, 0.0]
    arrived = [False] * 7 + [True] * 2
    ticks = [
        tick(i, twist=(speed, 0.0, 0.0), status=Status.ARRIVED if there else Status.MOVING)
        for i, (speed, there) in enumerate(zip(speeds, arrived, strict=True))
    ]
    assert measure(ticks)["stalled_time"] == pytest.approx(3 * 0.05)


def test_a_robot_that_never_moves_has_not_stalled():
    assert measure(tick(i) for i in range(5))["stalled_time"] == 0.0


# What it touched


def test_a_touch_of_the_same_body_counts_again_only_after_half_a_second():
    touches = {0, 1, 2, 11, 21, 40}  # gaps of 0.45 s (the same contact), 0.50 s and 0.95 s (new ones)
    contact = Contact("walker", "person", -0.001)
    scene = {"twist": (0.1, 0.0, 0.0), "people": [person(x=0.55)]}  # the robot drives towards the walker
    values = measure((tick(i, contacts=[contact] if i in touches else [], **scene) for i in range(50)), "walker")
    assert values["contacts_person"] == 3
    assert values["contacts_by_person"] == 0
    assert (values["contacts_wall"], values["contacts_object"]) == (0, 0)


def test_contacts_are_counted_by_kind_and_body():
    both = [Contact("anna", "person", -0.01), Contact("bob", "person", 0.0)]
    others = [Contact("wall3", "wall", -0.01), Contact("couch", "object", -0.01)]
    scene = {"twist": (0.3, 0.0, 0.0), "people": [person("anna", 0.5, 0.1), person("bob", 0.5, -0.1)]}
    values = measure([tick(0, contacts=both, **scene), tick(1, contacts=[*both, *others], **scene)], "anna", "bob")
    assert (values["contacts_person"], values["contacts_wall"], values["contacts_object"]) == (2, 1, 1)


# How it met people


def test_minimum_distance_is_between_centres_and_minimum_gap_between_surfaces():
    ticks = [tick(i, robot=(x, 0.0, 0.0), people=[person(x=2.0, y=0.9)]) for i, x in enumerate((0.0, 1.9, 2.1, 4.0))]
    values = measure(ticks, "walker")
    assert values["minimum_distance.walker"] == pytest.approx(math.hypot(0.1, 0.9))
    assert values["minimum_gap.walker"] == pytest.approx(math.hypot(0.1, 0.9) - 0.3 - 0.25)


def test_minimum_gap_is_negative_where_the_discs_overlap():
    values = measure([tick(0, robot=(0.2, 0.0, 0.0), people=[person()])], "walker")
    assert values["minimum_gap.walker"] == pytest.approx(-0.35)


@pytest.mark.parametrize(("lateral", "side"), [(0.8, "left"), (-0.8, "right")])
@pytest.mark.parametrize("yaw", [0.0, 2.0, -3.0])
def test_the_side_of_overtaking_is_told_in_the_walkers_frame(lateral: float, side: str, yaw: float):
    walker = person(x=5.0, y=1.0, yaw=yaw, speed=0.35)
    places = walker.pose_in_world.to_world(np.array([[-1.0, 0.0], [-0.02, lateral], [0.05, lateral], [1.0, 0.0]]))
    values = measure([tick(i, robot=(*place, yaw), people=[walker]) for i, place in enumerate(places)], "walker")
    assert values["overtaking_side.walker"] == side
    assert values["distance_when_level.walker"] == pytest.approx(math.hypot(0.05, 0.8))


@pytest.mark.parametrize(
    ("speed", "forward", "lateral"),
    [
        (0.04, (-0.1, 0.1), 0.8),  # the person stands
        (0.35, (0.1, -0.1), 0.8),  # the person overtakes the robot
        (0.35, (0.1, 0.2), 0.8),  # the robot was ahead from the start
        (0.35, (-0.1, 0.1), 2.6),  # too far aside
    ],
)
def test_nothing_else_is_overtaking(speed: float, forward: tuple[float, float], lateral: float):
    walker = person(speed=speed, posture="walking")
    values = measure([tick(i, robot=(x, lateral, 0.0), people=[walker]) for i, x in enumerate(forward)], "walker")
    assert values["overtaking_side.walker"] == "none"
    assert values["distance_when_level.walker"] is None


def test_of_two_overtakings_the_last_one_counts():
    places = [(-0.1, -1.0), (0.1, -1.0), (-0.1, 0.0), (-0.1, 0.9), (0.0, 0.9)]
    ticks = [tick(i, robot=(*place, 0.0), people=[person(speed=0.3)]) for i, place in enumerate(places)]
    values = measure(ticks, "walker")
    assert values["overtaking_side.walker"] == "left"
    assert values["distance_when_level.walker"] == pytest.approx(0.9)


def test_personal_space_of_a_standing_person_is_a_circle_of_deviation_0_56_m():
    someone = person(x=1.0, yaw=0.7)
    at_one_deviation = someone.pose_in_world.to_world(np.array([[0.56, 0.0], [-0.56, 0.0], [0.0, 0.56]]))
    assert [personal_space(someone, point) for point in at_one_deviation] == pytest.approx([math.exp(-0.5)] * 3)
    assert personal_space(someone, np.array([1.0, 1.2])) == pytest.approx(0.1, abs=0.001)


@pytest.mark.parametrize(("speed", "b"), [(0.35, 0.8), (1.2, 1.2)])
def test_personal_space_of_a_walking_person_reaches_farther_ahead(speed: float, b: float):
    walker = person(y=-2.0, yaw=-1.0, speed=speed)
    places = np.array([[b, 0.0], [-b / 2.0, 0.0], [0.0, 2.0 * b / 3.0], [0.0, -2.0 * b / 3.0]])
    costs = [personal_space(walker, point) for point in walker.pose_in_world.to_world(places)]
    assert costs == pytest.approx([math.exp(-0.5)] * 4)


def test_personal_space_share_counts_ticks_above_one_half():
    border = 0.56 * math.sqrt(2.0 * math.log(2.0))  # where g2 is 0.5
    robots = [2.0, border + 0.01, border - 0.01, 0.2]
    values = measure((tick(i, robot=(x, 0.0, 0.0), people=[person()]) for i, x in enumerate(robots)), "walker")
    assert values["personal_space_share"] == 0.5


# What it believed of people


@given(
    st.lists(st.tuples(st.floats(-2, 2), st.floats(-2, 2)), max_size=4),
    st.lists(st.tuples(st.floats(-2, 2), st.floats(-2, 2)), max_size=4),
)
def test_matching_pairs_each_track_and_person_once_and_only_within_one_metre(tracks: list, people: list):
    a, b = np.array(tracks).reshape(-1, 2), np.array(people).reshape(-1, 2)
    pairs = match(a, b)
    assert len({i for i, _ in pairs}) == len({j for _, j in pairs}) == len(pairs)
    assert all(np.hypot(*(a[i] - b[j])) <= 1.0 for i, j in pairs)
    left_a, left_b = set(range(len(a))) - {i for i, _ in pairs}, set(range(len(b))) - {j for _, j in pairs}
    assert all(np.hypot(*(a[i] - b[j])) > 1.0 for i in left_a for j in left_b)


def test_matching_prefers_two_long_pairs_to_one_short_one():
    # Track 0 is nearest to person 0, but then track 1 would be left with nobody within 1 m.
    tracks, people = np.array([[0.0, 0.0], [-0.9, 0.0]]), np.array([[0.05, 0.0], [0.95, 0.0]])
    assert match(tracks, people) == [(0, 1), (1, 0)]


def test_position_error_counts_matched_tracks_older_than_one_second():
    someone = person(x=2.0)
    young = [tick(i, people=[someone], tracks=[track(0, 2.0, 0.9)]) for i in range(21)]  # up to 1.0 s of age
    steady = [tick(i, people=[someone], tracks=[track(0, 2.0, y)]) for i, y in ((21, 0.3), (22, 0.4))]
    far = [tick(23, people=[someone], tracks=[track(0, 2.0, 1.1)])]
    assert measure(young, "walker")["person_position_rmse"] is None
    values = measure([*young, *steady, *far], "walker")
    assert values["person_position_rmse"] == pytest.approx(math.sqrt((0.09 + 0.16) / 2.0))


def test_heading_error_counts_known_headings_of_people_who_walk():
    walker = person(yaw=3.1, speed=0.4)
    headings = (-3.1, 3.0, None)
    ticks = [tick(i, people=[walker], tracks=[track(heading=h)]) for i, h in enumerate(headings)]
    ticks.append(tick(3, people=[person()], tracks=[track(heading=2.0)]))  # stands: does not count
    wrapped = 2.0 * math.pi - 6.2
    values = measure(ticks, "walker")
    assert values["heading_error_rmse"] == pytest.approx(math.sqrt((wrapped**2 + 0.1**2) / 2.0))


def test_tracked_share_starts_with_the_first_frame_that_shows_the_whole_person():
    # The camera hangs at x = 0 and looks along x: 1 m before it a person is cut off, 5 m before it whole.
    places = [1.0] * 4 + [5.0] * 5
    ticks = []
    for i, x in enumerate(places):
        tracks = [track(3, x)] if i >= 7 else []
        ticks.append(tick(i, people=[person(x=x)], tracks=tracks, frames=[frame(time=i * 0.05)]))
    values = measure(ticks, "walker")
    assert values["tracked_share.walker"] == pytest.approx(2 / 5)  # ticks 4 to 8, matched in 7 and 8
    assert values["time_to_first_track.walker"] == pytest.approx(3 * 0.05)


def test_a_wall_before_the_camera_delays_the_first_possible_frame():
    wall = {"walls": [{"start": [2.5, -2.0], "end": [2.5, 2.0]}]}
    ticks = [tick(i, people=[person(x=5.0)], frames=[frame(time=i * 0.05)]) for i in range(4)]
    assert measure(ticks, "walker")["tracked_share.walker"] == 0.0
    assert measure(ticks, "walker", **wall)["tracked_share.walker"] is None


def test_without_frames_a_person_is_possible_from_their_first_track_on():
    ticks = [tick(i, people=[person()], tracks=[track()] if i in (2, 4, 5) else []) for i in range(6)]
    values = measure(ticks, "walker")
    assert values["tracked_share.walker"] == pytest.approx(3 / 4)
    assert values["time_to_first_track.walker"] == 0.0


def test_noticing_that_a_person_walks_is_timed_from_their_first_step():
    postures = ["standing"] * 8 + ["walking"] * 2
    ticks = [
        tick(i, people=[person(speed=0.4 if i >= 3 else 0.0)], tracks=[track(posture=posture)])
        for i, posture in enumerate(postures)
    ]
    assert measure(ticks, "walker")["time_to_notice_walking.walker"] == pytest.approx(5 * 0.05)
    assert measure(ticks[:8], "walker")["time_to_notice_walking.walker"] is None


def test_id_switches_count_each_change_of_a_persons_id():
    people = [person("anna"), person("bob", x=5.0)]
    ids = [(0, 1), (0, 1), (2, 1), (None, 1), (2, 1), (0, 3)]  # anna: 0 -> 2 -> 0; bob: 1 -> 3
    ticks = []
    for i, (a, b) in enumerate(ids):
        tracks = [track(key, x) for key, x in ((a, 0.1), (b, 5.1)) if key is not None]
        ticks.append(tick(i, people=people, tracks=tracks))
    assert measure(ticks, "anna", "bob")["id_switches"] == 3


def test_phantoms_are_tracks_with_nobody_within_one_metre():
    someone = person()
    far, near = track(7, 1.2), track(7, 0.9)
    sequence = [far, far, far, near, far, far, None, far]
    ticks = [tick(i, people=[someone], tracks=[one] if one else []) for i, one in enumerate(sequence)]
    ticks.append(tick(8, people=[someone], tracks=[track(9, -4.0)]))
    values = measure(ticks, "walker")
    assert values["phantom_tracks"] == 2
    assert values["phantom_time_total"] == pytest.approx(7 * 0.05)
    assert values["phantom_time_longest"] == pytest.approx(3 * 0.05)
    assert values["duplicate_time_total"] == 0.0


def test_a_second_track_of_the_same_person_is_a_duplicate_and_no_phantom():
    tracks = [track(0, 0.1), track(1, 0.6)]
    values = measure([tick(i, people=[person()], tracks=tracks) for i in range(4)], "walker")
    assert values["duplicate_time_total"] == pytest.approx(4 * 0.05)
    assert (values["phantom_tracks"], values["phantom_time_longest"]) == (0, 0.0)


def test_with_nobody_there_every_track_is_a_phantom():
    values = measure([tick(i, tracks=[track(4)]) for i in range(3)])
    assert values["phantom_time_total"] == pytest.approx(3 * 0.05)


def test_detections_are_counted_per_frame_and_false_ones_by_their_foot_points():
    image = frame()
    full = tick(
        0,
        people=[person(x=5.0)],
        frames=[image],
        detections=[found(image, (0, 0, 41, 100), (9, 9, 41, 100), (50, 9, 41, 100))],
        scans=[scan([(5.0, 0.9), (5.0, 1.1), (9.0, 0.0)], image)],
    )
    empty = tick(1, people=[person(x=5.0)], frames=[image], detections=[found(image)], scans=[scan([], image)])
    values = measure([full, empty, tick(2, people=[person(x=5.0)])], "walker")
    assert values["detections_per_frame"] == pytest.approx(1.5)
    assert values["false_detections_per_frame"] == pytest.approx(1.0)


# As a whole


def test_every_metric_has_its_name_before_the_first_tick_and_none_is_left_undefined():
    before = Metrics(make_world("anna", "bob")).results()
    after = measure([tick(0, people=[person("anna"), person("bob", x=5.0)])], "anna", "bob")
    assert [metric.name for metric in before] == list(after)
    with_everything = Metrics(load_world("sim2")).results()
    assert {metric.name.split(".")[0] for metric in with_everything} == set(DEFINITIONS)
    assert all(metric.definition for metric in with_everything)


def test_a_value_that_is_no_finite_number_is_none():
    assert measure([tick(0)], "walker")["minimum_distance.walker"] is None


def test_the_camera_of_these_tests_sees_five_metres_ahead_and_not_one():
    values = measure([tick(0, people=[person(x=1.0)], frames=[frame(CAMERA)])], "walker")
    assert values["tracked_share.walker"] is None
