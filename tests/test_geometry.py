import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.geometry import (
    Intrinsics,
    Pose2D,
    SolidBox,
    Twist2D,
    arc_lengths,
    camera_on_robot,
    feet_on,
    floor_homography,
    largest_deviation,
    look_at,
    points_at,
    project,
    wrap_angle,
)

coordinate = st.floats(-20.0, 20.0)
angle = st.floats(-10.0, 10.0)


@given(angle)
def test_a_wrapped_angle_lies_in_its_range_and_points_the_same_way(value: float) -> None:
    wrapped = wrap_angle(value)
    assert -math.pi <= wrapped < math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(value), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(value), abs=1e-9)


def test_an_array_of_angles_is_wrapped_as_each_of_them_is() -> None:
    angles = np.array([[-4.0, 0.3], [math.pi, 9.0]])
    assert wrap_angle(angles).tolist() == [[wrap_angle(float(value)) for value in row] for row in angles]


@given(angle)
def test_the_largest_deviation_of_a_covariance_is_that_along_its_longer_axis(direction: float) -> None:
    c, s = math.cos(direction), math.sin(direction)
    turn = np.array([[c, -s], [s, c]])
    assert largest_deviation(turn @ np.diag([0.2**2, 0.5**2]) @ turn.T) == pytest.approx(0.5)


@given(coordinate, coordinate, angle, coordinate, coordinate)
def test_body_and_world_frames_are_inverse(x: float, y: float, yaw: float, px: float, py: float) -> None:
    pose = Pose2D(x, y, yaw)
    assert pose.to_world(pose.to_body(np.array([px, py]))) == pytest.approx([px, py], abs=1e-9)


def test_a_point_ahead_of_a_robot_that_faces_left_lies_to_the_left() -> None:
    assert Pose2D(1.0, 2.0, math.pi / 2).to_world(np.array([3.0, 0.0])) == pytest.approx([1.0, 5.0])


def test_a_forward_twist_of_a_robot_that_faces_left_moves_it_along_y() -> None:
    assert Twist2D(1.0, 0.0, 0.0).linear_in_world(math.pi / 2) == pytest.approx([0.0, 1.0], abs=1e-12)


def test_the_point_looked_at_is_in_the_middle_of_the_image() -> None:
    intrinsics = Intrinsics.from_vertical_field_of_view(640, 480, math.radians(45))
    pixel, depth = project(
        np.array([6.2, 0.0, 0.9]), intrinsics, look_at(np.array([0.2, 0, 2.6]), np.array([6.2, 0, 0.9]))
    )
    assert pixel == pytest.approx([320.0, 240.0])
    assert depth == pytest.approx(math.hypot(6.0, 1.7))


def test_a_point_to_the_left_of_the_view_is_left_in_the_image_and_a_higher_one_above() -> None:
    intrinsics = Intrinsics.from_vertical_field_of_view(640, 480, 1.0)
    camera = camera_on_robot(Pose2D(0.0, 0.0, 0.0), forward=0.25, height=1.2, pitch_down=0.0)
    left, _ = project(np.array([5.0, 1.0, 1.2]), intrinsics, camera)
    above, _ = project(np.array([5.0, 0.0, 2.0]), intrinsics, camera)
    assert left[0] < 320.0 and left[1] == pytest.approx(240.0)
    assert above[1] < 240.0 and above[0] == pytest.approx(320.0)


@given(st.floats(3.0, 10.0), st.floats(-1.5, 1.5))
def test_projecting_a_floor_point_and_back_gives_it_again(x: float, y: float) -> None:
    intrinsics = Intrinsics.from_vertical_field_of_view(640, 480, math.radians(45))
    camera = look_at(np.array([0.2, 0.0, 2.6]), np.array([6.2, 0.0, 0.9]))
    pixel, _ = project(np.array([x, y, 0.0]), intrinsics, camera)
    on_floor = floor_homography(intrinsics, camera) @ [*pixel, 1.0]
    assert on_floor[:2] / on_floor[2] == pytest.approx([x, y], abs=1e-6)


def test_the_homographys_scale_is_positive_below_the_horizon_and_negative_above() -> None:
    intrinsics = Intrinsics.from_vertical_field_of_view(640, 480, math.radians(45))
    camera = look_at(np.array([0.0, 0.0, 2.0]), np.array([5.0, 0.0, 2.0]))
    homography = floor_homography(intrinsics, camera)
    assert (homography @ [320.0, 300.0, 1.0])[2] > 0 > (homography @ [320.0, 200.0, 1.0])[2]


def test_a_turned_box_contains_what_lies_within_its_footprint() -> None:
    box = SolidBox("couch", "object", np.array([1.0, 1.0, 0.4]), np.array([0.8, 2.0, 0.8]), math.pi / 2)
    assert box.contains(np.array([[1.9, 1.0], [1.0, 1.9], [1.0, 1.3]])).tolist() == [True, False, True]
    assert box.contains(np.array([1.0, 1.5]), margin=0.2)


def test_a_wall_blocks_the_lines_that_pass_through_it_and_no_others() -> None:
    wall = SolidBox("wall", "wall", np.array([2.0, 0.0, 0.5]), np.array([0.1, 2.0, 1.0]), 0.0)
    origin = np.array([0.0, 0.0, 0.5])
    targets = np.array([[4.0, 0.0, 0.5], [1.5, 0.0, 0.5], [4.0, 3.0, 0.5], [4.0, 0.0, 3.0], [-4.0, 0.0, 0.5]])
    assert wall.blocks(origin, targets).tolist() == [True, False, False, False, False]


BENT = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]])


def test_places_along_a_polyline_are_counted_from_its_beginning_and_end_at_its_end() -> None:
    arcs = arc_lengths(BENT)
    assert arcs == pytest.approx([0.0, 3.0, 7.0])
    assert points_at(np.array([-1.0, 1.0, 5.0, 9.0]), BENT, arcs) == pytest.approx(
        np.array([[0.0, 0.0], [1.0, 0.0], [3.0, 2.0], [3.0, 4.0]])
    )
    assert points_at(4.0, BENT, arcs) == pytest.approx([3.0, 1.0])


def test_a_single_point_is_a_polyline_of_no_length() -> None:
    point = np.array([[2.0, 1.0]])
    assert arc_lengths(point) == pytest.approx([0.0])
    assert points_at(0.5, point, arc_lengths(point)) == pytest.approx([2.0, 1.0])


def test_the_foot_of_a_point_is_on_each_piece_at_most_at_its_ends() -> None:
    shares, feet = feet_on(BENT, np.array([1.0, 2.0]))
    assert shares == pytest.approx([1.0 / 3.0, 0.5])
    assert feet == pytest.approx(np.array([[1.0, 0.0], [3.0, 2.0]]))
    assert feet_on(BENT, np.array([9.0, -5.0]))[1] == pytest.approx(np.array([[3.0, 0.0], [3.0, 0.0]]))


def test_a_piece_without_length_has_its_own_place_for_a_foot() -> None:
    _, feet = feet_on(np.array([[1.0, 1.0], [1.0, 1.0]]), np.array([4.0, 5.0]))
    assert feet == pytest.approx(np.array([[1.0, 1.0]]))


def test_a_pose_given_in_anothers_frame_and_taken_back_is_the_same_and_moves_points_alike() -> None:
    robot, scanner = Pose2D(1.0, 2.0, 2.0), Pose2D(0.3, -0.1, 2.5)
    composed = robot.compose(scanner)
    assert composed.to_world(np.array([1.0, 0.5])) == pytest.approx(
        robot.to_world(scanner.to_world(np.array([1.0, 0.5])))
    )
    assert -math.pi <= composed.yaw < math.pi
    back = robot.relative(composed)
    assert (back.x, back.y, back.yaw) == pytest.approx((scanner.x, scanner.y, scanner.yaw))
