"""Takes: short scenes in our building, drawn at random, in which one camera runs while people and robot move."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from han_bullet.geometry import Pose2D, Twist2D, wrap_angle
from han_bullet.variation import vary
from han_bullet.world_file import load_world
from han_bullet.world_schema import CeilingCamera, OnboardCamera, Person, Sit, Stand, Walk, World

BUILDING = "real2"
CORRIDOR_CAMERAS = ("camera1", "camera2", "camera3")
COUCH_CAMERA, COUCH = "camera4", "couch"
RATE = 5.0  # [Hz]; slower than the cameras of an episode, so that a thousand frames show more of what can happen
LANES = (-1.0, -0.5, 0.0, 0.5, 1.0)  # [m] across the corridor; bodies in neighbouring ones do not touch
ROBOT_LANES = (-1.0, 0.0, 1.0)  # [m]
LANE_FOR_ROBOT = 0.8  # [m]; people walk in lanes at least this far from the robot's
AHEAD_OF_CEILING_CAMERA = (3.0, 10.0)  # [m] along its view, where people start: whole from 3.3 m, 110 px high to 9 m
AHEAD_OF_ROBOT = (2.0, 8.0)  # [m]
WALKERS = 0.6  # share of people who walk; the others stand
CROSSING = 0.6  # share of takes, of those with room for it, in which people cross the corridor: seen from the side
WALKING_SPEED = (0.35, 1.3)  # [m/s]
WALKED = 3.0  # [m] to either side of the start along the corridor
CORRIDOR_END, BUILDING_END = 0.6, 22.4  # [m] along x: as far as people walk
ROBOT_SPEED = 0.4  # [m/s]
ROBOT_SWAY = (0.25, 0.8)  # [rad], [rad/s]: its heading swings, as when it keeps to a path round people
ROBOT_TURN_GAIN, ROBOT_LANE_GAIN = 2.0, 0.5  # [1/s]

Point = tuple[float, float]


@dataclass(frozen=True)
class Take:
    """One scene before one camera.

    Attributes:
        world: Concrete, with this camera alone.
        seed: Of the image noise.
        robot_lane: Along which the robot drives: a point in it and its direction.
    """

    world: World
    seed: int
    robot_lane: Pose2D

    @property
    def camera(self) -> CeilingCamera | OnboardCamera:
        """Return the camera."""
        return self.world.cameras[0]

    def command(self, pose_robot_in_world: Pose2D, time: float) -> Twist2D:
        """Return the twist in the body frame that keeps the robot in its lane, its heading swinging, at a time [s]."""
        swing, rate = ROBOT_SWAY
        here, lane = pose_robot_in_world, self.robot_lane
        turn = wrap_angle(lane.yaw + swing * math.sin(rate * time) - here.yaw)
        aside = float(lane.to_body(here.position)[1])
        along, across = Pose2D(0.0, 0.0, here.yaw - lane.yaw).to_body(np.array([ROBOT_SPEED, -ROBOT_LANE_GAIN * aside]))
        return Twist2D(float(along), float(across), ROBOT_TURN_GAIN * turn)


def corridor_takes(seed: int) -> Iterator[Take]:
    """Yield takes of people in the corridor, by its ceiling cameras in turn, without end."""
    building = load_world(BUILDING)
    for number, name in zip(itertools.count(), itertools.cycle(CORRIDOR_CAMERAS)):
        rng = np.random.default_rng([seed, 0, number])
        camera = building.camera(name)
        assert isinstance(camera, CeilingCamera)
        start = float(camera.position[0])
        view = Pose2D(start, 0.0, 0.0 if camera.look_at[0] > start else math.pi)
        robot = _robot_lane(float(rng.uniform(2.0, 10.0)), rng)
        people = _people(view, AHEAD_OF_CEILING_CAMERA, robot.y, rng)
        yield _take(building, camera, people, robot, rng)


def onboard_takes(seed: int) -> Iterator[Take]:
    """Yield takes of people in the corridor by the camera of the driving robot, without end."""
    building = load_world(BUILDING)
    for number in itertools.count():
        rng = np.random.default_rng([seed, 1, number])
        robot = _robot_lane(float(rng.uniform(1.0, 15.0)), rng)
        people = _people(Pose2D(robot.x, 0.0, robot.yaw), AHEAD_OF_ROBOT, robot.y, rng)
        yield _take(building, building.camera("onboard"), people, robot, rng)


def couch_takes(seed: int) -> Iterator[Take]:
    """Yield takes of a person on the couch by the camera above the television, without end."""
    building = load_world(BUILDING)
    person = Person(name="viewer", start=(0.0, 0.0, 0.0), behaviour=Sit(on=COUCH))
    for number in itertools.count():
        rng = np.random.default_rng([seed, 2, number])
        yield _take(building, building.camera(COUCH_CAMERA), [person], Pose2D(2.0, 0.0, 0.0), rng)


def _take(
    building: World,
    camera: CeilingCamera | OnboardCamera,
    people: list[Person],
    robot: Pose2D,
    rng: np.random.Generator,
) -> Take:
    """Let a seed draw light, noise, clothes, builds and small changes of place and speed, as in an episode."""
    world = building.model_copy(
        update={
            "cameras": (camera.model_copy(update={"rate": RATE}),),
            "people": tuple(people),
            "robot": building.robot.model_copy(update={"start": (robot.x, robot.y, robot.yaw)}),
        }
    )
    seed = int(rng.integers(2**31))
    return Take(vary(world, seed), seed, robot)


def _robot_lane(x: float, rng: np.random.Generator) -> Pose2D:
    """Draw where the robot drives, towards the corridor's farther end."""
    return Pose2D(x, float(rng.choice(ROBOT_LANES)), 0.0 if x < 0.5 * (CORRIDOR_END + BUILDING_END) else math.pi)


def _people(view: Pose2D, ahead: tuple[float, float], robot_lane: float, rng: np.random.Generator) -> list[Person]:
    """Draw people in the lanes that the robot leaves free, within a distance [m] before a camera.

    Either each has a lane of their own, or they share the lanes and cross them, each at a distance of their own.
    """
    lanes = [lane for lane in LANES if abs(lane - robot_lane) >= LANE_FOR_ROBOT]
    away = math.cos(view.yaw)
    if robot_lane != 0.0 and rng.uniform() < CROSSING:
        edges = np.linspace(*ahead, len(lanes) + 1)
        places = [_inside(view.x + away * float(rng.uniform(*pair))) for pair in itertools.pairwise(edges)]
        ways = [((x, float(rng.choice(lanes))), [(x, lanes[0]), (x, lanes[-1])]) for x in places]
    else:
        starts = [(_inside(view.x + away * float(rng.uniform(*ahead))), lane) for lane in lanes]
        ways = [((x, y), [(_inside(x - WALKED), y), (_inside(x + WALKED), y)]) for x, y in starts]
    return [_person(f"person{number}", start, ends, rng) for number, (start, ends) in enumerate(ways)]


def _person(name: str, start: Point, ends: list[Point], rng: np.random.Generator) -> Person:
    """Draw whether a person stands, facing anywhere, or walks to and fro between two ends, and how fast."""
    yaw, speed = float(rng.uniform(-math.pi, math.pi)), float(rng.uniform(*WALKING_SPEED))
    order = 1 if rng.uniform() < 0.5 else -1
    if rng.uniform() >= WALKERS:
        return Person(name=name, start=(*start, yaw), behaviour=Stand())
    waypoints = tuple(ends[::order] * 2)
    first = next(point for point in waypoints if point != start)
    yaw = math.atan2(first[1] - start[1], first[0] - start[0])
    return Person(name=name, start=(*start, yaw), behaviour=Walk(waypoints=waypoints, speed=speed))


def _inside(x: float) -> float:
    return min(max(x, CORRIDOR_END), BUILDING_END)
