"""People whose feet a couch hides, or whose box ends at the hips, in the living room of the worlds."""

import math

import numpy as np
import pytest

from han_bullet.geometry import Array, Intrinsics, Pose2D, SolidBox, camera_on_robot, look_at, project
from han_bullet.messages import Detections, Frame, Scan, Seat
from han_bullet.tracking.hidden_feet import by_head, by_seat
from han_bullet.tracking.projection import FOOT_FRACTION, GroundProjection

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
