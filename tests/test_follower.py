"""The follower alone, and layers, planner and follower together on a point robot: the paper's corridor."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pytest

from han_bullet.control.follower import Follower
from han_bullet.control.proximity import ProximityLimit
from han_bullet.control.recovery import Recovery
from han_bullet.control.way import Way
from han_bullet.costmap.grid import LETHAL, Costmap
from han_bullet.costmap.layer import Layer
from han_bullet.costmap.layers import standard_layers
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Pose2D, SolidBox, Twist2D, rotation
from han_bullet.messages import Device, HandOver, Path, PoseEstimate, Posture, Scene, Seat, Status, Task, TrackedPerson
from han_bullet.planning.astar import astar
from han_bullet.planning.planner import Planner

PERIOD = 0.05
CORRIDOR = Costmap.covering([((0.0, 16.0), (-1.5, 1.5))], 0.05)


def moved(pose: Pose2D, twist: Twist2D) -> Pose2D:
    """Pose after one period of a twist, on an arc."""
    step = PERIOD * twist.linear_in_world(pose.yaw + 0.5 * PERIOD * twist.omega)
    return Pose2D(float(pose.x + step[0]), float(pose.y + step[1]), pose.yaw + PERIOD * twist.omega)


def track(at: Sequence[float], velocity: Sequence[float] = (0.0, 0.0), posture: Posture | None = None) -> TrackedPerson:
    speed = math.hypot(*velocity)
    posture = posture or (Posture.WALKING if speed > 0.0 else Posture.STANDING)
    heading = math.atan2(velocity[1], velocity[0]) if posture is Posture.WALKING else None
    return TrackedPerson(0, 0.0, np.array(at), np.array(velocity), 4e-4 * np.eye(4), posture, heading)


def straight(start: Sequence[float], end: Sequence[float]) -> Path:
    count = 1 + round(math.dist(start, end) / 0.05)
    return Path(np.linspace(start, end, count), math.dist(start, end))


def drive(
    follower: Follower,
    goal: Pose2D,
    pose: Pose2D = Pose2D(1.0, 0.0, 0.0),
    costmap: Costmap = CORRIDOR,
    ticks: int = 800,
) -> tuple[list[Pose2D], list[Twist2D], list[Status]]:
    """Follow fresh ways of the search, without people, until arrived."""
    poses, twists, states = [pose], [Twist2D()], []
    for tick in range(ticks):
        path = astar(costmap, poses[-1].position, goal.position)
        twist, status = follower.follow(path, goal, PoseEstimate(PERIOD * tick, poses[-1]), (), costmap)
        poses.append(moved(poses[-1], twist))
        twists.append(twist)
        states.append(status)
        if status is Status.ARRIVED:
            break
    return poses, twists, states


def test_it_arrives_within_the_tolerances_in_little_more_than_the_least_time() -> None:
    goal = Pose2D(9.0, 0.5, 1.2)
    poses, _, states = drive(Follower(), goal)
    assert states[-1] is Status.ARRIVED
    assert poses[-1].distance_to(goal.position) <= 0.15
    assert abs(poses[-1].yaw - goal.yaw) <= 0.2
    least = math.hypot(8.0, 0.5) + 1.0  # 8 m at 1 m/s and 1 m/s^2
    assert least < PERIOD * len(states) < least + 2.5


@pytest.mark.parametrize("goal", [Pose2D(9.0, 0.9, 3.0), Pose2D(1.5, 0.0, -2.0), Pose2D(3.0, -0.9, 0.0)])
@pytest.mark.parametrize("yaw", [0.0, 2.5])
def test_it_never_exceeds_the_limits_and_never_jerks(goal: Pose2D, yaw: float) -> None:
    poses, twists, states = drive(Follower(), goal, pose=Pose2D(1.0, 0.0, yaw))
    assert states[-1] is Status.ARRIVED
    velocity = np.diff([pose.position for pose in poses], axis=0) / PERIOD
    omega = np.array([twist.omega for twist in twists])
    assert np.hypot(*velocity.T).max() <= 1.0 + 1e-6
    assert np.hypot(*np.diff(velocity, axis=0).T).max() / PERIOD <= 1.0 + 1e-6
    assert np.abs(omega).max() <= 1.5 + 1e-9
    assert np.abs(np.diff(omega)).max() / PERIOD <= 3.0 + 1e-6


def test_the_corners_of_the_grid_do_not_reach_the_wheels() -> None:
    """A staircase that climbs 2 m in 9: the lateral velocity settles instead of swinging with the steps."""
    poses, _, _ = drive(Follower(), Pose2D(12.0, 0.95, 0.1), pose=Pose2D(1.0, -0.95, 0.15))
    middle = np.array([pose.position for pose in poses if 3.0 < pose.x < 10.5])
    lateral = np.diff(middle[:, 1]) / PERIOD
    swings = np.abs(np.diff(lateral)) / PERIOD
    assert len(middle) > 100
    assert np.abs(lateral).max() < 0.75
    assert np.percentile(swings, 90) < 0.6


def test_it_faces_where_it_goes_and_then_as_the_goal_asks() -> None:
    poses, _, _ = drive(Follower(), Pose2D(9.0, 0.0, -1.5), pose=Pose2D(1.0, 0.0, 1.5))
    on_the_way = [pose.yaw for pose in poses if 4.0 < pose.x < 8.0]
    assert np.abs(on_the_way).max() < 0.1
    assert poses[-1].yaw == pytest.approx(-1.5, abs=0.2)


def test_once_arrived_it_stays_until_the_goal_moves_away() -> None:
    follower, goal = Follower(), Pose2D(3.0, 0.0, 0.0)
    poses, _, _ = drive(follower, goal)
    pushed = Pose2D(poses[-1].x - 0.2, 0.0, 0.0)
    path = straight((2.8, 0.0), (3.0, 0.0))
    twist, status = follower.follow(path, goal, PoseEstimate(60.0, pushed), (), CORRIDOR)
    assert (twist, status) == (Twist2D(), Status.ARRIVED)
    _, status = follower.follow(path, Pose2D(3.5, 0.0, 0.0), PoseEstimate(60.05, pushed), (), CORRIDOR)
    assert status is Status.MOVING


def test_without_a_way_it_brakes_and_waits_until_there_is_one() -> None:
    follower, goal = Follower(), Pose2D(14.0, 0.0, 0.0)
    poses, twists, _ = drive(follower, goal, ticks=40)
    assert twists[-1].speed > 0.9
    states, speeds = [], []
    for tick in range(210):
        twist, status = follower.follow(None, goal, PoseEstimate(2.0 + PERIOD * tick, poses[-1]), (), CORRIDOR)
        states.append(status)
        speeds.append(twist.speed)
    assert speeds[0] == pytest.approx(twists[-1].speed - 0.05, abs=1e-6)
    assert max(speeds[21:]) < 1e-9
    assert states == [Status.WAITING] * 210
    path = straight((4.0, 0.0), (14.0, 0.0))
    _, status = follower.follow(path, goal, PoseEstimate(20.0, poses[-1]), (), CORRIDOR)
    assert status is Status.MOVING
    _, status = follower.follow(None, goal, PoseEstimate(20.05, poses[-1]), (), CORRIDOR)
    assert status is Status.WAITING


def test_at_the_end_of_a_way_short_of_the_goal_it_waits_and_a_trembling_end_does_not_make_it_creep() -> None:
    follower, goal, pose, twist = Follower(), Pose2D(6.0, 0.0, 0.0), Pose2D(2.0, 0.0, 0.0), Twist2D()
    states, speeds = [], []
    for tick in range(400):
        end = 5.0 + (0.05 if tick % 2 else 0.0)
        path = straight((pose.x, pose.y), (end, 0.0)) if pose.x < end else Path(pose.position[None, :], 0.0)
        twist, status = follower.follow(path, goal, PoseEstimate(PERIOD * tick, pose), (), CORRIDOR)
        pose = moved(pose, twist)
        states.append(status)
        speeds.append(twist.speed)
    assert pose.x == pytest.approx(5.0, abs=0.06)
    first = states.index(Status.WAITING)
    assert set(states[:first]) == {Status.MOVING}
    assert first < 200 and set(states[first:]) == {Status.WAITING}
    assert max(speeds[first + 2 :]) < 1e-9
    path = straight((pose.x, 0.0), (5.5, 0.0))
    twist, status = follower.follow(path, goal, PoseEstimate(20.0, pose), (), CORRIDOR)
    assert status is Status.MOVING and twist.speed > 0.0


def test_a_way_that_ends_within_the_tolerance_of_the_goal_is_enough_to_arrive() -> None:
    follower, goal, pose, status = Follower(), Pose2D(5.0, 0.0, 0.5), Pose2D(2.0, 0.0, 0.0), Status.MOVING
    states = []
    for tick in range(200):
        path = straight((pose.x, pose.y), (4.88, 0.0)) if pose.x < 4.87 else Path(pose.position[None, :], 0.0)
        twist, status = follower.follow(path, goal, PoseEstimate(PERIOD * tick, pose), (), CORRIDOR)
        pose = moved(pose, twist)
        states.append(status)
    assert states[-1] is Status.ARRIVED and set(states) == {Status.MOVING, Status.ARRIVED}


def test_the_line_to_the_look_ahead_cuts_no_blocked_corner() -> None:
    costmap = CORRIDOR.copy()
    costmap.cost[:30, 100:140] = LETHAL  # x from 5 to 7 m, the whole right half
    poses, _, states = drive(Follower(), Pose2D(9.0, -1.0, 0.0), pose=Pose2D(3.0, -1.0, 0.0), costmap=costmap)
    assert states[-1] is Status.ARRIVED
    assert (costmap.cost_at(np.array([pose.position for pose in poses])) < LETHAL).all()


def allowed(person: TrackedPerson, heading: float = 0.0) -> float:
    """Speed that a robot at the origin may go straight on, if it wants 1 m/s."""
    direction = rotation(heading)[:, 0]
    way = Way(np.linspace([0.0, 0.0], 5.0 * direction, 101))
    return ProximityLimit(robot_radius=0.3, max_deceleration=1.0).limit(1.0, direction, way, [person])


def test_the_closing_speed_is_limited_and_the_speed_along_with_a_person_is_not() -> None:
    assert allowed(track((1.0, 0.0))) == pytest.approx(0.37, abs=0.01)  # gap 0.45 m, less 0.08
    assert allowed(track((5.0, 0.0))) == 1.0
    assert allowed(track((0.0, 0.8))) == 1.0
    assert allowed(track((-0.7, 0.0))) == 1.0
    ahead_to_the_right = track((0.45, -0.8), (0.4, 0.0))
    assert allowed(ahead_to_the_right) == pytest.approx(0.4 + 0.3 + 0.3, abs=0.05)
    follows = allowed(track((1.2, 0.0), (0.4, 0.0)))
    assert 0.4 <= follows < 0.7


def test_it_stops_before_a_person_on_its_way_and_lets_it_leave() -> None:
    near = track((0.63, 0.0))
    assert allowed(near) == 0.0
    assert allowed(near, heading=math.pi) == 1.0
    # A walker who comes at the robot from behind: driving on is better than to stand.
    assert allowed(track((-0.6, 0.0), (0.8, 0.0))) == 1.0


def test_it_slows_down_for_a_walker_who_will_cross_its_way_and_not_for_one_who_will_not() -> None:
    assert allowed(track((2.0, 1.2), (0.0, -0.6))) < 0.75
    assert allowed(track((2.0, 1.2), (0.0, 0.6))) == 1.0
    assert allowed(track((2.0, 1.2))) == 1.0
    standing_with_noise = track((2.0, 1.2), (0.0, -0.6), posture=Posture.STANDING)
    assert allowed(standing_with_noise) == 1.0


@pytest.mark.parametrize("velocity", [(0.0, 0.0), (-0.5, 0.0), (0.0, -0.6)])
def test_it_yields_to_a_person_who_steps_into_its_way_and_does_not_touch_them(velocity: tuple[float, float]) -> None:
    follower, goal, pose, twist = Follower(), Pose2D(14.0, 0.0, 0.0), Pose2D(1.0, 0.0, 0.0), Twist2D()
    start = np.array([4.5, 1.2]) if velocity[1] else np.array([6.0, 0.0])
    gaps, speeds, states = [], [], []
    for tick in range(100):
        time = PERIOD * tick
        person = track(start + np.array(velocity) * max(time - 1.5, 0.0), velocity if time > 1.5 else (0.0, 0.0))
        path = straight((pose.x, pose.y), (14.0, 0.0))
        twist, status = follower.follow(path, goal, PoseEstimate(time, pose), [person], CORRIDOR)
        pose = moved(pose, twist)
        gaps.append(pose.distance_to(person.position_in_world) - 0.55)
        speeds.append(twist.speed)
        states.append(status)
        if gaps[-1] < 0.5 and speeds[-1] < 1e-3:
            break
    assert Status.YIELDING in states or not velocity[0]
    assert min(gaps) > 0.05


@pytest.mark.parametrize(
    "keywords", [{"max_speed": 0.0}, {"tolerance": (0.1, -0.2)}, {"control_period": math.inf}, {"radius": math.nan}]
)
def test_wrong_limits_are_refused(keywords: dict[str, object]) -> None:
    with pytest.raises(BadInputError, match="must be a positive number"):
        Follower(**keywords)  # type: ignore[arg-type]


@dataclass
class Walker:
    """A person who starts to walk straight on after the robot has moved; how well the robot sees them."""

    start: tuple[float, float]
    velocity: tuple[float, float] = (0.0, 0.0)
    delay: float = 0.0
    noticed_after: float = 0.0
    noise: np.random.Generator | None = None
    _error: Array = field(default_factory=lambda: np.zeros(5))

    def true_position(self, walking_for: float) -> Array:
        return np.array(self.start) + np.array(self.velocity) * max(walking_for - self.delay, 0.0)

    def track(self, walking_for: float) -> TrackedPerson:
        """The track: errors of 0.1 m, 0.1 m/s and 0.15 rad that last for about half a second."""
        if self.noise is not None:
            keep = math.exp(-PERIOD / 0.5)
            fresh = self.noise.normal(size=5) * [0.1, 0.1, 0.1, 0.1, 0.15]
            self._error = keep * self._error + math.sqrt(1.0 - keep**2) * fresh
        at = self.true_position(walking_for) + self._error[:2]
        covariance = (0.01 if self.noise else 4e-4) * np.eye(4)
        if not any(self.velocity) or walking_for <= self.delay + self.noticed_after:
            return TrackedPerson(0, 0.0, at, np.zeros(2), covariance, Posture.STANDING, None)
        heading = math.atan2(self.velocity[1], self.velocity[0]) + self._error[4]
        velocity = np.array(self.velocity) + self._error[2:4]
        return TrackedPerson(0, 0.0, at, velocity, covariance, Posture.WALKING, heading)


@dataclass(frozen=True)
class Run:
    """What came out: robot and people over time, shapes (n, 2) and (n, people, 2) [m], and how it ended."""

    robot: Array
    people: Array
    speeds: Array
    sides: list[str]
    status: Status

    @property
    def distances(self) -> list[float]:
        return np.hypot(*np.moveaxis(self.robot[:, None] - self.people, -1, 0)).min(axis=0).tolist()  # type: ignore[no-any-return]

    @property
    def longest_stop(self) -> float:
        longest = stop = 0
        for speed in self.speeds:
            stop = stop + 1 if speed < 0.05 else 0
            longest = max(longest, stop)
        return PERIOD * longest

    def passed_on(self, index: int = 0) -> str:
        """Side of a person on which the robot draws level with them."""
        ahead = self.robot[:, 0] > self.people[:, index, 0]
        tick = int(np.argmax(ahead))
        assert ahead[tick]
        return "left" if self.robot[tick, 1] > self.people[tick, index, 1] else "right"

    def flips(self) -> int:
        return sum(a != b for a, b in zip(self.sides, self.sides[1:], strict=False))


def corridor_layers(without: Sequence[str] = (), pass_side: str = "left") -> list[Layer]:
    return standard_layers([], robot_radius=0.3, without=without, pass_side=pass_side)


def run(
    people: Sequence[Walker],
    start: Pose2D = Pose2D(1.5, 0.0, 0.0),
    goal: Pose2D = Pose2D(14.5, 0.0, 0.0),
    layers: Sequence[Layer] | None = None,
    weight: float = 10.0,
) -> Run:
    """Close the loop round a point robot that does what it is told."""
    layers = corridor_layers() if layers is None else layers
    planner, follower, pose, twist = Planner(weight=weight), Follower(), start, Twist2D()
    recovery = Recovery(relocalize=lambda: None, ask=0.0)
    robot, truth, speeds, sides, walking_for, status = [], [], [], [], 0.0, Status.MOVING
    for tick in range(800):
        tracks = tuple(person.track(walking_for) for person in people)
        costmap = CORRIDOR.copy()
        for layer in layers:
            layer.apply(costmap, Scene(PERIOD * tick, tracks))
        path = planner.update(costmap, pose.position, goal.position, PERIOD * tick, False, tracks)
        twist, status = follower.follow(path, goal, PoseEstimate(PERIOD * tick, pose), tracks, costmap)
        status, _, _ = recovery.update(PoseEstimate(PERIOD * tick, pose), status)
        robot.append(pose.position)
        truth.append([person.true_position(walking_for) for person in people])
        speeds.append(twist.speed)
        if path is not None and tracks[0].posture is Posture.WALKING and pose.x < truth[-1][0][0]:
            level = np.abs(path.points_in_world[:, 0] - truth[-1][0][0]).argmin()
            sides.append("left" if path.points_in_world[level, 1] > truth[-1][0][1] else "right")
        walking_for += PERIOD * (walking_for > 0.0 or twist.speed > 0.01)
        pose = moved(pose, twist)
        if status in (Status.ARRIVED, Status.BLOCKED):
            break
    return Run(np.array(robot), np.array(truth), np.array(speeds), sides, status)


@pytest.mark.parametrize(("y", "speed"), [(-0.35, 0.3), (-0.2, 0.35), (-0.05, 0.45)])
def test_a_walker_is_overtaken_on_the_left_at_a_distance(y: float, speed: float) -> None:
    result = run([Walker((4.5, y), (speed, 0.0))])
    assert result.status is Status.ARRIVED
    assert result.passed_on() == "left"
    assert result.distances[0] >= 0.85
    assert result.longest_stop <= 0.5
    assert result.flips() == 0


def test_a_person_who_starts_late_is_overtaken_on_the_left() -> None:
    result = run([Walker((5.0, -0.2), (0.4, 0.0), delay=1.5)])
    assert (result.status, result.passed_on()) == (Status.ARRIVED, "left")
    assert result.distances[0] >= 0.85


@pytest.mark.parametrize("seed", [0, 1])
def test_noisy_tracks_that_walk_late_do_not_flip_the_side(seed: int) -> None:
    noise = np.random.default_rng(seed)
    result = run([Walker((4.5, -0.2), (0.35, 0.0), noticed_after=1.0, noise=noise)])
    assert (result.status, result.passed_on()) == (Status.ARRIVED, "left")
    assert result.flips() == 0
    assert result.distances[0] >= 0.75
    assert result.longest_stop <= 1.0


def test_the_overtake_layer_and_nothing_else_sends_the_robot_to_the_traffic_side() -> None:
    walker = [Walker((4.5, 0.1), (0.35, 0.0))]  # the right is the wider side
    assert run(walker).passed_on() == "left"
    assert run(walker, layers=corridor_layers(without=["overtake"])).passed_on() == "right"
    mirrored = [Walker((4.5, -0.1), (0.35, 0.0))]
    assert run(mirrored, layers=corridor_layers(pass_side="right")).passed_on() == "right"


@pytest.mark.parametrize("weight", [5.0, 20.0])
def test_three_standing_people_are_passed_in_a_slalom(weight: float) -> None:
    people = [Walker((4.5, 0.55)), Walker((7.5, -0.55)), Walker((10.5, 0.55))]
    result = run(people, start=Pose2D(1.0, 0.0, 0.0), weight=weight)
    assert result.status is Status.ARRIVED
    assert [result.passed_on(index) for index in range(3)] == ["right", "left", "right"]
    assert min(result.distances) >= 0.9
    assert result.longest_stop <= 0.5


def test_somebody_who_comes_the_other_way_is_passed_without_a_touch() -> None:
    result = run([Walker((13.0, 0.1), (-0.6, 0.0))])
    assert result.status is Status.ARRIVED
    assert result.distances[0] >= 0.75
    assert result.longest_stop <= 1.0


def test_two_people_who_walk_abreast_are_followed_at_their_speed() -> None:
    people = [Walker((5.0, y), (0.4, 0.0)) for y in (-0.6, 0.6)]
    for person in people:
        person.delay = -0.1  # they already walk when the robot looks for the first time
    result = run(people, goal=Pose2D(9.0, 0.0, 0.0))
    assert result.status is Status.ARRIVED
    assert min(result.distances) >= 0.9
    assert (result.robot[:, 0] < result.people[:, 0, 0]).all()
    following = (result.robot[:, 0] > 6.5) & (result.robot[:, 0] < 8.0)
    assert result.speeds[following] == pytest.approx(0.4, abs=0.15)


def g2(distance: float) -> float:
    return math.exp(-0.5 * (distance / 0.56) ** 2)


@pytest.mark.parametrize("at", [(14.5, 0.5), (14.5, 0.0), (13.8, 0.4)])
def test_a_robot_whose_goal_is_beside_a_person_stops_at_the_edge_of_their_space(at: tuple[float, float]) -> None:
    assert g2(math.dist(at, (14.5, 0.0))) > 0.2
    result = run([Walker(at)])
    assert result.status is Status.BLOCKED
    assert result.longest_stop == pytest.approx(10.0, abs=0.2)
    assert 1.0 < result.distances[0] < 1.2
    assert g2(result.distances[0]) <= 0.2


def test_once_the_person_beside_the_goal_leaves_the_robot_goes_on_and_arrives() -> None:
    result = run([Walker((14.5, 0.5), (0.5, 0.0), delay=18.0)])
    assert result.status is Status.ARRIVED
    assert 3.0 < result.longest_stop < 7.0
    assert g2(result.distances[0]) <= 0.2


@pytest.mark.parametrize(
    ("walker", "delay"),
    [
        (Walker((14.4, 1.3), (0.0, -0.4), delay=10.0), 3.0),  # across the goal, just before the robot is there
        (Walker((11.0, 0.3), (0.35, 0.0), delay=1.0), 5.0),  # ahead of the robot, past the goal
    ],
)
def test_somebody_who_walks_by_at_the_goal_only_delays(walker: Walker, delay: float) -> None:
    alone = run([Walker((1.0, -1.2))])
    result = run([walker])
    assert result.status is Status.ARRIVED
    assert 0.0 < PERIOD * (len(result.robot) - len(alone.robot)) < delay
    assert result.distances[0] > 0.75


# The living room: a couch, a person on it, a television 3 m before it.
COUCH = Seat("couch", np.array([19.5, -0.4]), -0.5 * math.pi, 0.8, 1.9, "tv")
ROOM_BOXES = [
    SolidBox("couch", "object", np.array([19.5, -0.4, 0.4]), np.array([1.9, 0.8, 0.8]), 0.0),
    SolidBox("tv", "object", np.array([19.5, -3.4, 0.95]), np.array([1.2, 0.08, 0.7]), 0.0),
]


def living_room(on: bool, task: Task | None = None, people: Sequence[TrackedPerson] = ()) -> Costmap:
    seated = TrackedPerson(
        9, 0.0, COUCH.position_in_world, np.zeros(2), 4e-4 * np.eye(4), Posture.SEATED, COUCH.facing, "couch"
    )
    scene = Scene(0.0, (seated, *people), (Device("tv", np.array([19.5, -3.4]), on),), (COUCH,), task)
    costmap = Costmap.covering([((16.0, 23.0), (-3.5, 3.5))], 0.05)
    for layer in standard_layers(ROOM_BOXES, robot_radius=0.3):
        layer.apply(costmap, scene)
    return costmap


@pytest.mark.parametrize("weight", [5.0, 10.0, 20.0])
def test_the_robot_passes_before_the_couch_while_the_tv_is_off_and_far_behind_it_while_it_is_on(weight: float) -> None:
    start, goal = np.array([16.6, -1.9]), np.array([22.3, -1.9])
    off, on = (
        astar(living_room(False), start, goal, weight=weight),
        astar(living_room(True), start, goal, weight=weight),
    )
    assert off is not None and on is not None
    assert np.abs(off.points_in_world[:, 1] + 1.9).max() < 0.6
    behind = on.points_in_world[np.abs(on.points_in_world[:, 0] - 19.5) < 0.1]
    assert behind[:, 1].min() + 0.4 >= 2.0


def test_a_robot_that_hands_something_over_stops_in_front_of_the_person_inside_the_opening() -> None:
    place, heading = np.array([10.5, 0.3]), math.pi - 0.04
    task = HandOver(place, person=0, heading=heading)
    stop = place + 0.9 * rotation(heading)[:, 0]
    goal, pose, twist = Pose2D(float(stop[0]), float(stop[1]), heading - math.pi), Pose2D(3.0, 0.0, 0.0), Twist2D()
    person, follower, planner, status = track(place), Follower(), Planner(), Status.MOVING
    costmap = CORRIDOR.copy()
    for layer in corridor_layers():
        layer.apply(costmap, Scene(0.0, (person,), task=task))
    for tick in range(400):
        path = planner.update(costmap, pose.position, goal.position, PERIOD * tick, False)
        twist, status = follower.follow(path, goal, PoseEstimate(PERIOD * tick, pose), [person], costmap)
        pose = moved(pose, twist)
        assert costmap.cost_at(pose.position) < 20
    assert status is Status.ARRIVED
    assert pose.distance_to(place) == pytest.approx(0.9, abs=0.1)
    assert abs(pose.yaw + 0.04) < 0.2
