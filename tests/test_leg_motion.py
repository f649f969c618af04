"""Legs in made scans: told from walls and boxes, and as fast as they go."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from han_bullet.control.legs import LegMotion
from han_bullet.geometry import Pose2D, SolidBox
from tests.scans import scan_of

PERIOD = 0.1
STILL = Pose2D(0.0, 0.0, 0.0)


def box(x: float, y: float, sx: float, sy: float) -> SolidBox:
    return SolidBox("box", "object", np.array([x, y, 0.4]), np.array([sx, sy, 0.8]), 0.0)


ROOM = (box(2.0, 2.0, 12.0, 0.1), box(2.0, -2.0, 12.0, 0.1), box(6.0, 0.0, 0.1, 4.0))
CUPBOARD = box(3.0, 1.2, 0.6, 0.6)

Place = Callable[[float], tuple[float, float]]


def follow(
    person: Place | None, *, robot: Callable[[float], Pose2D] = lambda _: STILL, scans: int = 8, swing: float = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which points of the last scan are legs, all points in the world, and their velocities."""
    motion, rng = LegMotion(), np.random.default_rng(0)
    for number in range(scans):
        time = number * PERIOD
        legs = []
        if person is not None:
            (x, y), step = person(time), swing * math.sin(2.0 * math.pi * 0.9 * time)
            legs = [(x + 0.08, y + step, 0.06), (x - 0.08, y - step, 0.06)]
        pose = robot(time)
        scan = scan_of(pose, [*ROOM, CUPBOARD], legs, time=time, rng=rng)
        are_legs, velocities = motion.update(scan, pose)
    return are_legs, pose.to_world(scan.points_in_body), velocities


def test_a_pair_of_legs_is_found_and_nothing_of_walls_and_cupboards() -> None:
    are_legs, points, velocities = follow(lambda _: (2.0, 0.0))
    near = np.hypot(*(points - [2.0, 0.0]).T) < 0.3
    assert are_legs.sum() > 5 and near[are_legs].all()
    assert are_legs[near].mean() > 0.9
    assert not velocities.any()


@pytest.mark.parametrize("swing", [0.0, 0.15])
def test_whoever_walks_across_is_as_fast_as_they_go(swing: float) -> None:
    for scans in range(5, 12):
        are_legs, _, velocities = follow(lambda time: (2.0, 0.9 - time), scans=scans, swing=swing)
        vx, vy = velocities[are_legs].mean(axis=0)
        assert vy == pytest.approx(-1.0, abs=0.35)
        assert abs(vx) < 0.35


def test_nothing_moves_because_the_robot_does() -> None:
    for scans in range(4, 16):
        _, _, velocities = follow(
            lambda _: (2.5, -0.6), robot=lambda time: Pose2D(time, 0.3 * time, 0.6 * time), scans=scans
        )
        assert not velocities.any()


def test_without_people_nothing_moves_past_which_the_robot_drives() -> None:
    for scans in range(4, 25):
        _, _, velocities = follow(None, robot=lambda time: Pose2D(time, 0.0, 0.0), scans=scans)
        assert not velocities.any()


def test_a_velocity_fades_within_a_second_of_standing_still() -> None:
    def stops(time: float) -> tuple[float, float]:
        return 2.0, 0.6 - min(time, 0.6)

    assert follow(stops, scans=8)[2].any()
    assert not follow(stops, scans=18)[2].any()
