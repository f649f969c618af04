"""Odometry: exact without slip, and with it as wrong as it is said to be."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.geometry import Array, Pose2D, Twist2D, moved, twist_between, wrap_angle
from han_bullet.mecanum import MecanumWheels
from han_bullet.sim.odometry import WheelOdometry
from han_bullet.sim.simulator import Simulator
from han_bullet.world_file import load_world
from han_bullet.world_schema import CONTROL_PERIOD, Slip, World

WHEELS = MecanumWheels(0.075, 0.165, 0.195)
NO_SLIP = Slip(distance=0.0, heading=0.0, turn=0.0)
SEEDS = 1500  # a standard deviation is then known to 2 %
SPEEDS = st.floats(-2.0, 2.0)
TWISTS = st.builds(Twist2D, SPEEDS, SPEEDS, SPEEDS)
POSES = st.builds(Pose2D, st.floats(-20.0, 20.0), st.floats(-20.0, 20.0), st.floats(-3.1, 3.1))


def apart(one: Pose2D, other: Pose2D) -> tuple[float, float]:
    return one.distance_to(other.position), abs(wrap_angle(one.yaw - other.yaw))


def world_with(slip: Slip, yaw: float = 0.0) -> World:
    world = load_world("real1")
    return world.model_copy(
        update={"people": (), "robot": world.robot.model_copy(update={"start": (8.0, 0.0, yaw), "slip": slip})}
    )


def ends(slip: Slip, twist: Twist2D, ticks: int) -> Array:
    """Where odometry puts the end of a way, x, y and yaw for many seeds, shape (SEEDS, 3)."""
    way = [Pose2D(3.0, -1.0, 0.7)]
    for _ in range(ticks):
        way.append(moved(way[-1], twist, CONTROL_PERIOD))
    rows = []
    for seed in range(SEEDS):
        odometry = WheelOdometry(WHEELS, slip, way[0], np.random.default_rng(seed))
        for pose in way[1:]:
            odometry.advance(pose)
        end = odometry.read(ticks * CONTROL_PERIOD).pose_robot_in_odom
        rows.append((end.x, end.y, end.yaw))
    return np.array(rows)


@given(TWISTS)
def test_wheels_that_a_twist_turns_tell_that_twist(twist: Twist2D) -> None:
    told = WHEELS.twist(WHEELS.speeds(twist))
    assert (told.vx, told.vy, told.omega) == pytest.approx((twist.vx, twist.vy, twist.omega), abs=1e-12)


def test_wheels_that_turn_alike_tell_of_a_way_straight_ahead() -> None:
    told = WHEELS.twist((2.0, 2.0, 2.0, 2.0))
    assert (told.vx, told.vy, told.omega) == pytest.approx((0.15, 0.0, 0.0))


@given(POSES, TWISTS)
def test_a_twist_between_two_poses_moves_one_to_the_other(pose: Pose2D, twist: Twist2D) -> None:
    found = twist_between(pose, moved(pose, twist, 0.5), 0.5)
    assert (found.vx, found.vy, found.omega) == pytest.approx((twist.vx, twist.vy, twist.omega), abs=1e-9)


def test_a_quarter_circle_ends_a_radius_ahead_and_a_radius_to_the_left() -> None:
    end = moved(Pose2D(1.0, 2.0, 0.5 * math.pi), Twist2D(0.5 * math.pi, 0.0, 0.5 * math.pi), 1.0)
    assert (end.x, end.y, abs(end.yaw)) == pytest.approx((0.0, 3.0, math.pi))


def test_without_slip_odometry_is_the_true_way_to_a_micrometre() -> None:
    with Simulator(world_with(NO_SLIP, yaw=2.0), renderer=None) as simulator:
        start = simulator.reset()
        assert start.odometry.pose_robot_in_odom == Pose2D(0.0, 0.0, 0.0)
        origin = simulator.truth.pose_robot_in_world
        for tick in range(120):
            command = Twist2D(0.8 * math.cos(tick / 9.0), 0.4 * math.sin(tick / 5.0), 1.2 * math.cos(tick / 7.0))
            odometry = simulator.step(command).odometry
            true = simulator.truth.pose_robot_in_world
            in_odom = Pose2D(*origin.to_body(true.position), wrap_angle(true.yaw - origin.yaw))
            assert odometry.time == simulator.truth.time
            assert max(apart(odometry.pose_robot_in_odom, in_odom)) < 1e-6
        assert true.distance_to(origin.position) > 0.3, "the way leads nowhere"


def test_odometrys_twist_is_in_the_body_frame_whichever_way_the_robot_faces() -> None:
    with Simulator(world_with(NO_SLIP, yaw=0.5 * math.pi), renderer=None) as simulator:
        simulator.reset()
        for _ in range(30):
            odometry = simulator.step(Twist2D(0.5, 0.0, 0.0)).odometry
        true = simulator.truth.twist_robot_in_body.linear_in_world(simulator.truth.pose_robot_in_world.yaw)
        assert true == pytest.approx([0.0, 0.5], abs=0.01)
        twist = odometry.twist_robot_in_body
        assert (twist.vx, twist.vy, twist.omega) == pytest.approx((0.5, 0.0, 0.0), abs=0.01)
        assert odometry.pose_robot_in_odom.x > 0.4
        assert odometry.pose_robot_in_odom.y == pytest.approx(0.0, abs=0.01)


def test_odometrys_pose_follows_from_the_last_one_by_its_twist_slip_and_all() -> None:
    with Simulator(world_with(Slip(distance=0.1, heading=0.1, turn=0.1)), renderer=None, seed=4) as simulator:
        last = simulator.reset().odometry
        for tick in range(40):
            now = simulator.step(Twist2D(0.7, 0.2, math.sin(tick / 5.0))).odometry
            expected = moved(last.pose_robot_in_odom, now.twist_robot_in_body, CONTROL_PERIOD)
            assert max(apart(now.pose_robot_in_odom, expected)) < 1e-12
            last = now


@pytest.mark.parametrize(("vx", "vy"), [(0.8, 0.0), (0.0, -0.8), (0.48, 0.64)])
def test_a_straight_way_is_wrong_by_a_fiftieth_whichever_way_it_leads(vx: float, vy: float) -> None:
    slip = Slip(distance=0.02, heading=0.0, turn=0.0)
    for ticks in (25, 100):  # 1 m and 4 m
        distance = 0.8 * ticks * CONTROL_PERIOD
        errors = ends(slip, Twist2D(vx, vy, 0.0), ticks)[:, :2] - distance * np.array([vx, vy]) / 0.8
        assert np.sqrt((errors**2).sum(axis=1).mean()) == pytest.approx(0.02 * distance, rel=0.08)
        assert np.abs(errors.mean(axis=0)).max() < 0.002 * distance


def test_the_errors_ahead_and_to_the_side_have_nothing_to_do_with_one_another() -> None:
    found = ends(Slip(distance=0.02, heading=0.0, turn=0.0), Twist2D(0.5, 0.5, 0.0), 20)
    assert abs(np.corrcoef(found[:, 0], found[:, 1])[0, 1]) < 0.1


def test_the_headings_variance_grows_with_the_distance() -> None:
    slip = Slip(distance=0.0, heading=0.0175, turn=0.0)
    for ticks in (25, 100):
        yaws = ends(slip, Twist2D(0.0, 0.8, 0.0), ticks)[:, 2]
        assert yaws.std() == pytest.approx(0.0175 * math.sqrt(0.8 * ticks * CONTROL_PERIOD), rel=0.08)
        assert abs(yaws.mean()) < 0.002


def test_a_turn_on_the_spot_is_wrong_by_a_fiftieth_of_its_angle_and_leads_nowhere() -> None:
    found = ends(Slip(distance=0.5, heading=0.5, turn=0.02), Twist2D(0.0, 0.0, 1.0), 40)
    assert found[:, 2].std() == pytest.approx(0.02 * 2.0, rel=0.08)
    assert np.abs(found[:, :2]).max() < 1e-12


def test_a_robot_that_rests_does_not_drift() -> None:
    assert np.abs(ends(Slip(), Twist2D(), 20)).max() == 0.0


def test_the_default_slip_is_a_fiftieth_and_a_degree_per_root_of_a_metre() -> None:
    slip = Slip()
    assert (slip.distance, slip.turn) == (0.02, 0.02)
    assert math.degrees(slip.heading) == pytest.approx(1.0, abs=0.01)


def test_a_seed_decides_the_slip_and_a_reset_repeats_it() -> None:
    def way(simulator: Simulator) -> list[Pose2D]:
        simulator.reset()
        return [simulator.step(Twist2D(0.8, 0.0, 0.3)).odometry.pose_robot_in_odom for _ in range(30)]

    with Simulator(world_with(Slip()), renderer=None, seed=1) as one:
        first = way(one)
        assert way(one) == first
    with Simulator(world_with(Slip()), renderer=None, seed=2) as other:
        assert way(other) != first
