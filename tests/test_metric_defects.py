"""Eighteen mistakes met in other programs, each with the figure that is right, worked out by hand.

Each test builds a situation in which a mistaken formula goes wrong, writes that formula down, and asserts ours. Where
we have no such metric, our nearest counterpart is asked.
"""

import math
from collections.abc import Iterable

import numpy as np
import pytest
from ticks import make_world, person, tick

from han_bullet.checks import check_expectations
from han_bullet.costmap.grid import FREE, SOCIAL_MAX, UNKNOWN, Costmap, social_cost
from han_bullet.costmap.layer import Layer
from han_bullet.costmap.overtake import OvertakeLayer
from han_bullet.costmap.personal_still import PersonalStillLayer
from han_bullet.costmap.personal_walking import PersonalWalkingLayer
from han_bullet.costmap.shapes import squared_distance
from han_bullet.episode import Tick
from han_bullet.errors import BadInputError
from han_bullet.messages import Contact, Posture, Scene, Status, TrackedPerson
from han_bullet.metrics import DEFINITIONS, Metrics, Value
from han_bullet.metrics.intrusion import kirbys_gaussian
from han_bullet.metrics.motion import path_irregularity
from han_bullet.sim.contacts import TOUCH
from han_bullet.world_schema import CONTROL_PERIOD, Expectation

TICK = CONTROL_PERIOD


def measure(ticks: Iterable[Tick], *people: str) -> dict[str, Value]:
    metrics = Metrics(make_world(*people))
    for one in ticks:
        metrics.record(one)
    return {metric.name: metric.value for metric in metrics.results()}


def test_01_a_turn_to_the_right_is_no_other_standstill_than_one_to_the_left() -> None:
    def defective(v: float, w: float) -> bool:  # HuNav time_not_moving: the parenthesis
        return abs(v) < 0.01 and bool(abs(w < 0.02))

    def ours(w: float) -> Value:  # drives, then turns on the spot for 10 ticks: 0.5 s either way
        turning = [tick(i, twist=(0.0, 0.0, w)) for i in range(1, 11)]
        return measure([tick(0, twist=(0.5, 0.0, 0.0)), *turning])["stalled_time"]

    assert ours(1.0) == ours(-1.0) == pytest.approx(0.5)
    assert defective(0.0, -1.0) != defective(0.0, 1.0)


def test_02_jerk_is_a_second_difference_and_its_mean_does_not_cancel() -> None:
    def defective(speeds: np.ndarray) -> float:  # HuNav avg_overacceleration: dv / dt / dt
        return float(np.mean(np.abs(np.diff(speeds)) / TICK / TICK))

    def signed(speeds: np.ndarray) -> float:  # one of its versions
        return float(np.mean(np.diff(speeds) / TICK))

    steady = np.array([0.0, 0.05, 0.10, 0.15])  # 1 m/s^2 throughout: no jerk
    values = measure(tick(i, twist=(v, 0.0, 0.0)) for i, v in enumerate(steady))
    assert values["mean_jerk"] == pytest.approx(0.0, abs=1e-9)
    assert defective(steady) == pytest.approx(20.0)
    there_and_back = np.array([0.0, 0.05, 0.0])  # 1 m/s^2, then -1 m/s^2: 1 m/s^2 on average
    values = measure(tick(i, twist=(v, 0.0, 0.0)) for i, v in enumerate(there_and_back))
    assert values["mean_acceleration"] == pytest.approx(1.0)
    assert signed(there_and_back) == 0.0


def test_03_no_metric_is_a_stub_and_definitions_quote_the_limit_that_is_used() -> None:
    def stub() -> float:  # HuNav path_irregularity, path_efficiency, static_obs_collision
        return 0.0

    # Up, down and up again at 45 degrees in steps of 0.1 sqrt(2) m, touching a wall once: turns of 90 degrees to the
    # right and back, both unnecessary, over 3 sqrt(2) m.
    way = [(1.0 + 0.1 * i, 0.1 * (10 - abs(i - 10) if i < 20 else i - 20)) for i in range(31)]
    values = measure(
        tick(i, robot=(*place, 0.0), contacts=[Contact("wall", "wall", 0.0)] if i == 9 else [])
        for i, place in enumerate(way)
    )
    assert values["path_irregularity"] == pytest.approx(math.pi / (3.0 * math.sqrt(2.0))) != stub()
    assert values["contacts_wall"] == 1 != stub()
    # By (9.5, 1.5) it is 2 sqrt(8.5^2 + 1.5^2) = 17.2627 m to the goal instead of 17 m.
    ends = [tick(0, robot=(1.0, 0.0, 0.0)), tick(1, robot=(9.5, 1.5, 0.0))]
    values = measure([*ends, tick(2, robot=(18.0, 0.0, 0.0), status=Status.ARRIVED)])
    assert values["spl"] == pytest.approx(17.0 / 17.2627, abs=1e-5) != stub()

    def documented(gap: float) -> bool:  # HuNav's README
        return gap < 0.01

    def coded(gap: float) -> bool:  # its code
        return gap < 0.02

    assert documented(0.015) != coded(0.015)
    assert TOUCH == 0.0
    assert "<= 0 m" in DEFINITIONS["contacts_person"].text


@pytest.mark.parametrize("turn", [0.0, 1.0, 2.5, -2.0])
@pytest.mark.parametrize(("robot", "walker", "hit"), [(0.5, 0.5, (1, 0)), (0.0, 0.5, (0, 1)), (0.5, 0.0, (1, 0))])
def test_04_who_hit_whom_depends_on_no_axis_and_equal_speeds_count(
    turn: float, robot: float, walker: float, hit: tuple[int, int]
) -> None:
    def defective(x: float, v_robot: float, v_person: float) -> tuple[int, int]:  # HuNav, each seen by the other at x
        alpha, alpha2 = math.atan2(0.0, x), math.atan2(x, 0.0)  # the second has its arguments exchanged
        return int(abs(alpha) < abs(alpha2) and v_robot != v_person), int(
            abs(alpha) > abs(alpha2) and v_robot != v_person
        )

    # Head on: at equal speeds the robot was moving when it touched the person; a robot that stood was walked into.
    someone = person(x=0.5 * math.cos(turn), y=0.5 * math.sin(turn), yaw=turn + math.pi, speed=walker)
    touch = [Contact("walker", "person", -0.01)]
    scene = {"robot": (0.0, 0.0, turn), "twist": (robot, 0.0, 0.0), "people": [someone]}
    values = measure([tick(0, **scene, contacts=touch)], "walker")
    assert (values["contacts_person"], values["contacts_by_person"]) == hit
    assert defective(0.5, 0.5, 0.5) == (0, 0)  # nobody hit anybody
    assert defective(0.5, 0.0, 0.5) == (1, 0)  # the robot that stood still


def test_05_zones_leave_no_gap_and_short_intrusions_are_seen() -> None:
    def sampled(gaps: list[float]) -> float:  # HuNav records once a second: every 20th tick
        return float(np.mean([gap < 0.45 for gap in gaps[::20]]))

    def band(gaps: list[float]) -> float:  # its personal space: the band without the intimate one
        return float(np.mean([0.45 <= gap < 1.2 for gap in gaps]))

    # 3 s; for 0.4 s of them, ticks 25 to 32, at 0.3 m.
    gaps = [0.3 if 25 <= i <= 32 else 5.0 for i in range(60)]
    values = measure((tick(i, people=[person(x=gap + 0.55)]) for i, gap in enumerate(gaps)), "walker")
    assert values["intimate_zone_share"] == pytest.approx(8.0 / 60.0)
    assert sampled(gaps) == 0.0
    # At 0.3 m one is in somebody's personal space, too: ours is told by g, 1 at the person, not by a band around them.
    inside = measure([tick(0, people=[person(x=0.3)])], "walker")
    assert inside["personal_space_share"] == 1.0
    assert band([0.0]) == 0.0


def test_06_the_intrusion_depends_on_the_persons_speed_not_on_where_the_origin_is() -> None:
    def defective(x: float, y: float) -> float:  # SocNavBench asym_gauss_from_vel: the speed of the point
        return max(2.0 * math.hypot(x, y), 0.5)

    # At 0.3 m/s sigma_h is 0.6 m: exp(-1/2) at 0.6 m ahead, wherever the two are.
    depths = [
        kirbys_gaussian(person(x=x, y=y, speed=0.3), np.array([x + 0.6, y])) for x, y in ((0, 0), (10, 0), (-4, 7))
    ]
    assert depths == pytest.approx([math.exp(-0.5)] * 3)
    assert defective(10.0, 0.0) == 20.0 != pytest.approx(0.6)


def test_07_beside_and_behind_the_deviations_are_kirbys() -> None:
    def defective(u: float, v: float, sigma: float) -> float:  # SocNavBench asym_gauss: sigma / 4 and sigma / 3
        return math.exp(-0.5 * (u / (sigma if u > 0 else sigma / 3.0)) ** 2 - 0.5 * (v / (sigma / 4.0)) ** 2)

    # Standing: sigma_h 0.5, sigma_s 1/3, sigma_r 1/4.
    beside, behind = (
        kirbys_gaussian(person(), np.array([0.0, 1.0 / 3.0])),
        kirbys_gaussian(person(), np.array([-0.25, 0])),
    )
    assert (beside, behind) == (pytest.approx(math.exp(-0.5)), pytest.approx(math.exp(-0.5)))
    assert defective(0.0, 1.0 / 3.0, 0.5) == pytest.approx(math.exp(-0.5 * (8.0 / 3.0) ** 2))
    assert defective(-0.25, 0.0, 0.5) == pytest.approx(math.exp(-0.5 * 1.5**2))


def test_08_irregularity_depends_on_no_origin_and_is_per_metre() -> None:
    def defective(way: np.ndarray, goal: np.ndarray) -> float:  # SocNavBench: angles of position and goal vectors
        return float(np.mean([abs(math.atan2(y, x) - math.atan2(goal[1], goal[0])) for x, y in way]))

    def unscaled(way: np.ndarray) -> float:  # robot_sf: mean deviation of the heading, labelled rad/m
        steps = np.diff(way, axis=0)
        return float(np.mean(np.abs(np.arctan2(steps[:, 1], steps[:, 0]))))

    # Out and back in at 45 degrees, every 0.2 m along x: turns of 90 degrees in all are needed by none but the end.
    way = np.array([[0.2 * i, abs(0.2 * (i % 20 - 10))] for i in range(41)])
    shifted, goal = way + np.array([3.0, 5.0]), way[-1] + np.array([3.0, 5.0])
    # Down, up, down, up: three turns of 90 degrees, of which 90 are the end's; 40 chords of 0.2 sqrt(2) m.
    expected = (3.0 - 1.0) * 0.5 * math.pi / (40 * 0.2 * math.sqrt(2.0))
    assert path_irregularity(way) == pytest.approx(expected)
    assert path_irregularity(shifted) == pytest.approx(expected)
    assert defective(shifted, goal) != pytest.approx(defective(way[1:], way[-1]), rel=0.05)
    assert path_irregularity(2.0 * way) == pytest.approx(0.5 * expected)  # the same turns over twice the length
    assert unscaled(2.0 * way) == pytest.approx(unscaled(way))


def test_09_every_metric_exists_an_unknown_one_is_refused_and_no_length_is_no_division() -> None:
    def defective(length: float, displacement: float) -> float:  # SocNavBench path_length_ratio: inverse, epsilon
        return (length + 1e-9) / displacement

    names = {name.split(".")[0] for name in measure([tick(0)], "walker")}
    absent = {name for name in DEFINITIONS if name not in names}  # nobody sits or takes things here
    assert absent == {name for name in DEFINITIONS if name.startswith(("hand_over", "behind", "transit", "replan_"))}
    with pytest.raises(BadInputError, match="'personal_space_cost' is no metric"):
        check_expectations([Expectation(metric="personal_space_cost", at_most=1)], Metrics(make_world()).results())
    # There and back again: 51 m for a way of 17 m.
    places = (1.0, 18.0, 1.0, 18.0)
    ticks = [
        tick(i, robot=(x, 0.0, 0.0), status=Status.ARRIVED if i == 3 else Status.MOVING) for i, x in enumerate(places)
    ]
    assert measure(ticks)["spl"] == pytest.approx(1.0 / 3.0)
    assert defective(51.0, 17.0) == pytest.approx(3.0)
    assert measure([tick(0, robot=(18.0, 0.0, 0.0), status=Status.ARRIVED)])["spl"] == 1.0
    with pytest.raises(ZeroDivisionError):
        defective(0.0, 0.0)


def test_10_a_short_bad_episode_is_bad() -> None:
    def defective(steps_inside: int) -> float:  # iGibson psc: over the most steps there may be
        return 1.0 - steps_inside / 500.0

    ticks = [tick(i, people=[person(x=0.4)]) for i in range(10)]
    assert measure(ticks, "walker")["personal_space_share"] == 1.0
    assert defective(10) == pytest.approx(0.98)


def test_11_yaw_is_no_length_time_is_divided_by_turns_wrap_and_one_collision_fails() -> None:
    def defective_length(poses: np.ndarray) -> float:  # arena-evaluation: the norm of (x, y, yaw)
        return float(np.linalg.norm(np.diff(poses, axis=0), axis=1).sum())

    def defective_acceleration(speeds: np.ndarray) -> float:
        return float(np.abs(np.diff(speeds)).max())

    def defective_turn(before: float, after: float) -> float:
        return abs(after - before)

    def defective_success(collisions: int) -> bool:
        return collisions < 3

    poses = np.array([[0.0, 0.0, 3.1], [0.0, 0.0, -3.1]])  # on the spot, through pi: 2 pi - 6.2 rad
    ticks = [tick(i, robot=pose, twist=(0.05 * i, 0.0, 0.0)) for i, pose in enumerate(poses)]
    values = measure([*ticks, tick(2, robot=poses[1], contacts=[Contact("w", "wall", 0.0)], status=Status.ARRIVED)])
    assert (values["path_length"], defective_length(poses)) == (0.0, pytest.approx(6.2))
    assert values["cumulative_heading_change"] == pytest.approx(2.0 * math.pi - 6.2)
    assert defective_turn(3.1, -3.1) == pytest.approx(6.2)
    assert measure(ticks)["max_acceleration"] == pytest.approx(1.0)
    assert defective_acceleration(np.array([0.0, 0.05])) == pytest.approx(0.05)
    assert (values["success"], defective_success(1)) == (False, True)


def test_12_jerk_has_its_time_and_all_samples_and_a_miss_is_no_collision() -> None:
    def defective_jerk(accelerations: np.ndarray) -> float:  # robot_sf jerk_mean: no dt, a sample dropped
        return float(np.abs(np.diff(accelerations))[:-1].mean())

    def defective_time(offset: np.ndarray, relative: np.ndarray) -> float:  # its TTC: centres, along the line
        return float(np.hypot(*offset) / np.hypot(*relative))

    # Accelerations 0, 1 and 3 m/s^2: changes of 1 and 2 m/s^2 in 0.05 s each, 30 m/s^3 on average.
    speeds = [0.0, 0.0, 0.05, 0.20]
    values = measure(tick(i, twist=(v, 0.0, 0.0)) for i, v in enumerate(speeds))
    assert values["mean_jerk"] == pytest.approx(30.0)
    assert defective_jerk(np.array([0.0, 1.0, 3.0])) == pytest.approx(1.0)
    ahead = measure([tick(0, twist=(1.0, 0.0, 0.0), people=[person(x=3.0)])], "walker")
    aside = measure([tick(0, twist=(1.0, 0.0, 0.0), people=[person(x=3.0, y=1.0)])], "walker")
    assert ahead["minimum_time_to_collision"] == pytest.approx(3.0 - 0.55)
    assert aside["minimum_time_to_collision"] is None
    assert defective_time(np.array([3.0, 0.0]), np.array([-1.0, 0.0])) == pytest.approx(3.0)
    assert math.isfinite(defective_time(np.array([3.0, 1.0]), np.array([-1.0, 0.0])))


def test_13_a_holonomic_base_that_moves_sideways_moves() -> None:
    def defective(vx: float, vy: float) -> bool:  # SRPB: vx twice
        return math.hypot(vx, vx) < 0.05

    values = measure(tick(i, robot=(0.0, 0.025 * i, 0.0), twist=(0.0, 0.5, 0.0)) for i in range(10))
    assert (values["stalled_time"], values["mean_speed"]) == (0.0, pytest.approx(0.5))
    assert defective(0.0, 0.5)


def test_14_every_band_of_distances_is_reached() -> None:
    def defective(d: float) -> str:  # social_nav_utils passing speed: FAR should stand where CLOSE does
        return "close" if d <= 0.6 else "far" if d >= 0.6 else "mixed"

    distances = np.linspace(0.0, 6.0, 601)
    assert {defective(d) for d in distances} == {"close", "far"}
    ticks = [tick(i, people=[person(x=d)]) for i, d in enumerate(distances)]
    values = measure(ticks, "walker")
    # Between the surfaces: centres less 0.55 m. The steps are of 0.01 m, so counts are the bands' widths, to a step.
    shares = [values[f"{zone}_zone_share"] for zone in ("intimate", "personal", "social", "public")]
    assert shares == pytest.approx([1.0 / 6.0, 0.75 / 6.0, 2.4 / 6.0, 1.85 / 6.0], abs=0.003)


ROOM = [((-4.0, 4.0), (-4.0, 4.0))]


def walker(x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> TrackedPerson:
    velocity = 0.8 * np.array([math.cos(yaw), math.sin(yaw)])
    return TrackedPerson(0, 0.0, np.array([x, y]), velocity, 0.0025 * np.eye(4), Posture.WALKING, yaw)


def applied(layer: Layer, costmap: Costmap, *people: TrackedPerson) -> Costmap:
    layer.apply(costmap, Scene(0.0, people))
    return costmap


def test_15_the_overtaking_lobe_lies_exactly_across_the_walk_in_every_direction() -> None:
    def defective(x: float, y: float) -> float:  # SNL PassingLayer: the negated velocity, turned by +1.51
        c, s = math.cos(math.pi + 1.51), math.sin(math.pi + 1.51)
        return math.exp(-0.5 * squared_distance(c * x + s * y, c * y - s * x, 1.5, 0.3, 0.0075))

    def bounds(vx: float, vy: float) -> float:  # its reach: velocity.x of one, velocity.y of the other estimate
        return math.hypot(vx, 0.0)

    # 1.225 m to the right of somebody who walks along x, 0.275 m before and behind: the same cost.
    right = applied(OvertakeLayer(), Costmap.covering(ROOM, 0.05), walker())
    before, behind = right.cost_at(np.array([[0.275, -1.225], [-0.275, -1.225]]))
    expected = SOCIAL_MAX * math.exp(-0.5 * ((1.225 / 1.5) ** 2 + (0.275 / 0.3) ** 2))
    assert before == behind == pytest.approx(expected, abs=0.5)
    assert defective(0.275, -1.225) < 0.9 * defective(-0.275, -1.225)
    # Along y the same lobe, no part of it cut off; right of a walk along y is +x.
    up = applied(OvertakeLayer(), Costmap.covering(ROOM, 0.05), walker(yaw=0.5 * math.pi))
    assert up.cost_at(np.array([1.225, 0.275])) == before
    assert bounds(0.0, 0.8) == 0.0


def test_16_a_person_who_moved_or_vanished_leaves_no_cost_behind() -> None:
    free = Costmap.covering(ROOM, 0.05)

    def defective(costmap: Costmap, layer: Layer, *people: TrackedPerson) -> Costmap:  # the last bounds not cleared
        return applied(layer, costmap, *people)

    def ours(layer: Layer, *people: TrackedPerson) -> Costmap:  # as the stack does at every tick
        return applied(layer, free.copy(), *people)

    layer, place = OvertakeLayer(), np.array([-2.025, -1.025])
    assert ours(layer, walker(-2.0, 0.0)).cost_at(place) > 100  # on the right: the robot passes on the left
    assert ours(layer, walker(-2.0, 0.0)).cost_at(place * [1.0, -1.0]) == FREE
    assert ours(layer, walker(3.0, 2.0)).cost_at(place) == FREE
    assert (ours(layer).cost == FREE).all()
    kept = defective(free.copy(), layer, walker(-2.0, 0.0))
    assert defective(kept, layer, walker(3.0, 2.0)).cost_at(place) > 100


@pytest.mark.parametrize(
    "layer", [PersonalStillLayer(), PersonalWalkingLayer(), OvertakeLayer()], ids=lambda one: one.name
)
def test_17_no_social_cost_blocks_nor_means_unknown(layer: Layer) -> None:
    def defective(g: float) -> int:  # the nav2 plugin's amplitude
        return int(255.0 * g)

    someone = walker(0.025, 0.025)
    standing = TrackedPerson(0, 0.0, someone.position_in_world, np.zeros(2), someone.covariance, Posture.STANDING, None)
    costs = applied(layer, Costmap.covering(ROOM, 0.05), standing if layer.name == "personal_still" else someone).cost
    assert costs.max() == SOCIAL_MAX == int(social_cost(np.array(1.0))) == 252
    assert defective(1.0) == UNKNOWN


def test_18_the_first_heading_is_no_turn_all_steps_count_and_a_failure_has_no_time() -> None:
    def defective_turns(yaws: list[float]) -> float:  # navmet chc: begins at 0
        return float(np.abs(np.diff([0.0, *yaws])).sum())

    def defective_distance(distances: list[float]) -> float:  # CrowdNav: among the steps with danger only
        return min((d for d in distances if d < 0.2), default=math.inf)

    def defective_time(times: list[float | None]) -> float:  # CrowdNav: the mean over successes
        return float(np.mean([time for time in times if time is not None]))

    ticks = [tick(i, robot=(0.0, 0.0, 2.0), people=[person(x=d)]) for i, d in enumerate((3.0, 2.5, 2.8))]
    values = measure([*ticks, tick(3, robot=(0.0, 0.0, 2.0), status=Status.BLOCKED)], "walker")
    assert values["cumulative_heading_change"] == 0.0
    assert defective_turns([2.0] * 4) == 2.0
    assert values["minimum_distance.walker"] == 2.5
    assert defective_distance([3.0, 2.5, 2.8]) == math.inf
    # One run of 10 s that arrives and one that does not: no figure hides the second; it has none, and no success.
    assert (values["time_to_goal"], values["success"]) == (None, False)
    assert defective_time([10.0, None]) == 10.0
