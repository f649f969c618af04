"""The obstacle layer on made scans: what is new is marked, what moves away is cleared, map and people are left out."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from han_bullet.costmap.grid import FREE, INSCRIBED, LETHAL, Costmap
from han_bullet.costmap.inflation import InflationLayer
from han_bullet.costmap.obstacle import ObstacleLayer
from han_bullet.costmap.static import StaticLayer
from han_bullet.geometry import Pose2D, SolidBox
from han_bullet.messages import LaserScan, Posture, Scene, Seat, TrackedPerson
from han_bullet.planning.planner import Planner
from tests.scans import scan_of

FLOOR = [((0.0, 12.0), (-1.5, 1.5))]
HERE = Pose2D(2.0, 0.0, 0.0)
PERIOD = 0.1  # between scans [s]


def box(x: float, y: float, sx: float, sy: float, yaw: float = 0.0) -> SolidBox:
    return SolidBox("box", "object", np.array([x, y, 0.4]), np.array([sx, sy, 0.8]), yaw)


WALLS = (box(6.0, 1.55, 12.0, 0.1), box(6.0, -1.55, 12.0, 0.1), box(12.05, 0.0, 0.1, 3.2), box(-0.05, 0.0, 0.1, 3.2))
COUCH = box(7.0, 1.0, 1.9, 0.8, yaw=0.1)
BOX = box(4.5, 0.0, 0.5, 0.5)


def track(
    x: float, y: float, velocity: tuple[float, float] = (0.0, 0.0), deviation: float = 0.05, seat: str | None = None
) -> TrackedPerson:
    posture = Posture.SEATED if seat else Posture.WALKING if any(velocity) else Posture.STANDING
    return TrackedPerson(
        0, 0.0, np.array([x, y]), np.array(velocity), deviation**2 * np.eye(4), posture, None, seat=seat
    )


def seen_from(pose: Pose2D, scan: LaserScan, now: Pose2D | None = None, **known: Any) -> Scene:
    """Return the scene in which a scan comes that was taken at a pose; the robot is still there unless told."""
    return Scene(scan.time, pose_robot_in_world=now or pose, laser=scan, pose_robot_at_scan=pose, **known)


class Robot:
    """A robot that stands and scans; the map has the walls and the couch."""

    def __init__(self, layer: ObstacleLayer | None = None) -> None:
        self.layer = layer or ObstacleLayer(robot_radius=0.3)
        self.static = StaticLayer([*WALLS, COUCH])
        self.inflation = InflationLayer(robot_radius=0.3)
        self.time = 0.0
        self.rng = np.random.default_rng(0)

    def map(self, scene: Scene) -> Costmap:
        costmap = Costmap.covering(FLOOR, 0.05)
        for layer in (self.static, self.layer, self.inflation):
            layer.apply(costmap, scene)
        return costmap

    def look(
        self,
        *new: SolidBox,
        pose: Pose2D = HERE,
        believed: Callable[[Pose2D], Pose2D] = lambda pose: pose,
        legs: Sequence[tuple[float, float]] = (),
        people: Sequence[TrackedPerson] = (),
        seats: Sequence[Seat] = (),
        scans: int = 1,
    ) -> Costmap:
        for _ in range(scans):
            self.time += PERIOD
            discs = [(x, y, 0.1) for x, y in legs]
            scan = scan_of(pose, [*WALLS, COUCH, *new], discs, time=self.time, rng=self.rng)
            costmap = self.map(seen_from(believed(pose), scan, people=tuple(people), seats=tuple(seats)))
        return costmap


def marked(costmap: Costmap) -> np.ndarray:
    """Centres of the cells that are LETHAL and not so by the map, (n, 2) [m]."""
    static = Costmap.covering(FLOOR, 0.05)
    StaticLayer([*WALLS, COUCH]).apply(static, Scene(0.0))
    return costmap.cell_to_world(np.argwhere((costmap.cost == LETHAL) & (static.cost < LETHAL)))


def test_a_box_that_the_map_does_not_have_is_marked_where_it_is_and_inflated_as_part_of_the_building() -> None:
    costmap = Robot().look(BOX, scans=5)
    cells = marked(costmap)
    assert len(cells) >= 9  # its face of 0.5 m
    assert BOX.contains(cells, margin=0.07).all()
    assert (np.abs(cells[:, 0] - 4.25) < 0.08).sum() >= 9
    before = np.array([4.25 - 0.28, 0.0])
    assert costmap.cost_at(before) == INSCRIBED
    assert costmap.social_cost_at(before) == FREE  # it blocks as a wall does, not as a person's space


def test_one_hit_is_noise_and_three_are_an_obstacle() -> None:
    robot = Robot()
    assert [len(marked(robot.look(BOX))) > 0 for _ in range(4)] == [False, False, True, True]


def test_a_scan_counts_once_however_often_it_is_looked_at() -> None:
    robot = Robot()
    scan = scan_of(HERE, [*WALLS, BOX], time=1.0)
    for _ in range(10):
        costmap = robot.map(seen_from(HERE, scan))
    assert len(marked(costmap)) == 0


def test_a_scan_that_comes_late_is_placed_where_the_robot_was() -> None:
    robot, prompt = Robot(), marked(Robot().look(BOX, scans=3))
    for number in range(1, 4):
        scan = scan_of(HERE, [*WALLS, COUCH, BOX], time=PERIOD * number, rng=robot.rng)
        costmap = robot.map(seen_from(HERE, scan, now=Pose2D(HERE.x + 0.6, HERE.y - 0.2, 0.4)))
    assert np.array_equal(marked(costmap), prompt) and len(prompt) > 0


def test_what_is_cleared_is_free_at_once_and_marked_anew_if_it_is_still_there() -> None:
    robot = Robot()
    robot.look(BOX, scans=5)
    robot.layer.clear()
    assert len(marked(robot.map(Scene(robot.time, pose_robot_in_world=HERE)))) == 0
    assert [len(marked(robot.look(BOX))) > 0 for _ in range(3)] == [False, False, True]


def test_between_scans_the_marks_stay() -> None:
    robot = Robot()
    seen = robot.look(BOX, scans=5)
    assert np.array_equal(robot.map(Scene(robot.time + 0.05)).cost, seen.cost)


def test_a_box_that_is_taken_away_is_gone_from_the_map_within_a_second() -> None:
    robot = Robot()
    assert len(marked(robot.look(BOX, scans=20))) > 0
    left = [len(marked(robot.look())) for _ in range(10)]
    assert left[-1] == 0
    assert left[0] > 0  # a scan alone does not clear what many saw
    clean = Costmap.covering(FLOOR, 0.05)
    for layer in (StaticLayer([*WALLS, COUCH]), InflationLayer(robot_radius=0.3)):
        layer.apply(clean, Scene(0.0))
    assert np.array_equal(robot.look().cost, clean.cost)  # with all that was inflated


def test_rays_that_meet_nothing_clear_too() -> None:
    robot = Robot()
    robot.look(BOX, scans=10)
    nothing = scan_of(HERE, time=robot.time + PERIOD)
    assert np.isinf(nothing.ranges).all()
    for number in range(1, 11):
        scan = LaserScan(robot.time + number * PERIOD, *[getattr(nothing, name) for name in REST])
        costmap = robot.map(seen_from(HERE, scan))
    assert len(marked(costmap)) == 0


REST = ("ranges", "angle_min", "angle_increment", "range_min", "range_max", "scanner_in_body")


def test_what_is_out_of_sight_stays_as_it_was_seen_last() -> None:
    robot = Robot()
    seen = len(marked(robot.look(BOX, scans=5)))
    turned_away = Pose2D(HERE.x, HERE.y, math.pi)
    assert len(marked(robot.look(pose=turned_away, scans=20))) == seen > 0


def test_beyond_its_range_nothing_is_marked() -> None:
    far = box(8.0, 0.0, 0.5, 0.5)
    assert len(marked(Robot().look(far, scans=5))) == 0
    nearer = Pose2D(3.8, 0.0, 0.0)
    assert len(marked(Robot().look(far, pose=nearer, scans=5))) > 0


@pytest.mark.parametrize("yaw", [-1.0, 1.0])
@pytest.mark.parametrize("shift", [(0.035, 0.035), (-0.035, -0.035), (0.0, 0.05), (0.0, -0.05)])
def test_walls_and_furniture_of_the_map_are_not_marked_again_by_a_pose_5_cm_and_1_degree_off(
    shift: tuple[float, float], yaw: float
) -> None:
    def believed(pose: Pose2D) -> Pose2D:
        return Pose2D(pose.x + shift[0], pose.y + shift[1], pose.yaw + math.radians(yaw))

    robot = Robot()
    for x in np.arange(1.0, 10.0, 0.25):
        costmap = robot.look(pose=Pose2D(float(x), -0.6, 0.3 * yaw), believed=believed, scans=3)
        assert len(marked(costmap)) == 0, x


def test_a_box_that_stands_at_a_wall_is_marked_where_it_leaves_it() -> None:
    cells = marked(Robot().look(box(4.0, 1.3, 0.5, 0.4), scans=5))
    assert len(cells) > 5 and cells[:, 1].min() < 1.15


def test_a_trembling_pose_marks_the_box_and_nothing_else() -> None:
    robot, rng = Robot(), np.random.default_rng(1)

    def believed(pose: Pose2D) -> Pose2D:
        dx, dy, dyaw = rng.normal(0.0, [0.02, 0.02, math.radians(0.4)])
        return Pose2D(pose.x + dx, pose.y + dy, pose.yaw + dyaw)

    for _ in range(30):
        cells = marked(robot.look(BOX, believed=believed))
    assert len(cells) > 5
    assert BOX.contains(cells, margin=0.15).all()


LEGS = [(4.4, 0.1), (4.6, -0.1)]


def test_the_legs_of_a_tracked_person_are_left_to_the_layers_of_people() -> None:
    assert len(marked(Robot().look(legs=LEGS, scans=10))) > 0
    assert len(marked(Robot().look(legs=LEGS, people=[track(4.5, 0.0)], scans=10))) == 0


def test_a_box_two_steps_from_a_person_is_marked() -> None:
    assert len(marked(Robot().look(BOX, people=[track(4.5, 1.0)], scans=5))) > 0


def test_marks_that_turn_out_to_be_a_person_are_forgotten() -> None:
    robot = Robot()
    assert len(marked(robot.look(legs=LEGS, scans=10))) > 0
    assert len(marked(robot.look(legs=LEGS, people=[track(4.5, 0.0)]))) == 0


def test_legs_ahead_of_a_track_that_lags_are_the_walkers() -> None:
    ahead = [(5.2, 0.0)]
    assert len(marked(Robot().look(legs=ahead, people=[track(4.5, 0.0)], scans=5))) > 0
    assert len(marked(Robot().look(legs=ahead, people=[track(4.5, 0.0, (1.2, 0.0))], scans=5))) == 0


def test_a_vague_track_reaches_farther() -> None:
    legs = [(4.5, 0.55)]
    assert len(marked(Robot().look(legs=legs, people=[track(4.5, 0.0, deviation=0.01)], scans=5))) > 0
    assert len(marked(Robot().look(legs=legs, people=[track(4.5, 0.0, deviation=0.2)], scans=5))) == 0


def test_the_legs_before_a_seat_belong_to_whoever_sits_there() -> None:
    seat = Seat("couch", np.array([4.5, 0.7]), -0.5 * math.pi, 0.8, 1.9)
    legs, sitting = [(4.4, 0.1), (4.6, 0.1)], track(4.5, 0.7, seat="couch")
    assert len(marked(Robot().look(legs=legs, people=[track(4.5, 0.7)], scans=5))) > 0
    assert len(marked(Robot().look(legs=legs, people=[sitting], seats=[seat], scans=5))) == 0


def test_an_obstacle_that_appears_on_the_way_makes_the_planner_plan_at_once() -> None:
    robot, planner, goal = Robot(), Planner(replan_period=0.5), np.array([10.0, 0.0])
    way = planner.update(robot.look(scans=3), HERE.position, goal, 0.0, False)
    assert way is not None and np.abs(way.points_in_world[:, 1]).max() < 0.3
    for number in range(1, 4):  # the third scan marks it, 0.15 s after the last search and long before the next is due
        costmap = robot.look(box(4.5, -0.3, 0.5, 0.9))
        round_it = planner.update(costmap, HERE.position, goal, 0.05 * number, False)
        assert round_it is not None
        assert (round_it.expanded > 0) == (number == 3)
    assert round_it.points_in_world[:, 1].max() > 0.4
    assert (costmap.cost_at(round_it.points_in_world) < INSCRIBED).all()


def test_where_the_robot_stands_is_no_obstacle() -> None:
    robot = Robot()
    robot.look(BOX, scans=5)
    inside = Pose2D(4.25, 0.0, 0.0)
    assert robot.look(pose=inside).cost_at(inside.position) < INSCRIBED
