"""Localization by odometry and laser: tracking, getting lost, being found again."""

import math
from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from simulated_laser import CORRIDOR, CORRIDOR_FLOOR, FLOOR, NOBODY, ROOM, Laser, block, legs, standing, walled, wheels

from han_bullet.geometry import Array, Pose2D, SolidBox, wrap_angle
from han_bullet.localization.lidar import LidarLocalization
from han_bullet.localization.occupancy_grid import OccupancyGrid
from han_bullet.messages import PoseEstimate

TICK = 0.05  # [s]
START = np.diag([0.05, 0.05, math.radians(2.0)]) ** 2
Floor = tuple[tuple[float, float], tuple[float, float]]


def robot_at(start: Pose2D, boxes: Sequence[SolidBox] = ROOM, floor: Floor = FLOOR) -> LidarLocalization:
    grid = OccupancyGrid.of_building([floor], boxes, scan_height=0.25)
    return LidarLocalization(grid, start, START, np.random.default_rng(0))


def stand(
    robot: LidarLocalization,
    true: Pose2D,
    ticks: int,
    *,
    boxes: Sequence[SolidBox] = ROOM,
    discs: Array = NOBODY,
    start: float = 0.0,
) -> list[PoseEstimate]:
    """Let a robot look around where it truly is."""
    generator, laser = np.random.default_rng(round(1e3 * start)), Laser(boxes)
    times = [start + TICK * k for k in range(ticks)]
    scans = [laser.scan(t, true, discs, generator) if k % 2 == 0 else None for k, t in enumerate(times)]
    return [robot.update(standing(t), scan) for t, scan in zip(times, scans, strict=True)]


def round_trip(ticks: int) -> list[Pose2D]:
    """A way around in the room, turning all the time, sideways in part."""
    angles = [2.0 * math.pi * k / ticks for k in range(ticks)]
    return [Pose2D(3.5 + 1.3 * math.cos(a), 3.2 + 1.0 * math.sin(a), wrap_angle(2.0 * a)) for a in angles]


def driven(
    robot: LidarLocalization,
    way: Sequence[Pose2D],
    boxes: Sequence[SolidBox],
    *,
    people: Sequence[Pose2D] = (),
    late: int = 0,
    seed: int = 0,
) -> Iterator[tuple[PoseEstimate, Pose2D]]:
    """Drive a way; scans arrive some ticks late."""
    generator = np.random.default_rng(seed)
    times = [TICK * k for k in range(len(way))]
    scans = [Laser(boxes).scan(t, pose, legs(people), generator) for t, pose in zip(times, way, strict=True)]
    for k, odometry in enumerate(wheels(times, way, generator)):
        scan = scans[k - late] if k >= late and k % 2 == 0 else None
        yield robot.update(odometry, scan), way[k]


def error(estimate: PoseEstimate, true: Pose2D) -> Array:
    pose = estimate.pose_robot_in_world
    return np.array([pose.x - true.x, pose.y - true.y, wrap_angle(pose.yaw - true.yaw)])


def is_at(estimate: PoseEstimate, true: Pose2D) -> bool:
    off = error(estimate, true)
    return math.hypot(off[0], off[1]) < 0.05 and abs(off[2]) < math.radians(2.0)


def test_on_its_way_among_people_the_pose_stays_within_centimetres_and_is_never_lost() -> None:
    way = round_trip(400)
    people = [Pose2D(3.4, 3.1, 0.0), Pose2D(5.6, 3.4, 1.0)]
    steps = list(driven(robot_at(way[0]), way, ROOM, people=people))
    errors = np.array([error(*step) for step in steps])
    assert math.sqrt((np.hypot(errors[:, 0], errors[:, 1]) ** 2).mean()) < 0.02
    assert np.degrees(np.abs(errors[:, 2])).max() < 1.0
    assert not any(estimate.lost for estimate, _ in steps)


@pytest.mark.parametrize("late", [1, 3, 6])
def test_scans_that_arrive_late_are_taken_for_where_they_were_made(late: int) -> None:
    way = round_trip(400)
    errors = np.array([error(*step) for step in driven(robot_at(way[0]), way, ROOM, late=late)])
    assert np.hypot(errors[:, 0], errors[:, 1]).max() < 0.06
    assert np.degrees(np.abs(errors[20:, 2])).max() < 1.2


def test_a_scan_from_before_all_that_is_remembered_is_left_out() -> None:
    robot, true = robot_at(Pose2D(3.0, 2.5, 0.4)), Pose2D(3.0, 2.5, 0.4)
    before = robot.update(standing(10.0), None)
    after = robot.update(standing(10.05), Laser(ROOM).scan(2.0, true, NOBODY, np.random.default_rng(0)))
    assert after.covariance == pytest.approx(before.covariance)


def test_between_scans_the_pose_goes_on_with_the_odometry_and_gets_less_certain() -> None:
    robot, true = robot_at(Pose2D(3.0, 2.5, 0.0)), Pose2D(3.0, 2.5, 0.0)
    known = stand(robot, true, 3)[-1]
    way = [Pose2D(0.02 * k, 0.0, 0.0) for k in range(60)]
    estimates = [
        robot.update(odometry, None)
        for odometry in wheels([TICK * k for k in range(3, 63)], way, np.random.default_rng(4))
    ]
    assert estimates[-1].pose_robot_in_world.x - known.pose_robot_in_world.x == pytest.approx(1.18, abs=0.06)
    deviations = [math.sqrt(estimate.covariance[0, 0]) for estimate in estimates]
    assert np.all(np.diff(deviations[1:]) > 0.0) and deviations[-1] > 0.02
    assert all(np.linalg.eigvalsh(estimate.covariance)[0] > 0.0 for estimate in estimates)


def test_along_a_corridor_and_in_a_room_the_errors_are_as_large_as_the_covariance_says() -> None:
    normalized = {"corridor": [], "room": []}
    for seed in range(6):
        generator = np.random.default_rng([seed, 7])
        for place, boxes, floor, way in (
            ("corridor", CORRIDOR, CORRIDOR_FLOOR, [Pose2D(16.0 + 0.05 * k, 0.0, 0.0) for k in range(160)]),
            ("room", ROOM, FLOOR, round_trip(160)),
        ):
            x, y, yaw = (np.sqrt(np.diag(START)) * generator.normal(size=3)).tolist()
            robot = robot_at(Pose2D(way[0].x + x, way[0].y + y, way[0].yaw + yaw), boxes, floor)
            for estimate, true in driven(robot, way, boxes, seed=seed):
                off = error(estimate, true)
                normalized[place].append(float(off @ np.linalg.solve(estimate.covariance, off)))
    for place, values in normalized.items():
        # Three numbers: three if honest; rather too careful, as in the room, than too sure.
        assert 3.0 / 9.0 < np.mean(values) < 5.0, place


@pytest.mark.parametrize(
    "to",
    [
        Pose2D(4.0, 2.5, 0.4),
        Pose2D(2.0, 2.5, 0.4),
        Pose2D(3.0, 3.5, 0.4),
        Pose2D(3.0, 2.5, 0.4 + math.pi / 6),
        Pose2D(3.0, 2.5, 0.4 - math.pi / 6),
    ],
)
def test_a_robot_that_is_carried_away_notices_within_a_second_and_finds_itself_on_request(to: Pose2D) -> None:
    robot, at = robot_at(Pose2D(3.0, 2.5, 0.4)), Pose2D(3.0, 2.5, 0.4)
    person = legs([Pose2D(4.5, 3.0, 0.0)])
    assert is_at(stand(robot, at, 20, discs=person)[-1], at)
    carried = stand(robot, to, 20, discs=person, start=1.0)
    assert carried[-1].lost
    assert all(estimate.lost for estimate in stand(robot, at, 20, discs=person, start=2.0))  # until it is found
    robot.relocalize()
    found = stand(robot, to, 20, discs=person, start=3.0)
    assert not found[-1].lost and is_at(found[-1], to)


def test_people_who_stand_near_and_a_box_that_is_not_on_the_map_do_not_make_it_lost() -> None:
    at = Pose2D(3.0, 2.5, 0.4)
    people = legs([Pose2D(3.8, 2.6, 0.0), Pose2D(3.2, 1.7, 1.0)])
    estimates = stand(robot_at(at), at, 80, boxes=[*ROOM, block(4.2, 3.8, 0.8, 0.8, 0.3)], discs=people)
    assert not any(estimate.lost for estimate in estimates)
    assert is_at(estimates[-1], at)


@pytest.mark.parametrize("at", [Pose2D(1.0, 1.0, 0.0), Pose2D(7.0, 5.0, -2.0), Pose2D(4.0, 3.0, 2.5)])
def test_it_finds_itself_anywhere_in_a_few_scans(at: Pose2D) -> None:
    robot = robot_at(Pose2D(3.0, 2.5, 0.4))
    robot.relocalize()
    estimates = stand(robot, at, 20, discs=legs([at.compose(Pose2D(1.0, 0.3, 0.0))]))
    assert estimates[0].lost and not estimates[-1].lost
    assert is_at(estimates[-1], at)
    assert np.sqrt(np.diag(estimates[-1].covariance))[:2].max() < 0.05


def test_it_finds_itself_while_it_drives() -> None:
    way, robot = round_trip(400), robot_at(Pose2D(1.0, 1.0, 0.0))
    robot.relocalize()
    steps = list(driven(robot, way[:40], ROOM))
    assert not steps[-1][0].lost and is_at(*steps[-1])


def test_in_a_room_that_looks_the_same_turned_about_it_stays_lost() -> None:
    symmetric = walled(*FLOOR)
    robot = robot_at(Pose2D(3.0, 2.5, 0.4), symmetric)
    robot.relocalize()
    estimates = stand(robot, Pose2D(2.0, 2.5, 0.4), 100, boxes=symmetric)
    assert all(estimate.lost for estimate in estimates)


def test_in_a_bare_corridor_it_stays_lost_until_the_end_comes_in_sight() -> None:
    robot = robot_at(Pose2D(3.0, 0.0, 0.0), [*CORRIDOR, block(39.0, 1.0, 0.5, 1.0)], CORRIDOR_FLOOR)
    robot.relocalize()
    way = [Pose2D(20.0 + 0.06 * k, 0.0, 0.0) for k in range(280)]
    steps = list(driven(robot, way, [*CORRIDOR, block(39.0, 1.0, 0.5, 1.0)]))
    assert all(estimate.lost for estimate, true in steps if true.x < 30.0)
    assert steps[100][0].covariance[0, 0] > 1.0
    assert not steps[-1][0].lost and is_at(*steps[-1])


def test_equal_generators_give_equal_estimates() -> None:
    way = round_trip(30)
    runs = []
    for _ in range(2):
        robot = robot_at(way[0])
        robot.relocalize()
        runs.append([estimate.pose_robot_in_world for estimate, _ in driven(robot, way, ROOM)])
    assert runs[0] == runs[1]


def test_without_scans_it_is_lost_once_the_wheels_may_have_led_it_astray_and_no_longer_when_a_scan_tells() -> None:
    """Twelve metres at 2 % in either direction and a degree per root metre; the laser is dead for them."""
    way = [Pose2D(0.5 + 0.05 * k, 0.0, 0.0) for k in range(600)]
    robot = robot_at(way[0], CORRIDOR, CORRIDOR_FLOOR)
    odometry = wheels([TICK * k for k in range(600)], way, np.random.default_rng(0))
    lost = [robot.update(one, None).lost for one in odometry]
    first = 0.05 * lost.index(True)
    assert 8.0 < first < 16.0 and all(lost[lost.index(True) :])


def test_a_robot_lost_for_want_of_scans_knows_its_place_again_by_one_in_a_room() -> None:
    here = Pose2D(3.0, 2.5, 0.4)
    grid = OccupancyGrid.of_building([FLOOR], ROOM, scan_height=0.25)
    robot = LidarLocalization(grid, here, np.diag([0.6, 0.1, 0.05]) ** 2, np.random.default_rng(0))
    assert robot.update(standing(0.0), None).lost
    found = robot.update(standing(0.05), Laser(ROOM).scan(0.05, here, NOBODY, np.random.default_rng(0)))
    assert not found.lost and is_at(found, here)
