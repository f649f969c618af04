"""People whose feet a couch hides, or whose box ends at the hips, in the living room of the worlds."""

import math
from dataclasses import replace

import numpy as np
import pytest

from han_bullet.geometry import Array, Intrinsics, Pose2D, SolidBox, camera_on_robot, look_at, project
from han_bullet.messages import Detections, Frame, Scan, Seat
from han_bullet.tracking.field_of_view import FieldOfView
from han_bullet.tracking.hidden_feet import by_head, by_seat
from han_bullet.tracking.projection import FOOT_FRACTION, GroundProjection
from han_bullet.tracking.tracker import MultiCameraTracker

EMPTY = np.zeros((480, 640, 3), np.uint8)
INTRINSICS = Intrinsics.from_vertical_field_of_view(640, 480, math.radians(55.0))
OVER_TV = look_at(np.array([19.5, -3.35, 2.5]), np.array([19.5, 0.6, 0.7]))
CEILING = Frame("camera4", 0.0, EMPTY, INTRINSICS, OVER_TV, True)
ON_ROBOT = camera_on_robot(Pose2D(15.3, -0.9, 0.0), 0.25, 1.2, 0.05)
ONBOARD = Frame("onboard", 0.0, EMPTY, INTRINSICS, ON_ROBOT, False)
COUCH = SolidBox("couch", "object", np.array([19.5, -0.4, 0.4]), np.array([0.8, 1.9, 0.8]), -0.5 * math.pi)
SEAT = Seat("couch", np.array([19.5, -0.4]), -0.5 * math.pi, 0.8, 1.9, "tv")
FAR_AWAY = Pose2D(-50.0, 0.0, 0.0)
MAPPED = GroundProjection(robot_radius=0.3, obstacles=[COUCH], seats=[SEAT])
BARE = GroundProjection(robot_radius=0.3)


def box_of(frame: Frame, x: float, y: float, low: float, high: float = 1.75) -> list[float]:
    """Return the box [px] around somebody at (x, y) of whom the detector sees what is between two heights [m]."""
    bottom, top = project(np.array([[x, y, low], [x, y, high]]), frame.intrinsics, frame.camera_in_world)[0]
    tall = (bottom[1] - top[1]) / FOOT_FRACTION
    return [0.5 * (bottom[0] + top[0]) - 0.205 * tall, top[1], 0.41 * tall, tall]


def scan_of(frame: Frame, box: list[float], projection: GroundProjection, robot: Pose2D = FAR_AWAY) -> Scan:
    return projection.project(frame, Detections(np.array([box]), np.array([50.0]), np.ones(1)), robot)


def error(scan: Scan, x: float, y: float) -> float:
    """Return how far the only measurement is from a place [m]."""
    assert len(scan.positions) == 1
    return math.dist(scan.positions[0], (x, y))


@pytest.mark.parametrize("x", [18.6, 19.5, 20.4])
@pytest.mark.parametrize("low", [0.29, 0.4, 0.5])  # at the couch's upper edge, and above it
def test_who_stands_behind_the_couch_is_placed_by_the_head(x: float, low: float) -> None:
    box = box_of(CEILING, x, 1.0, low)
    assert error(scan_of(CEILING, box, BARE), x, 1.0) > 0.4
    assert error(scan_of(CEILING, box, MAPPED), x, 1.0) < 0.15


def test_a_box_that_ends_at_the_hips_is_placed_by_the_head_without_any_furniture() -> None:
    box = box_of(CEILING, 17.5, 1.0, 0.65)
    assert np.linalg.norm(BARE.foot_points(CEILING, np.array([box])).positions[0] - [17.5, 1.0]) > 1.2
    assert error(scan_of(CEILING, box, BARE), 17.5, 1.0) < 0.2


@pytest.mark.parametrize(("x", "y"), [(17.5, 1.0), (19.5, 2.2), (19.5, -1.1), (21.6, 0.3)])
def test_whoever_shows_their_feet_is_placed_by_them(x: float, y: float) -> None:
    box = box_of(CEILING, x, y, 0.0, 1.7)
    feet = MAPPED.foot_points(CEILING, np.array([box]))
    scan = scan_of(CEILING, box, MAPPED)
    assert np.array_equal(scan.positions, feet.positions) and np.array_equal(scan.covariances, feet.covariances)


def test_the_place_by_the_head_errs_as_much_as_heights_differ() -> None:
    rng = np.random.default_rng(2)
    place, behind, errors = np.array([19.0, 1.0]), np.array([[18.6, 5.0]]), []
    for height in rng.normal(1.75, 0.1, 400):
        boxes = np.array([box_of(CEILING, *place, 0.5, height)])
        reading = by_head(CEILING, boxes, behind)
        errors.append(reading.positions[0, 1] - place[1])
    claimed = math.sqrt(by_head(CEILING, boxes, behind).covariances[0, 1, 1])
    assert np.std(errors) == pytest.approx(claimed, rel=0.15)
    assert abs(np.mean(errors)) < 0.2 * claimed


@pytest.mark.parametrize(("distance", "height", "valid"), [(4.0, 1.75, True), (8.0, 1.75, False), (2.0, 1.5, False)])
def test_a_camera_hardly_lower_than_heads_places_the_near_ones_and_no_low_ones(
    distance: float, height: float, valid: bool
) -> None:
    """At 8 m a tenth of a metre of height is 1.5 m of floor; whoever is 1.5 m tall stands behind their own feet."""
    place = ON_ROBOT[:2, 3] + [distance, 0.0]
    boxes = np.array([box_of(ONBOARD, *place, 0.2, height)])
    feet = BARE.foot_points(ONBOARD, boxes).positions
    assert by_head(ONBOARD, boxes, feet).valid.tolist() == [valid]


@pytest.mark.parametrize("low", [0.1, 0.15, 0.2])
def test_who_sits_is_found_on_the_seat_whatever_of_them_the_couch_hides(low: float) -> None:
    """Seen from the side the feet seem to be at the far end of the couch, or beyond it."""
    box = box_of(ONBOARD, 19.5, -0.4, low, 1.25)
    foot = MAPPED.foot_points(ONBOARD, np.array([box])).positions[0]
    assert np.linalg.norm(foot - [19.5, -0.4]) > 0.3
    assert error(scan_of(ONBOARD, box, MAPPED), 19.5, -0.4) < 0.05


def test_who_stands_behind_a_seat_does_not_sit_on_it() -> None:
    def valid(boxes: Array) -> list[bool]:
        feet = MAPPED.foot_points(CEILING, boxes).positions
        return by_seat(CEILING, boxes, feet, SEAT).valid.tolist()

    assert valid(np.array([box_of(CEILING, 19.5, 1.0, 0.3)])) == [False]
    assert valid(np.array([box_of(CEILING, 19.5, -0.4, 0.5, 1.2)])) == [True]
    assert valid(np.array([box_of(CEILING, 17.5, -0.4, 0.5, 1.2)])) == [False]


@pytest.mark.parametrize("y", [0.5, 0.9, 1.3, 1.8])
def test_the_robot_behind_the_couch_is_not_taken_for_a_person(y: float) -> None:
    """What shows of it, up to the camera over its head, seems to be a dwarf far behind it."""
    drop = 1.7 / 3.35  # of the line of sight over the couch, per metre
    box = box_of(CEILING, 19.5, y, max(0.0, 2.5 - drop * (y + 3.35)), 1.3)
    assert len(scan_of(CEILING, box, MAPPED, Pose2D(19.5, y, 0.0)).positions) == 0


def known_scan(box: list[float], row: float) -> Scan:
    """Return the scan of a box of the ceiling camera, which knows that the changes end at a row [px]."""
    found = Detections(np.array([box]), np.ones(1), np.ones(1), feet=np.array([row]))
    return MAPPED.project(CEILING, found, FAR_AWAY)


def pixel_row(x: float, y: float, z: float) -> float:
    return float(project(np.array([[x, y, z]]), CEILING.intrinsics, CEILING.camera_in_world)[0][0, 1])


@pytest.mark.parametrize("height", [1.6, 1.65])
def test_feet_seen_right_beside_the_couch_tell_the_place_whatever_the_head_says(height: float) -> None:
    """By the head somebody short seems to stand behind the couch, which would hide their feet; the image shows them."""
    box = box_of(CEILING, 20.96, 1.0, 0.0, height)
    unknown = scan_of(CEILING, box, MAPPED)
    assert unknown.per_height is not None and unknown.per_height.any()
    assert error(unknown, 20.96, 1.0) > 0.4
    scan = known_scan(box, pixel_row(20.96, 0.85, 0.0))
    assert error(scan, 20.96, 1.0) < 0.05
    assert scan.per_height is not None and not scan.per_height.any()


def test_changes_that_end_at_the_couch_are_no_feet() -> None:
    upper_edge = pixel_row(19.5, 0.0, 0.8)
    scan = known_scan(box_of(CEILING, 19.5, 1.0, 0.5), upper_edge)
    assert error(scan, 19.5, 1.0) < 0.15
    assert scan.per_height is not None and scan.per_height.any()


def test_a_low_box_whose_changes_end_at_the_couch_is_no_person() -> None:
    """It holds the legs of nobody, and its upper edge is nobody's head."""
    upper_edge = pixel_row(19.5, 0.0, 0.8)
    box = box_of(CEILING, 19.5, 1.0, 0.4, 1.2)
    assert 0.9 < MAPPED.foot_points(CEILING, np.array([box]), np.array([upper_edge])).heights[0] < 1.3
    assert len(known_scan(box, upper_edge).positions) == 0


def test_a_place_by_the_head_says_how_far_the_persons_height_moves_it() -> None:
    scans = [scan_of(CEILING, box_of(CEILING, 19.0, 1.0, 0.4, height), MAPPED) for height in (1.73, 1.77)]
    moved = (scans[1].positions[0] - scans[0].positions[0]) / 0.04
    assert np.linalg.norm(moved) > 5.0
    assert scans[0].per_height is not None
    assert scans[0].per_height[0] == pytest.approx(moved, rel=0.15, abs=0.2)


@pytest.mark.parametrize("height", [1.68, 1.82])
def test_who_walks_behind_the_couch_is_followed_whatever_their_height(height: float) -> None:
    """Their feet are seen until the couch hides them; from there on the head alone would put them 0.4 m off."""
    tracker = MultiCameraTracker(field_of_view=FieldOfView([COUCH]), seats=[SEAT])
    worst_head, errors = 0.0, []
    for tick in range(80):
        time, x = 0.1 * tick, 17.4 + 0.03 * tick
        frame = replace(CEILING, time=time)
        hidden = x > 18.3
        box = box_of(frame, x, 1.0, 0.4 if hidden else 0.0, height)
        row = math.nan if hidden else pixel_row(x, 0.85, 0.0)
        found = Detections(np.array([box]), np.ones(1), np.ones(1), feet=np.array([row]))
        scan = MAPPED.project(frame, found, FAR_AWAY)
        people = tracker.update([scan], time)
        if hidden:
            worst_head = max(worst_head, error(scan, x, 1.0))
            errors.append(math.dist(people[0].position_in_world, (x, 1.0)))
    assert len(errors) > 40 and worst_head > 0.35
    assert [person.id for person in people] == [0]
    assert max(errors) < 0.3 and math.sqrt(np.mean(np.square(errors))) < 0.22
