"""What ends where the robot does is not a person's feet: told by where the robot shows in the image."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from han_bullet.geometry import Intrinsics, Pose2D, look_at, project
from han_bullet.messages import Detections, Frame, Scan, Seat
from han_bullet.tracking.own_image import rows_not_of_robot
from han_bullet.tracking.projection import GroundProjection

INTRINSICS = Intrinsics.from_vertical_field_of_view(640, 480, math.radians(45.0))
CAMERA = look_at(np.array([0.0, 0.0, 2.6]), np.array([6.0, 0.0, 0.9]))
FRAME = Frame("ceiling", 0.0, np.zeros((480, 640, 3), np.uint8), INTRINSICS, CAMERA, fixed=True)


def row_of(x: float, y: float) -> float:
    """Image row of a floor point."""
    return float(project(np.array([[x, y, 0.0]]), INTRINSICS, CAMERA)[0][0, 1])


def box_of(x: float, y: float) -> np.ndarray:
    """Box of somebody 1.75 m tall."""
    (foot, head), _ = project(np.array([[x, y, 0.0], [x, y, 1.75]]), INTRINSICS, CAMERA)
    height = foot[1] - head[1]
    return np.array([[0.5 * (foot[0] + head[0]) - 0.2 * height, head[1], 0.4 * height, height]])


def known(person: tuple[float, float], row: float, robot: tuple[float, float]) -> bool:
    """Whether a row that changes gave is still believed with the robot somewhere."""
    left = rows_not_of_robot(FRAME, box_of(*person), np.array([row]), Pose2D(*robot, 0.0), 0.3)
    assert left.shape == (1,) and (math.isnan(left[0]) or left[0] == row)
    return not math.isnan(left[0])


def test_a_row_at_the_robots_lower_end_beside_the_person_is_not_believed() -> None:
    assert not known((8.0, 0.5), row_of(6.7, 0.0), robot=(7.0, 0.0))
    assert known((8.0, 0.5), row_of(6.7, 0.0), robot=(7.0, -1.0))  # nothing of the robot is in the box's columns


def test_a_row_above_the_robots_upper_end_or_below_it_is_the_persons() -> None:
    far_before = (3.0, 0.0)  # the camera looks over the robot at the feet
    assert known((8.0, 0.2), row_of(8.0, 0.2), robot=far_before)
    beyond = (9.5, 0.2)  # and here over the feet at the robot
    assert known((6.5, 0.2), row_of(6.5, 0.2), robot=beyond)


def test_what_nobody_knows_stays_unknown_and_a_robot_that_does_not_show_changes_nothing() -> None:
    rows = np.array([math.nan])
    assert math.isnan(rows_not_of_robot(FRAME, box_of(6.0, 0.0), rows, Pose2D(6.0, 0.0, 0.0), 0.3)[0])
    assert known((6.0, 0.0), row_of(6.0, 0.0), robot=(-3.0, 0.0))


def test_the_projection_falls_back_to_the_box_beside_the_robot() -> None:
    projection = GroundProjection(robot_radius=0.3)
    box, robot = box_of(8.0, 0.5), Pose2D(7.0, 0.0, 0.0)
    rows = projection.known_rows(FRAME, box, np.array([row_of(6.7, 0.0)]), robot)
    placed = projection.foot_points(FRAME, box, rows).positions[0]
    assert placed == pytest.approx((8.0, 0.5), abs=0.25)
    wrong = projection.foot_points(FRAME, box, np.array([row_of(6.7, 0.0)])).positions[0]
    assert wrong[0] < 7.0


def placed(box: np.ndarray, robot: tuple[float, float], *, fixed: bool = True, seats: Sequence[Seat] = ()) -> Scan:
    """The scan of a box, the rows of whose feet nobody knows, with the robot somewhere."""
    found = Detections(box, np.ones(1), np.ones(1))
    projection = GroundProjection(robot_radius=0.3, seats=seats)
    return projection.project(replace(FRAME, fixed=fixed), found, Pose2D(*robot, 0.0))


def test_who_stands_behind_the_robot_is_placed_by_the_head() -> None:
    hidden, free = (placed(box_of(7.5, 0.1), robot) for robot in ((6.3, 0.0), (6.3, -1.2)))
    assert hidden.positions == pytest.approx(np.array([[7.5, 0.1]]), abs=0.1)
    assert hidden.per_height is not None and hidden.per_height.any()
    assert free.per_height is not None and not free.per_height.any()


def test_who_stands_behind_the_robot_is_not_placed_on_a_seat_farther_away_and_who_sits_there_is() -> None:
    far, near = (Seat("couch", np.array([x, 0.15]), math.pi, 0.8, 1.9) for x in (11.0, 6.0))
    stands = placed(box_of(7.5, 0.1), (6.3, 0.0), seats=[far])
    assert stands.positions == pytest.approx(np.array([[7.5, 0.1]]), abs=0.1)
    (head, shins), _ = project(np.array([[6.0, 0.15, 1.25], [5.5, 0.15, 0.1]]), INTRINSICS, CAMERA)
    box = np.array([[head[0] - 30.0, head[1], 60.0, shins[1] - head[1]]])
    sits = placed(box, (4.9, 0.15), seats=[near])
    assert sits.positions == pytest.approx(np.array([[6.0, 0.15]]), abs=0.05)
    assert sits.covariances[0, 0, 0] > 0.2  # anywhere on the seat: not by the feet


def test_a_box_around_people_far_away_and_the_robot_before_them_is_nobody_between() -> None:
    top = float(project(np.array([[11.0, 0.1, 1.75]]), INTRINSICS, CAMERA)[0][0, 1])
    box = box_of(8.0, 0.1)
    box[0, 1:] = top, box[0, 2], box[0, 1] + box[0, 3] - top
    assert placed(box, (6.8, -1.2)).positions == pytest.approx(np.array([[8.0, 0.1]]), abs=0.2)
    assert len(placed(box, (6.8, 0.0)).positions) == 0
    assert len(placed(box, (6.8, 0.0), fixed=False).positions) == 1  # the robot's own camera does not see the robot
