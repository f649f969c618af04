"""The most likely pose by a prediction and a scan, and its covariance."""

import math

import numpy as np
import pytest
from simulated_laser import CORRIDOR, CORRIDOR_FLOOR, FLOOR, NOBODY, ROOM, Laser, block, legs

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Pose2D, SolidBox, rotation
from han_bullet.localization.beams import Beams
from han_bullet.localization.likelihood_field import LikelihoodField
from han_bullet.localization.occupancy_grid import OccupancyGrid
from han_bullet.localization.scan_matching import ScanMatcher

VAGUE = np.diag([0.2, 0.2, math.radians(5.0)]) ** 2


def matcher(boxes: list[SolidBox], floor: tuple[tuple[float, float], tuple[float, float]]) -> ScanMatcher:
    return ScanMatcher(LikelihoodField.of_map(OccupancyGrid.of_building([floor], boxes, scan_height=0.25)))


def seen(boxes: list[SolidBox], pose: Pose2D, discs: Array = NOBODY, seed: int = 0) -> Beams:
    scan = Laser(boxes).scan(0.0, pose, discs, np.random.default_rng(seed))
    return Beams.of_scan(scan, scan.scanner_in_body)


@pytest.mark.parametrize("off", [(0.15, 0.1, 0.05), (-0.15, 0.1, -0.05), (0.0, -0.2, 0.08), (-0.2, 0.0, -0.08)])
def test_in_a_room_the_scan_alone_tells_the_pose_to_a_centimetre(off: tuple[float, float, float]) -> None:
    true = Pose2D(3.0, 2.5, 0.4)
    pose, _ = matcher(ROOM, FLOOR).match(
        Pose2D(true.x + off[0], true.y + off[1], true.yaw + off[2]), VAGUE, seen(ROOM, true)
    )
    assert true.distance_to(pose.position) < 0.01
    assert pose.yaw == pytest.approx(true.yaw, abs=math.radians(0.2))


def test_people_around_the_robot_pull_at_nothing() -> None:
    true = Pose2D(3.0, 2.5, 0.4)
    people = legs([Pose2D(4.0, 3.0, 0.0), Pose2D(3.4, 1.6, 1.0), Pose2D(2.2, 3.1, 2.0)])
    pose, _ = matcher(ROOM, FLOOR).match(Pose2D(3.1, 2.4, 0.43), VAGUE, seen(ROOM, true, people))
    assert true.distance_to(pose.position) < 0.01


def test_along_a_bare_corridor_prediction_and_deviation_stay_and_across_it_the_scan_decides() -> None:
    pose, covariance = matcher(CORRIDOR, CORRIDOR_FLOOR).match(
        Pose2D(20.1, 0.1, 0.03), VAGUE, seen(CORRIDOR, Pose2D(20.0, 0.0, 0.0))
    )
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((20.1, 0.0, 0.0), abs=0.01)
    assert math.sqrt(covariance[0, 0]) == pytest.approx(0.2, rel=0.01)
    assert math.sqrt(covariance[1, 1]) < 0.01


def test_the_end_of_a_corridor_in_sight_tells_the_place_along_it() -> None:
    pose, covariance = matcher(CORRIDOR, CORRIDOR_FLOOR).match(
        Pose2D(34.1, 0.0, 0.0), VAGUE, seen(CORRIDOR, Pose2D(34.0, 0.0, 0.0))
    )
    assert pose.x == pytest.approx(34.0, abs=0.01)
    assert math.sqrt(covariance[0, 0]) < 0.02


def test_walls_that_the_grid_cannot_draw_straight_cost_a_centimetre_not_more() -> None:
    turned = [
        SolidBox(box.name, box.kind, np.array([*rotation(0.3) @ box.centre_in_world[:2], 0.5]), box.size, 0.3 + box.yaw)
        for box in ROOM
    ]
    true = Pose2D(*rotation(0.3) @ [3.0, 2.5], 0.7)
    pose, _ = matcher(turned, ((-2.0, 8.0), (0.0, 8.5))).match(
        Pose2D(true.x + 0.1, true.y - 0.1, true.yaw + 0.05), VAGUE, seen(turned, true)
    )
    assert true.distance_to(pose.position) < 0.03
    assert pose.yaw == pytest.approx(true.yaw, abs=math.radians(0.5))


def test_a_scan_without_any_echo_leaves_the_prediction_as_it_is() -> None:
    nothing = Beams(np.zeros(2), np.array([[8.0, 0.0]]), np.array([False]))
    pose, covariance = matcher(ROOM, FLOOR).match(Pose2D(3.0, 2.0, 0.1), VAGUE, nothing)
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((3.0, 2.0, 0.1))
    assert covariance == pytest.approx(VAGUE)


def test_the_corner_where_walls_end_draws_a_pose_back_but_does_not_tell_it_to_centimetres() -> None:
    walls = [block(8.0, side * 1.55, 16.0, 0.1) for side in (-1, 1)]
    robot, true = matcher(walls, ((0.0, 30.0), (-1.5, 1.5))), Pose2D(9.0, 0.0, 0.0)
    pose, covariance = robot.match(Pose2D(9.6, 0.0, 0.0), np.diag([0.4, 0.2, 0.1]) ** 2, seen(walls, true))
    assert 8.8 < pose.x < 9.35
    assert math.sqrt(covariance[0, 0]) > 0.2


@pytest.mark.parametrize("name", ["deviation", "outlier", "independent"])
def test_a_matcher_refuses_what_is_no_positive_number(name: str) -> None:
    with pytest.raises(BadInputError, match=f"scan matcher: {name} is 0.0; it must be a positive number"):
        ScanMatcher(matcher(CORRIDOR, CORRIDOR_FLOOR).field, **{name: 0.0})
