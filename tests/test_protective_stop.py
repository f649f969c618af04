"""The protective stop: whatever is commanded, the base stops before what its scanner sees; nothing else slows it."""

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from han_bullet.control.protective_stop import ProtectiveStop
from han_bullet.errors import BadInputError
from han_bullet.geometry import Pose2D, Twist2D, rotation
from han_bullet.messages import LaserScan
from han_bullet.world_schema import CONTROL_PERIOD
from tests.scans import scan_at

RADIUS = 0.3
CLEARANCE = 0.05
PHYSICS = 1.0 / 240.0

Points = Sequence[tuple[float, float]]


class Base:
    """An omnidirectional base with limited accelerations, as the simulator's, among points in the world.

    Its loop has a period [s]; the scanner's is 0.1 s, or that of a loop that is slower.
    """

    def __init__(
        self, points: Points, twist: Twist2D = Twist2D(), noise: float = 0.0, period: float = CONTROL_PERIOD
    ) -> None:
        self.pose, self.twist = Pose2D(0.0, 0.0, 0.0), twist
        self.points = np.array(points, float).reshape(-1, 2)
        self.noise = np.random.default_rng(0), noise
        self.tick = 0
        self.nearest = self.gap
        self.period = period
        self.stop = ProtectiveStop(reaction=0.1 + period)
        self.stop.control_period = period
        self.braked: list[bool] = []
        self.sent: list[Twist2D] = []

    @property
    def gap(self) -> float:
        """Between the footprint and the nearest point [m]."""
        return float(np.hypot(*(self.points - self.pose.position).T).min(initial=np.inf)) - RADIUS

    def scan(self) -> LaserScan | None:
        if self.period < 0.1 and self.tick % 2:
            return None
        rng, deviation = self.noise
        seen = self.pose.to_body(self.points)
        away = seen / np.maximum(np.hypot(*seen.T), 1e-9)[:, None]
        seen = seen + rng.normal(0.0, deviation, (len(seen), 1)) * away
        return scan_at(*map(tuple, seen.tolist()), time=self.tick * self.period)

    def drive(self, command: Twist2D, *, protected: bool = True) -> None:
        """Move on for a control period, measuring the nearest gap at each step of the physics."""
        if protected:
            command, braked = self.stop.limit(command, self.scan(), self.twist, self.tick * self.period)
            self.braked.append(braked)
            self.sent.append(command)
        for _ in range(round(self.period / PHYSICS)):
            x, y = command.vx - self.twist.vx, command.vy - self.twist.vy
            part = min(1.0, PHYSICS / max(math.hypot(x, y), 1e-12))
            turn = min(max(command.omega - self.twist.omega, -3.0 * PHYSICS), 3.0 * PHYSICS)
            self.twist = Twist2D(self.twist.vx + part * x, self.twist.vy + part * y, self.twist.omega + turn)
            yaw = self.pose.yaw + self.twist.omega * PHYSICS
            dx, dy = PHYSICS * self.twist.linear_in_world(yaw)
            self.pose = Pose2D(self.pose.x + dx, self.pose.y + dy, yaw)
            self.nearest = min(self.nearest, self.gap)
        self.tick += 1


def wall(y: float, x_from: float = -3.0, x_to: float = 3.0) -> list[tuple[float, float]]:
    return [(float(x), y) for x in np.arange(x_from, x_to, 0.02)]


def brakes_in_time(base: Base) -> bool:
    """Whether a base that only brakes keeps the clearance."""
    alone = Base([tuple(point) for point in base.points.tolist()], base.twist)
    while alone.twist.speed > 0.0 or alone.tick < 3:
        alone.drive(Twist2D(), protected=False)
    return alone.nearest >= CLEARANCE


speeds = st.floats(-1.0, 1.0)
twists = st.builds(Twist2D, speeds, speeds, st.floats(-1.5, 1.5)).filter(lambda twist: twist.speed <= 1.0)
places = st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))


@given(points=st.lists(places, max_size=12), start=twists, commands=st.lists(twists, min_size=1, max_size=6))
@settings(max_examples=150, deadline=None)
def test_a_base_that_can_still_brake_never_touches_a_point_whatever_it_is_told(
    points: list[tuple[float, float]], start: Twist2D, commands: list[Twist2D]
) -> None:
    base = Base(points, start)
    assume(brakes_in_time(base))
    for command in commands:
        for _ in range(12):
            base.drive(command)
    assert base.nearest > 0.0


@given(command=twists, twist=twists)
def test_without_points_the_command_is_unchanged(command: Twist2D, twist: Twist2D) -> None:
    stop = ProtectiveStop()
    assert stop.limit(command, None, twist, 0.0) == (command, False)
    assert stop.limit(command, scan_at(), twist, 0.1) == (command, False)
    assert stop.limit(command, None, twist, 0.15) == (command, False)


def test_points_beyond_the_stopping_distance_change_nothing() -> None:
    # At 1 m/s: 0.15 m before the brakes hold, 0.5 m while they do, and the clearance, beyond the footprint.
    fast = Twist2D(1.0)
    assert ProtectiveStop().limit(fast, scan_at((1.03, 0.0)), fast, 0.0) == (fast, False)
    limited, braked = ProtectiveStop().limit(fast, scan_at((0.97, 0.0)), fast, 0.0)
    assert braked and 0.9 < limited.vx < 1.0


@pytest.mark.parametrize("bearing", [0.0, 0.7, -1.5, 2.3])
@pytest.mark.parametrize("turn", [0.0, 0.8])
def test_towards_a_wall_the_base_stops_at_the_clearance_in_any_direction(bearing: float, turn: float) -> None:
    face = [(2.0, float(y)) for y in np.arange(-1.0, 1.01, 0.02)]
    base = Base([tuple(point) for point in (np.array(face) @ rotation(bearing).T).tolist()])
    for _ in range(160):
        base.drive(Twist2D(*(rotation(base.pose.yaw).T @ [math.cos(bearing), math.sin(bearing)]).tolist(), turn))
    assert base.braked[-1]
    assert CLEARANCE - 0.01 <= base.nearest <= CLEARANCE + 0.05
    assert base.twist.speed < 0.02


@pytest.mark.parametrize(("period", "speed"), [(0.1, 1.0), (0.2, 0.5), (0.5, 0.2)])
def test_a_slower_loop_stops_at_the_clearance_too(period: float, speed: float) -> None:
    base = Base(wall(2.0), period=period)
    for _ in range(round(15.0 / period)):
        base.drive(Twist2D(0.0, speed, 0.0))
    assert base.nearest == pytest.approx(CLEARANCE, abs=0.01)


def test_against_a_wall_it_does_not_creep_in_half_a_minute() -> None:
    base = Base([(0.6, float(y)) for y in np.arange(-0.5, 0.51, 0.02)])
    for _ in range(600):
        base.drive(Twist2D(0.3))
    assert base.nearest > CLEARANCE - 0.005


def test_without_the_protective_stop_the_same_base_runs_into_the_point() -> None:
    base = Base([(2.0, 0.0)])
    for _ in range(60):
        base.drive(Twist2D(1.0), protected=False)
    assert base.nearest < 0.0


def test_braking_takes_the_full_deceleration_and_no_more() -> None:
    base = Base([(0.86, 0.0)], Twist2D(1.0))  # nearer than the reaction time wants, and just far enough
    speeds = []
    while base.twist.speed > 0.1:
        base.drive(Twist2D(1.0))
        speeds.append(base.twist.vx)
    assert np.diff(speeds).min() == pytest.approx(-CONTROL_PERIOD, abs=1e-6)
    assert np.diff([command.vx for command in base.sent]).min() >= -CONTROL_PERIOD - 1e-9
    assert base.nearest > 0.0


def test_along_a_wall_10_cm_away_the_base_keeps_its_speed() -> None:
    base = Base(wall(RADIUS + 0.1, 0.0, 8.0), Twist2D(1.0), noise=0.01)
    for _ in range(80):
        base.drive(Twist2D(1.0))
    assert base.twist.vx == pytest.approx(1.0) and not any(base.braked)


def test_along_a_wall_only_the_part_towards_it_is_taken_away() -> None:
    base = Base(wall(RADIUS + 0.1, 0.0, 8.0), Twist2D(1.0))
    for _ in range(80):
        base.drive(Twist2D(0.8, 0.15))
    assert any(base.braked)
    assert base.twist.vx > 0.6
    assert base.nearest > 0.3 * CLEARANCE


@pytest.mark.parametrize("gap", [0.02, 0.06, 0.1])
@pytest.mark.parametrize("command", [Twist2D(), Twist2D(0.0, 0.0, 1.0), Twist2D(0.0, -0.5), Twist2D(-0.3, -0.5)])
def test_beside_a_wall_standing_turning_and_moving_away_stay_possible(gap: float, command: Twist2D) -> None:
    assert ProtectiveStop().limit(command, scan_at(*wall(RADIUS + gap)), Twist2D(), 0.0) == (command, False)


def test_towards_a_wall_at_the_clearance_nothing_is_possible() -> None:
    limited, braked = ProtectiveStop().limit(Twist2D(0.0, 0.5), scan_at(*wall(RADIUS + 0.049)), Twist2D(), 0.0)
    assert braked and limited.speed < 1e-6


def test_through_a_gap_that_the_planner_allows_it_creeps() -> None:
    half = RADIUS + 0.035
    jambs = [(float(x), side * half) for x in np.arange(0.8, 1.0, 0.02) for side in (-1.0, 1.0)]
    base = Base(jambs, Twist2D())
    for _ in range(300):
        base.drive(Twist2D(0.8))
    assert base.pose.x > 1.5
    assert base.nearest > 0.02


def test_before_somebody_at_the_distance_of_a_hand_over_the_base_arrives_unhindered() -> None:
    legs = [(2.0 - 0.1 * math.cos(turn), side + 0.1 * math.sin(turn)) for side in (-0.1, 0.1) for turn in TURNS]
    base = Base(legs, noise=0.01)
    while base.pose.x < 1.1 - 1e-3:  # 0.9 m between the centres
        base.drive(Twist2D(min(1.0, math.sqrt(2.0 * 0.7 * (1.1 - base.pose.x)))))
    assert not any(base.braked)


TURNS = np.linspace(-1.5, 1.5, 20).tolist()


def test_between_scans_the_points_come_nearer_as_the_robot_moves() -> None:
    stop, fast = ProtectiveStop(), Twist2D(1.0, 0.0, 0.0)
    assert not stop.limit(fast, scan_at((1.04, 0.0)), fast, 0.0)[1]
    assert stop.limit(fast, None, fast, 0.05)[1]


def test_what_a_silent_scanner_saw_holds_for_half_a_second() -> None:
    stop, slow = ProtectiveStop(), Twist2D(0.1)
    assert stop.limit(slow, scan_at((0.36, 0.0)), slow, 0.0)[1]
    assert stop.limit(slow, None, Twist2D(), 0.5)[1]
    assert stop.limit(slow, None, Twist2D(), 0.55) == (slow, False)


@pytest.mark.parametrize("name", ["radius", "max_acceleration", "max_yaw_acceleration", "clearance", "reaction"])
def test_limits_that_are_none_are_refused(name: str) -> None:
    make: Callable[..., ProtectiveStop] = ProtectiveStop
    with pytest.raises(BadInputError, match=rf"protective stop: {name} is 0\.0; it must be a positive number"):
        make(**{name: 0.0})
