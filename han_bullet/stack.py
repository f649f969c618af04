"""The spine: one observation in, one decision out. With `episode.py` and `messages.py`, this is the whole program.

Between two observations somebody outside may give orders: another task, none, or a command to drive by.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from han_bullet.control.caution import speed_factor_among
from han_bullet.control.follower import Follower
from han_bullet.control.protective_stop import ProtectiveStop
from han_bullet.control.recovery import Recovering, Recovery
from han_bullet.control.teleoperation import HOLD, Teleoperation
from han_bullet.costmap.grid import Costmap
from han_bullet.costmap.layer import Layer
from han_bullet.detection.camera_detector import FrameDetector
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Pose2D, Twist2D
from han_bullet.health.sensor_health import HealthReport, SensorHealth
from han_bullet.localization.localizer import Localization
from han_bullet.localization.pose_trail import PoseTrail
from han_bullet.messages import (
    Fault,
    Frame,
    FrameDetections,
    GoTo,
    HandOver,
    LaserScan,
    LegScan,
    Observation,
    Order,
    Path,
    PoseEstimate,
    RecoveryStep,
    Scan,
    Scene,
    Status,
    TrackedPerson,
)
from han_bullet.planning.planner import Planner
from han_bullet.situation import Situation
from han_bullet.tracking.legs import LegFinder
from han_bullet.tracking.projection import GroundProjection
from han_bullet.tracking.tracker import PeopleTracker


@dataclass(frozen=True)
class Decision:
    """All that one tick decided; hooks read this.

    Attributes:
        time: Of the observation [s].
        estimate: Where the robot believes itself to be.
        detections: One per frame of the observation.
        scans: The same on the floor, of the frames that are of use.
        people: Confirmed tracks.
        scene: What the layers looked at.
        costmap: What the planner looked at.
        path: The way taken, or None where there is no free one.
        command: For the robot.
        status: What the robot is up to.
        faults: What is wrong with its sensors, as it has noticed.
        step: What it tries since it cannot go on; None while it can.
        gave_up: Why it gave up, in a sentence; None as long as it has not.
        legs: What the laser said of people; None where it had nothing to say.
        orders: What it was told since the last decision.
    """

    time: float
    estimate: PoseEstimate
    detections: tuple[FrameDetections, ...]
    scans: tuple[Scan, ...]
    people: tuple[TrackedPerson, ...]
    scene: Scene
    costmap: Costmap
    path: Path | None
    command: Twist2D
    status: Status
    faults: tuple[Fault, ...] = ()
    step: RecoveryStep | None = None
    gave_up: str | None = None
    legs: LegScan | None = None
    orders: tuple[Order, ...] = ()

    @property
    def ends_task(self) -> bool:
        """Tell whether the task is over, well or not; the robot then stands until it has another."""
        return self.status is Status.ARRIVED or self.gave_up is not None

    @property
    def asks_for_hand_over(self) -> bool:
        """Tell whether the robot is asking a person it has chosen to turn to it."""
        task = self.scene.task
        return isinstance(task, HandOver) and task.person is not None and self.gave_up is None

    @property
    def asks_to_make_way(self) -> bool:
        """Tell whether the robot is asking people to let it pass: for a loudspeaker, and whoever can act on it."""
        return self.step is RecoveryStep.ASK


class NavigationStack:
    """Turn one observation into one command: localize, detect, project, track, map, plan, follow, brake or recover."""

    def __init__(
        self,
        *,
        localization: Localization,
        detector: FrameDetector,
        projection: GroundProjection,
        leg_finder: LegFinder,
        tracker: PeopleTracker,
        situation: Situation,
        free_space: Costmap,
        layers: Sequence[Layer],
        planner: Planner,
        follower: Follower,
        protective_stop: ProtectiveStop,
        recovery: Recovery,
        health: SensorHealth | None = None,
    ) -> None:
        self.localization = localization
        self.detector = detector
        self.projection = projection
        self.leg_finder = leg_finder
        self.tracker = tracker
        self.situation = situation
        self.free_space = free_space
        self.layers = tuple(layers)
        self.planner = planner
        self.follower = follower
        self.protective_stop = protective_stop
        self.recovery = recovery
        self.health = health or SensorHealth()
        self._trail = PoseTrail()
        self._fixed: dict[str, Frame] = {}  # the last frame of each fixed camera, for what it would see
        self._people: tuple[TrackedPerson, ...] = ()
        self._costmap: Costmap | None = None
        self._driver = Teleoperation()
        self._ended: Recovering | None = None  # how the task came to its end, while there is no other
        self._orders: list[Order] = []

    @property
    def has_orders(self) -> bool:
        """Tell whether it was told something that no decision knows of yet."""
        return bool(self._orders)

    def take(self, task: GoTo | HandOver) -> None:
        """Take another task from the next step on; what belonged to the old one is forgotten, what was seen is not.

        Args:
            task: `checks.check_goal` says whether the map allows it. A hand-over that names a person by the id of a
                track is to them, wherever they are.

        Raises:
            BadInputError: Nobody with that id is tracked; the old task stays.
        """
        taken = self.situation.take(task)
        self._begin(Order("go_to" if isinstance(task, GoTo) else "hand_over", taken))

    def cancel(self) -> None:
        """Drop the task: the robot brakes as hard as it may from the next step on and stands where it comes to rest."""
        self.situation.take(None)
        self._driver.release()
        self._begin(Order("cancel"))

    def override(self, command: Twist2D, hold: float = HOLD) -> None:
        """Let somebody drive: command this instead in the next step and, without another, for so much longer [s].

        Limits of speed and acceleration hold, and the protective stop has the last word. Afterwards the robot goes on
        with its task; if that was over, it stands where it was driven to.

        Raises:
            BadInputError: A number is not finite, or the time is negative.
        """
        begins = not self._driver.active
        self._driver.take(command, hold)
        if begins:
            self._orders.append(Order("drive"))
        if self._ended is not None:
            self.situation.take(None)
            self._forget()

    def clear_obstacles(self) -> None:
        """Let all costmap layers forget that remember obstacles; what is still there they mark again."""
        self.recovery.clear()
        self._orders.append(Order("clear_obstacles"))

    def plan_between(self, start_in_world: Array, goal_in_world: Array) -> Path | None:
        """Return the cheapest way between two points, (2,) [m], on the last step's costmap; None where none is free.

        The robot's own way is not touched.

        Raises:
            BadInputError: There was no step yet, or a number is not finite.
        """
        points = np.array([start_in_world, goal_in_world], float)
        if self._costmap is None or not np.isfinite(points).all():
            raise BadInputError(f"a way between {points.tolist()} needs finite points, and a step before it")
        return self.planner.search(self._costmap, *points)

    def step(self, observation: Observation) -> Decision:
        """Decide on a command for the robot."""
        estimate = self.localization.update(observation.odometry, observation.laser)
        self._trail.add(estimate)
        detections, scans, health = self._see(observation, estimate)
        legs = self._find_legs(observation, estimate)
        scans = self.health.aligned(scans, legs, self._people)
        blind = tuple(self._fixed) if estimate.lost else health.blind
        people = self.tracker.update(scans, observation.time, self._views_of(blind), legs)
        sweep = None if estimate.lost else observation.laser
        scene = self.situation.update(estimate, people, observation.device_messages, sweep, self._pose_at(sweep))
        costmap = self.free_space.copy()
        for layer in self.layers:  # order matters only to inflation; every layer only raises costs
            layer.apply(costmap, scene)
        goal = self.situation.goal() if self._ended is None else None
        path = None
        if goal is not None:
            path = self.planner.update(
                costmap,
                estimate.pose_robot_in_world.position,
                goal.position,
                observation.time,
                self.situation.changed,
                people,
            )
        # While all cameras work, who is not seen is hidden for a moment, and layers and proximity do.
        factor = min(health.speed_factor, speed_factor_among(people, path) if health.blind else 1.0)
        command, status = self._drive(path, goal, estimate, people, costmap, factor)
        command, status = self._brake(command, status, observation, estimate)
        status, step, gave_up = self._ended or self.recovery.update(estimate, status)
        if status is Status.ARRIVED or step is RecoveryStep.GIVE_UP:
            self._ended = status, step, gave_up
        self._people, self._costmap = people, costmap
        orders, self._orders = tuple(self._orders), []
        return Decision(
            time=observation.time,
            estimate=estimate,
            detections=detections,
            scans=scans,
            people=people,
            scene=scene,
            costmap=costmap,
            path=path,
            command=command,
            status=status,
            faults=(*health.faults, *self.situation.device_faults),
            step=step,
            gave_up=gave_up,
            legs=legs,
            orders=orders,
        )

    def _begin(self, order: Order) -> None:
        """Begin with another task, or none."""
        self._forget()
        self._orders.append(order)

    def _forget(self) -> None:
        """Forget what belonged to the task before."""
        self._ended = None
        self.planner.forget()
        self.follower.forget()
        self.recovery.begin_anew()

    def _drive(
        self,
        path: Path | None,
        goal: Pose2D | None,
        estimate: PoseEstimate,
        people: Sequence[TrackedPerson],
        costmap: Costmap,
        speed_factor: float,
    ) -> tuple[Twist2D, Status]:
        """Follow the way to the goal; stand without one; before all do as somebody says who drives."""
        pose, wanted = estimate.pose_robot_in_world, self._driver.at(estimate.time)
        if wanted is not None:
            self.recovery.go_on()
            return self.follower.drive(wanted, pose), Status.LOST if estimate.lost else Status.TELEOPERATED
        if goal is None:
            return self.follower.stand(pose), Status.LOST if estimate.lost else Status.IDLE
        command, status = self.follower.follow(path, goal, estimate, people, costmap, speed_factor)
        if status is Status.ARRIVED and not self.situation.goal_is_final:
            status = Status.LOOKING
        return command, status

    def _see(
        self, observation: Observation, estimate: PoseEstimate
    ) -> tuple[tuple[FrameDetections, ...], tuple[Scan, ...], HealthReport]:
        """Return what was found in each image, the same on the floor where it is of use, and how the sensors are.

        A robot that is lost knows neither where its own camera looks nor which of those whom others see is itself.
        """
        poses = [self._trail.pose_at(image.time) for image in observation.images]
        frames = [image.placed(pose) for image, pose in zip(observation.images, poses, strict=True)]
        detections = self.detector.detect(frames)
        health = self.health.update(observation, estimate, detections)
        self._fixed |= {frame.camera: frame for frame in frames if frame.fixed}
        scans = (
            self.projection.project(frame, found, pose)
            for frame, pose, found, usable in zip(frames, poses, detections, health.usable, strict=True)
            if usable and not estimate.lost
        )
        return tuple(detections), tuple(scans), health

    def _views_of(self, blind: Sequence[str]) -> list[Frame]:
        """Return what fixed cameras would see that see nothing now."""
        return [self._fixed[name] for name in blind if name in self._fixed]

    def _brake(
        self, command: Twist2D, status: Status, observation: Observation, estimate: PoseEstimate
    ) -> tuple[Twist2D, Status]:
        """Let the protective stop have the last word."""
        twist = observation.odometry.twist_robot_in_body
        command, braked = self.protective_stop.limit(command, observation.laser, twist, observation.time)
        if braked:
            self.follower.overruled(command, estimate.pose_robot_in_world)
            driving = status in (Status.MOVING, Status.YIELDING, Status.TELEOPERATED)
            status = Status.PROTECTIVE_STOP if driving else status
        return command, status

    def _find_legs(self, observation: Observation, estimate: PoseEstimate) -> LegScan | None:
        """Look for people's legs in the laser's sweep, from where the robot was then."""
        pose = self._pose_at(observation.laser)
        if pose is not None:
            estimate = replace(estimate, pose_robot_in_world=pose)
        return self.leg_finder.find(observation.laser, estimate, self._people)

    def _pose_at(self, sweep: LaserScan | None) -> Pose2D | None:
        """Return where the robot was when the laser swept, which may have been before this tick."""
        return None if sweep is None else self._trail.pose_at(sweep.time)
