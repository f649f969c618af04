"""From boxes to the floor: places, covariances, and what is dropped."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.errors import BadInputError
from han_bullet.geometry import Intrinsics, Pose2D, SolidBox, look_at, project
from han_bullet.messages import Detections, Frame, Scan, Seat
from han_bullet.tracking.projection import (
    BODY_DEVIATION,
    FOOT_FRACTION,
    OFFSET_ALONG_RAY,
    OFFSET_OF_KNOWN_FEET,
    GroundProjection,
)
from han_bullet.world_schema import FloorArea

INTRINSICS = Intrinsics.from_vertical_field_of_view(640, 480, math.radians(45.0))
CEILING = look_at(np.array([0.2, 0.0, 2.6]), np.array([6.2, 0.0, 0.9]))
FAR_AWAY = Pose2D(-50.0, 0.0, 0.0)
FRAME = Frame("camera1", 1.5, np.zeros((480, 640, 3), np.uint8), INTRINSICS, CEILING, True)


def box_of(x: float, y: float, height: float = 1.75) -> list[float]:
    """Return the box [px] that the detector gives a person of a height [m] who stands at (x, y) [m]."""
    ray = np.array([x, y]) - CEILING[:2, 3]
    toe = np.array([x, y]) - OFFSET_ALONG_RAY * ray / np.linalg.norm(ray)
    foot, head = project(np.array([[*toe, 0.0], [*toe, height]]), INTRINSICS, CEILING)[0]
    tall = (foot[1] - head[1]) / FOOT_FRACTION
    middle = 0.5 * (foot[0] + head[0])  # uprights lean outward in a picture that is taken looking down
    return [middle - 0.205 * tall, head[1], 0.41 * tall, tall]


def scan_of(boxes: list[list[float]], projection: GroundProjection | None = None, robot: Pose2D = FAR_AWAY) -> Scan:
    array = np.array(boxes, float).reshape(-1, 4)
    found = Detections(array, np.full(len(array), 50.0), np.ones(len(array)))
    return (projection or GroundProjection(robot_radius=0.3)).project(FRAME, found, robot)


@given(st.floats(3.8, 9.4), st.floats(-1.0, 1.0))
def test_a_person_is_found_where_they_stand(x: float, y: float) -> None:
    scan = scan_of([box_of(x, y)])
    assert scan.positions == pytest.approx(np.array([[x, y]]), abs=1e-9)
    assert (scan.camera, scan.time, scan.frame, scan.pose_robot_in_world) == ("camera1", 1.5, FRAME, FAR_AWAY)


@pytest.mark.parametrize(("height", "kept"), [(101.0, 0), (107.0, 1)])
def test_the_detectors_smallest_box_tells_no_distance(height: float, kept: int) -> None:
    x, y, width, tall = box_of(8.8, 0.0)
    assert 110.0 < tall < 120.0
    scan = scan_of([[x, y + tall - height, width, height]])
    assert len(scan.positions) == kept


@pytest.mark.parametrize("height", [96.0, 101.0])
def test_the_smallest_box_is_measured_where_the_row_of_the_feet_is_known(height: float) -> None:
    x, y, width, tall = box_of(11.2, 0.5)
    assert tall < 96.0
    foot = y + FOOT_FRACTION * tall
    box = np.array([[x, y + 0.5 * (tall - height), width, height]])
    found = Detections(box, np.ones(1), np.ones(1), feet=np.array([foot]))
    scan = GroundProjection(robot_radius=0.3).project(FRAME, found, FAR_AWAY)
    further = OFFSET_OF_KNOWN_FEET - OFFSET_ALONG_RAY
    assert scan.positions == pytest.approx(np.array([[11.2 + further, 0.5]]), abs=0.05)
    assert math.sqrt(scan.covariances[0, 0, 0]) < 0.2


@pytest.mark.parametrize(("distance", "along"), [(3.7, 0.16), (5.0, 0.20), (7.3, 0.28)])
def test_the_uncertainty_is_larger_along_the_ray_and_grows_with_the_distance(distance: float, along: float) -> None:
    covariance = scan_of([box_of(0.2 + distance, 0.0)]).covariances[0]
    assert math.sqrt(covariance[0, 0]) == pytest.approx(along, abs=0.02)
    # Across: 0.04 m of the image and the 0.1 m that every measurement has.
    assert math.sqrt(covariance[1, 1]) == pytest.approx(0.11, abs=0.005)
    assert covariance[0, 1] == pytest.approx(0.0, abs=1e-6)


def test_where_the_row_of_the_feet_is_known_a_box_that_is_too_long_puts_nobody_nearer() -> None:
    toe = 0.2 + 5.0
    foot, head = project(np.array([[toe, 0.0, 0.0], [toe, 0.0, 1.75]]), INTRINSICS, CEILING)[0]
    height = foot[1] - head[1]
    boxes = np.array([[foot[0] - 30.0, head[1], 60.0, scale * height] for scale in (0.95, 1.0, 1.05)])
    known = GroundProjection(robot_radius=0.3).foot_points(FRAME, boxes, np.full(3, foot[1]))
    assert known.positions == pytest.approx(np.tile([toe + OFFSET_OF_KNOWN_FEET, 0.0], (3, 1)), abs=1e-9)
    unknown = GroundProjection(robot_radius=0.3).foot_points(FRAME, boxes, np.full(3, np.nan))
    assert unknown.positions[0, 0] - unknown.positions[2, 0] > 0.3
    assert unknown.positions == pytest.approx(GroundProjection(robot_radius=0.3).foot_points(FRAME, boxes).positions)


@pytest.mark.parametrize(("top", "kept"), [(0.85, 0), (0.95, 1), (1.25, 1), (1.4, 1)])
def test_a_box_that_holds_the_legs_alone_is_measured_where_the_feet_are_known(top: float, kept: int) -> None:
    box = np.array([box_of(6.0, 0.4, top)])
    foot = box[0, 1] + FOOT_FRACTION * box[0, 3]
    found = Detections(box, np.ones(1), np.ones(1), feet=np.array([foot]))
    scan = GroundProjection(robot_radius=0.3).project(FRAME, found, FAR_AWAY)
    assert len(scan.positions) == kept
    expected = [6.0 + OFFSET_OF_KNOWN_FEET - OFFSET_ALONG_RAY, 0.4]
    assert scan.positions == pytest.approx(np.array([expected] * kept).reshape(-1, 2), abs=0.05)


def test_a_known_row_makes_the_place_surer_along_the_ray_and_not_beside_it() -> None:
    box = np.array([box_of(6.0, 0.0)])
    projection = GroundProjection(robot_radius=0.3)
    by_box = projection.foot_points(FRAME, box).covariances[0]
    by_row = projection.foot_points(FRAME, box, np.array([box[0, 1] + FOOT_FRACTION * box[0, 3]])).covariances[0]
    assert math.sqrt(by_box[0, 0]) > 0.2
    assert math.sqrt(by_row[0, 0]) == pytest.approx(math.hypot(BODY_DEVIATION, 0.04), abs=0.01)
    assert by_row[1, 1] == pytest.approx(by_box[1, 1], rel=0.01)


def test_the_rows_of_the_detections_reach_the_scan() -> None:
    box = np.array([box_of(6.0, 0.0)])
    row = box[0, 1] + 0.95 * box[0, 3]
    found = Detections(box, np.ones(1), np.ones(1), feet=np.array([row]))
    scan = GroundProjection(robot_radius=0.3).project(FRAME, found, FAR_AWAY)
    expected = GroundProjection(robot_radius=0.3).foot_points(FRAME, box, np.array([row]))
    assert scan.positions == pytest.approx(expected.positions)
    assert scan.positions[0, 0] > 6.2


def test_seats_seen_empty_reach_the_scan() -> None:
    found = replace(Detections.none(), empty_seats=("couch",))
    assert GroundProjection(robot_radius=0.3).project(FRAME, found, FAR_AWAY).empty_seats == ("couch",)


def test_the_covariance_is_that_of_boxes_scattered_in_the_image() -> None:
    rng = np.random.default_rng(3)
    x, y, width, height = box_of(6.0, 0.8)
    scatter = rng.normal(0.0, [0.025 * height, 0.05 * height], (4000, 2))
    boxes = np.column_stack([x + scatter[:, 0], y + scatter[:, 1], np.full(4000, width), np.full(4000, height)])
    projection = GroundProjection(robot_radius=0.3)
    sample = np.cov(projection.foot_points(FRAME, boxes).positions.T)
    claimed = projection.foot_points(FRAME, np.array([[x, y, width, height]])).covariances[0]
    # Linearized against true, with 4000 samples: a tenth of the largest variance.
    assert claimed - BODY_DEVIATION**2 * np.eye(2) == pytest.approx(sample, abs=0.1 * sample.max())


@pytest.mark.parametrize(("room", "kept"), [(0.01, 0), (0.04, 0), (0.06, 1)])
def test_a_box_at_the_lower_border_is_no_measurement_for_the_feet_may_be_below(room: float, kept: int) -> None:
    x, y, width, height = box_of(5.0, 0.0)
    down = 480.0 - room * height - (y + height)
    assert down > 0.0
    lowered = [x, y + down, width, height]
    assert len(scan_of([lowered]).positions) == kept
    known = Detections(np.array([lowered]), np.ones(1), np.ones(1), feet=np.array([480.0 - (room + 0.01) * height]))
    assert len(GroundProjection(robot_radius=0.3).project(FRAME, known, FAR_AWAY).positions) == 1


def test_a_foot_point_above_the_horizon_is_no_measurement() -> None:
    horizon = INTRINSICS.cy - INTRINSICS.fy * math.tan(math.atan2(1.7, 6.0))
    assert horizon > 60.0
    points = GroundProjection(robot_radius=0.3).foot_points(FRAME, np.array([[300.0, -60.0, 41.0, horizon + 50.0]]))
    assert points.measurable.tolist() == [False]
    assert len(scan_of([[300.0, -60.0, 41.0, horizon + 50.0]]).positions) == 0


@pytest.mark.parametrize(("gap", "kept"), [(0.40, 0), (0.50, 1)])
def test_the_robot_is_not_taken_for_a_person(gap: float, kept: int) -> None:
    scan = scan_of([box_of(6.0, 0.0)], robot=Pose2D(6.0, gap, 0.3))
    assert len(scan.positions) == kept


@pytest.mark.parametrize(("height", "kept"), [(1.1, 0), (1.4, 1), (1.75, 1), (2.1, 1), (2.4, 0)])
def test_dwarfs_and_giants_are_no_people(height: float, kept: int) -> None:
    scan = scan_of([box_of(6.0, 0.0, height)])
    assert len(scan.positions) == kept


def test_the_height_of_a_person_is_read_from_the_calibrated_camera() -> None:
    boxes = np.array([box_of(6.0, 0.7, 1.62), box_of(8.0, -0.7, 1.88)])
    heights = GroundProjection(robot_radius=0.3).foot_points(FRAME, boxes).heights
    assert heights == pytest.approx([1.62, 1.88], abs=1e-6)


def test_somebody_low_is_a_person_where_people_sit() -> None:
    seat = Seat("couch", np.array([6.0, 0.0]), math.pi, 0.8, 1.9)
    low = [box_of(5.5, 0.0, 1.1), box_of(7.5, 0.0, 1.1)]
    couch = SolidBox("couch", "object", np.array([6.0, 0.0, 0.4]), np.array([0.8, 1.9, 0.8]), math.pi)
    scan = scan_of(low, GroundProjection(robot_radius=0.3, seats=[seat], obstacles=[couch]))
    assert scan.sources.tolist() == [0]


def test_places_off_the_floor_inside_furniture_or_behind_a_wall_are_dropped() -> None:
    floor = [FloorArea(x=(0.0, 8.0), y=(-1.5, 1.5), texture="tiles")]
    cupboard = SolidBox("cupboard", "object", np.array([5.0, 1.0, 1.0]), np.array([1.0, 1.0, 2.0]), 0.0)
    wall = SolidBox("wall0", "wall", np.array([6.5, -1.0, 1.4]), np.array([0.1, 1.0, 2.8]), 0.0)
    projection = GroundProjection(robot_radius=0.3, floor=floor, obstacles=[cupboard, wall])
    places = [
        (5.0, -1.0),  # free
        (8.2, 0.5),  # just off the floor: an error along the ray
        (8.6, 0.5),  # off the floor
        (5.0, 1.0),  # in the middle of the cupboard
        (5.0, 0.55),  # at its edge: an error across the ray
        (6.7, -1.0),  # 0.2 m behind the wall: an error along the ray
        (7.3, -1.0),  # behind the wall
    ]
    assert len(scan_of([box_of(*place) for place in places]).positions) == len(places)
    assert scan_of([box_of(*place) for place in places], projection).sources.tolist() == [0, 1, 4, 5]


def test_no_boxes_give_an_empty_scan_of_the_right_shapes() -> None:
    scan = scan_of([])
    assert (scan.positions.shape, scan.covariances.shape, scan.sources.shape) == ((0, 2), (0, 2, 2), (0,))
    assert scan.sources.dtype == np.int64


@pytest.mark.parametrize("radius", [0.0, -0.3, math.nan])
def test_a_robot_without_a_radius_is_refused(radius: float) -> None:
    with pytest.raises(BadInputError, match=f"robot_radius is {radius};"):
        GroundProjection(robot_radius=radius)
