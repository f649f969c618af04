"""A doorway and a person: beside it they do not block it, in it they are waited for, and another door is taken."""

import numpy as np
import pytest

from han_bullet.control.follower import Follower
from han_bullet.control.recovery import Recovery
from han_bullet.costmap.grid import INSCRIBED, Costmap
from han_bullet.costmap.layers import standard_layers
from han_bullet.geometry import Pose2D, SolidBox
from han_bullet.messages import GoTo, Path, PoseEstimate, Posture, Scene, Status, TrackedPerson
from han_bullet.planning.planner import Planner

FLOOR = [((0.0, 8.0), (-3.0, 3.0))]
WALL = 4.0  # x of the wall with the door, whose middle is at y = 0 [m]
THICKNESS = 0.1
START, GOAL = Pose2D(1.0, 0.0, 0.0), Pose2D(7.0, 0.0, 0.0)
BODY = 0.25  # radius of a person [m]


def wall(start: float, end: float) -> SolidBox:
    centre, size = np.array([WALL, 0.5 * (start + end), 1.4]), np.array([THICKNESS, end - start, 2.8])
    return SolidBox("wall", "wall", centre, size, 0.0)


def door(width: float, second: bool = False) -> list[SolidBox]:
    """A wall with a door in its middle and, where wanted, a second one of the same width around y = 2."""
    half = 0.5 * width
    left = [wall(half, 2.0 - half), wall(2.0 + half, 3.0)] if second else [wall(half, 3.0)]
    return [wall(-3.0, -half), *left]


def standing(x: float, y: float, deviation: float) -> TrackedPerson:
    here, spread = np.array([x, y]), deviation**2 * np.eye(4)
    return TrackedPerson(0, 0.0, here, np.zeros(2), spread, Posture.STANDING, None)


def costmap(boxes: list[SolidBox], *people: TrackedPerson) -> Costmap:
    grid = Costmap.covering(FLOOR, 0.05)
    scene = Scene(0.0, people, task=GoTo(GOAL), pose_robot_in_world=START)
    for layer in standard_layers(boxes, robot_radius=0.3):
        layer.apply(grid, scene)
    return grid


def way(grid: Costmap, *people: TrackedPerson) -> Path | None:
    return Planner().update(grid, START.position, GOAL.position, 0.0, False, people)


def crossed_at(path: Path) -> float:
    """Where a way goes through the wall: y [m]."""
    return float(np.interp(WALL, path.points_in_world[:, 0], path.points_in_world[:, 1]))


@pytest.mark.parametrize("deviation", [0.0, 0.05, 0.2])  # certain, as a good track, and vaguer than the disc allows for
@pytest.mark.parametrize("width", [1.0, 1.2, 1.5])
def test_a_person_anywhere_beside_a_doorway_up_to_touching_its_jamb_leaves_it_open(
    width: float, deviation: float
) -> None:
    boxes, jamb = door(width), 0.5 * width
    before_the_wall = WALL - 0.5 * THICKNESS - BODY
    for side in (-1.0, 1.0):
        for x in (before_the_wall, before_the_wall - 0.3, 2.0 * WALL - before_the_wall):
            for beside in np.arange(jamb + BODY, 2.5, 0.05):  # the body's edge ends at the jamb's
                person = standing(x, side * float(beside), deviation)
                path = way(costmap(boxes, person), person)
                assert path is not None, (x, side * beside)
                assert np.allclose(path.points_in_world[-1], GOAL.position, atol=0.05)
                assert abs(crossed_at(path)) < jamb - 0.3


def follow(grid: Costmap, seconds: float, *people: TrackedPerson) -> list[Status]:
    """What a robot that cannot move on says, tick by tick."""
    planner, follower, recovery, said = Planner(), Follower(), Recovery(relocalize=lambda: None, ask=0.0), []
    for time in np.arange(0.0, seconds, 0.05):
        path = planner.update(grid, START.position, GOAL.position, float(time), False, people)
        seen = PoseEstimate(float(time), START)
        said.append(recovery.update(seen, follower.follow(path, GOAL, seen, people, grid)[1])[0])
    return said


@pytest.mark.parametrize("y", [-0.2, 0.0, 0.2])
def test_for_a_person_in_the_only_doorway_the_robot_waits_and_says_so_and_gives_up_after_10_s(y: float) -> None:
    person = standing(WALL, y, 0.05)
    grid = costmap(door(1.2), person)
    assert (grid.cost_at(np.array([[WALL, at] for at in np.arange(-0.6, 0.6, 0.05)])) >= INSCRIBED).all()
    assert way(grid, person) is None
    said = follow(grid, 10.5, person)
    assert set(said[:195]) == {Status.WAITING} and said[-1] is Status.BLOCKED


def test_for_a_person_in_one_of_two_doorways_the_robot_takes_the_other() -> None:
    boxes, person = door(1.2, second=True), standing(WALL, 0.0, 0.05)
    alone, round_them = way(costmap(boxes)), way(costmap(boxes, person), person)
    assert alone is not None and abs(crossed_at(alone)) < 0.3
    assert round_them is not None and crossed_at(round_them) == pytest.approx(2.0, abs=0.3)
