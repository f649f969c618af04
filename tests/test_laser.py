"""The laser scanner: walls, furniture and legs where they are, noise as said, and nothing else changed."""

import itertools
import math
from typing import Any

import numpy as np
import pytest

from han_bullet.geometry import Array, Pose2D, Twist2D
from han_bullet.messages import LaserScan
from han_bullet.mirroring import mirrored
from han_bullet.sim.legs import SHIN_RADIUS, leg_bones
from han_bullet.sim.simulator import Simulator
from han_bullet.sim.skeleton import skeleton_of
from han_bullet.world_file import load_world, parse_world
from han_bullet.world_schema import Laser, World

HALF = 2.0  # [m]; half the inner width of the room
EXACT = {"noise": 0.0}
FORWARD = Twist2D(0.6, 0.0, 0.0)


def room(
    *, laser: dict[str, Any] | None = EXACT, start: tuple[float, float, float] = (0.0, 0.0, 0.0), **parts: Any
) -> World:
    """A square room: walls 2 m from the origin, too low for doors; the scanner is over the robot's centre."""
    out = HALF + 0.05
    corners = [(-out, -out), (out, -out), (out, out), (-out, out), (-out, -out)]
    settings = None if laser is None else {"forward": 0.0, **laser}
    return parse_world(
        {
            "name": "room",
            "description": "A square room",
            "floor": [{"x": [-HALF, HALF], "y": [-HALF, HALF]}],
            "walls": [{"start": a, "end": b, "height": 2.0} for a, b in itertools.pairwise(corners)],
            "robot": {"start": start, "laser": settings},
            "task": {"kind": "go_to", "pose": [1.0, 0.0, 0.0]},
            **parts,
        }
    )


def first_scan(world: World, seed: int = 0) -> LaserScan:
    with Simulator(world, renderer=None, seed=seed) as simulator:
        scan = simulator.reset().laser
    assert scan is not None
    return scan


def directions(scan: LaserScan) -> Array:
    return scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))


def points(scan: LaserScan, pose: Pose2D) -> Array:
    """What was hit, in the world, shape (n, 2) [m]."""
    angles = directions(scan)
    hit = np.isfinite(scan.ranges)
    in_scanner = (scan.ranges[:, None] * np.column_stack([np.cos(angles), np.sin(angles)]))[hit]
    return pose.to_world(scan.scanner_in_body.to_world(in_scanner))


def test_the_walls_of_a_room_are_as_far_as_they_are() -> None:
    scan = first_scan(room())
    angles = directions(scan)
    assert len(angles) == 541
    assert (angles[0], angles[270], angles[-1]) == pytest.approx((-0.75 * math.pi, 0.0, 0.75 * math.pi))
    expected = HALF / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
    assert scan.ranges == pytest.approx(expected, abs=1e-6)
    assert (scan.time, scan.range_max, scan.scanner_in_body) == (0.0, 8.0, Pose2D(0.0, 0.0, 0.0))


def test_the_scan_is_in_the_scanners_frame_whichever_way_the_robot_faces() -> None:
    start = (0.5, -0.7, 2.1)
    world = room(laser={"noise": 0.0, "forward": 0.2}, start=start)
    scan = first_scan(world)
    assert scan.scanner_in_body == Pose2D(0.2, 0.0, 0.0)
    hits = points(scan, Pose2D(*start))
    assert len(hits) == 541
    assert np.abs(hits).max(axis=1) == pytest.approx(np.full(541, HALF), abs=1e-6)


def test_beyond_its_range_a_laser_sees_nothing() -> None:
    scan = first_scan(room(laser={"noise": 0.0, "range_max": 2.1}))
    seen = np.isfinite(scan.ranges)
    expected = HALF / np.maximum(np.abs(np.cos(directions(scan))), np.abs(np.sin(directions(scan))))
    assert np.array_equal(seen, expected <= 2.1)
    assert scan.ranges[seen].max() <= 2.1
    assert np.isposinf(scan.ranges[~seen]).all()


@pytest.mark.parametrize(("bottom", "size", "seen"), [(0.0, 0.8, True), (0.3, 0.5, False), (0.0, 0.2, False)])
def test_only_furniture_at_the_beams_height_is_seen(bottom: float, size: float, seen: bool) -> None:
    box = {"name": "box", "position": [1.0, 0.0], "size": [0.4, 0.4, size], "bottom": bottom}
    ahead = first_scan(room(furniture=[box])).ranges[270]
    assert ahead == pytest.approx(0.8 if seen else HALF, abs=1e-6)


def test_the_noise_has_its_deviation_and_is_the_seeds() -> None:
    exact, noisy = first_scan(room()).ranges, first_scan(room(laser={"noise": 0.01}), seed=1).ranges
    assert (noisy - exact).std() == pytest.approx(0.01, rel=0.1)
    assert abs((noisy - exact).mean()) < 0.002
    assert np.array_equal(first_scan(room(laser={"noise": 0.01}), seed=1).ranges, noisy)
    assert not np.array_equal(first_scan(room(laser={"noise": 0.01}), seed=2).ranges, noisy)


def test_noise_takes_no_range_below_the_least() -> None:
    box = {"name": "box", "position": [0.56, 0.0], "size": [1.0, 0.1, 0.8]}
    scan = first_scan(room(laser={"noise": 0.03}, furniture=[box]))
    assert scan.ranges.min() == scan.range_min == 0.05


def test_scans_come_at_the_lasers_rate_and_a_reset_repeats_them() -> None:
    def scans(simulator: Simulator) -> list[LaserScan | None]:
        return [simulator.reset().laser, *(simulator.step(FORWARD).laser for _ in range(8))]

    with Simulator(room(laser={"rate": 5.0}), renderer=None, seed=3) as simulator:
        first, again = scans(simulator), scans(simulator)
    assert [scan is not None for scan in first] == [tick % 4 == 0 for tick in range(9)]
    for one, other in zip(first, again, strict=True):
        if one is not None and other is not None:
            assert one.time == other.time
            assert np.array_equal(one.ranges, other.ranges)


def test_a_robot_without_a_laser_gets_no_scan() -> None:
    with Simulator(room(laser=None), renderer=None) as simulator:
        assert simulator.reset().laser is None
        assert simulator.step(FORWARD).laser is None


def legs_seen(scan: LaserScan, pose: Pose2D, around: Pose2D) -> Array:
    """Hits within 0.7 m of a person, shape (n, 2) [m]."""
    hits = points(scan, pose)
    return hits[np.hypot(*(hits - around.position).T) < 0.7]


def shins_at(build: str, body_pose: Any, height: float) -> Array:
    """Where both shins' axes pass through a height, shape (2, 2) [m]."""
    shins = leg_bones(skeleton_of(build), body_pose)[1::2]
    shares = [(shin.upper[2] - height) / (shin.upper[2] - shin.lower[2]) for shin in shins]
    return np.array([(shin.upper + k * (shin.lower - shin.upper))[:2] for k, shin in zip(shares, shins, strict=True)])


def test_somebody_who_stands_shows_two_legs_and_no_cylinder() -> None:
    person = {"name": "someone", "start": [1.2, 0.0, math.pi]}
    with Simulator(room(people=[person]), renderer=None) as simulator:
        scan = simulator.reset().laser
        shins = shins_at("slim", simulator.render_state.people[0], 0.25)
    assert scan is not None
    hits = legs_seen(scan, Pose2D(0.0, 0.0, 0.0), Pose2D(1.2, 0.0, math.pi))
    distances = np.hypot(*(hits[:, None] - shins).transpose(2, 0, 1))
    assert distances.min(axis=1) == pytest.approx(np.full(len(hits), SHIN_RADIUS), abs=0.005)
    nearest = distances.argmin(axis=1)
    assert min(np.bincount(nearest, minlength=2)) >= 5
    assert scan.ranges[270] == pytest.approx(HALF, abs=1e-6), "the ray between the legs meets something"


def test_the_legs_of_somebody_who_walks_pass_one_another() -> None:
    walk = {"kind": "walk", "waypoints": [[1.6, 1.2]], "speed": 1.0}
    person = {"name": "someone", "start": [-1.6, 1.2, 0.0], "behaviour": walk}
    ahead = []
    with Simulator(room(people=[person], laser={"noise": 0.0, "field_of_view": 360.0}), renderer=None) as simulator:
        observation = simulator.reset()
        for _ in range(50):
            state = simulator.render_state
            if observation.laser is not None:
                shins = shins_at("slim", state.people[0], 0.25)
                hits = legs_seen(observation.laser, state.robot.pose_in_world, state.people[0].pose_in_world)
                hits = hits[np.abs(hits).max(axis=1) < HALF - 1e-3]
                distances = np.hypot(*(hits[:, None] - shins).transpose(2, 0, 1))
                # A slanting shin's cut is longer than it is wide.
                assert len(hits) > 5
                assert distances.min(axis=1).max() < 1.5 * SHIN_RADIUS
                ahead.append(shins[0, 0] - shins[1, 0])
            observation = simulator.step(Twist2D())
    assert max(ahead) > 0.3
    assert min(ahead) < -0.3


def test_somebody_seated_shows_shins_before_the_couch() -> None:
    world = load_world("sim2")
    viewer = next(person for person in world.people if person.name == "viewer")
    robot = world.robot.model_copy(
        update={"start": (19.5, -2.4, 0.5 * math.pi), "laser": Laser(noise=0.0, forward=0.0)}
    )
    scan = first_scan(world.model_copy(update={"robot": robot, "people": (viewer,)}))
    couch = first_scan(world.model_copy(update={"robot": robot, "people": ()})).ranges[150:391]
    assert couch.min() == pytest.approx(2.4 - 0.8, abs=1e-3), "the couch's front is not at y = -0.8"
    before = couch - scan.ranges[150:391]
    right, between, left = before[:117], before[117:124], before[124:]  # the ray straight ahead is number 120
    for shin in (left, right):
        assert 0.04 < shin.max() < 0.12
        assert np.count_nonzero(shin > 1e-6) >= 5
    assert np.abs(between).max() < 1e-6, "nothing is between the shins"


@pytest.mark.parametrize("name", ["real4", "sim2"])
def test_a_mirrored_worlds_scan_is_the_mirror_image(name: str) -> None:
    world = load_world(name)
    robot = world.robot.model_copy(update={"start": (15.0, -0.3, 0.2), "laser": Laser(noise=0.0)})
    world = world.model_copy(update={"robot": robot, "people": ()})
    scan, image = first_scan(world), first_scan(mirrored(world))
    finite = np.isfinite(scan.ranges)
    assert 100 < np.count_nonzero(finite) < 541
    assert np.array_equal(finite[::-1], np.isfinite(image.ranges))
    assert image.ranges[::-1][finite] == pytest.approx(scan.ranges[finite], abs=1e-6)
    assert not np.allclose(image.ranges, scan.ranges), "the scan is its own mirror image"


def test_the_laser_changes_nothing_that_happens() -> None:
    def happens(laser: Laser | None) -> list[Any]:
        world = load_world("real2")
        robot = world.robot.model_copy(update={"laser": laser, "start": (3.6, -0.2, 0.0)})
        with Simulator(world.model_copy(update={"robot": robot}), renderer=None) as simulator:
            simulator.reset()
            truths = []
            for _ in range(60):
                simulator.step(Twist2D(1.0, 0.05, 0.1))
                truths.append(simulator.truth)
            return truths

    without = happens(None)
    assert any(truth.contacts for truth in without), "the robot touches nobody"
    assert [repr(truth) for truth in happens(Laser())] == [repr(truth) for truth in without]
