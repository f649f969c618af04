"""The spine: one observation in, one decision out. With `episode.py` and `messages.py`, this is the whole program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from han_bullet.control.follower import Follower
from han_bullet.costmap.grid import Costmap
from han_bullet.costmap.layer import Layer
from han_bullet.detection.camera_detector import FrameDetector
from han_bullet.geometry import Twist2D
from han_bullet.localization.localizer import Localization
from han_bullet.localization.pose_trail import PoseTrail
from han_bullet.messages import (
    FrameDetections,
    HandOver,
    LegScan,
    Observation,
    Path,
    PoseEstimate,
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
        scans: The same on the floor.
        people: Confirmed tracks.
        scene: What the layers looked at.
        costmap: What the planner looked at.
        path: The way taken, or None where there is no free one.
        command: For the robot.
        status: What the robot is up to.
        legs: What the laser said of people; None where it had nothing to say.
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
    legs: LegScan | None = None

    @property
    def asks_for_hand_over(self) -> bool:
        """Tell whether the robot is asking a person it has chosen to turn to it."""
        return isinstance(self.scene.task, HandOver) and self.scene.task.person is not None


class NavigationStack:
    """Turn one observation into one command: localize, detect, project, track, map, plan, follow."""

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
        self._trail = PoseTrail()
        self._people: tuple[TrackedPerson, ...] = ()

    def step(self, observation: Observation) -> Decision:
        """Decide on a command for the robot."""
        estimate = self.localization.update(observation.odometry, observation.laser)
        pose = estimate.pose_robot_in_world
        self._trail.add(estimate)
        frames = [image.placed(self._trail.pose_at(image.time)) for image in observation.images]
        detections = self.detector.detect(frames)
        scans = [self.projection.project(*pair, pose) for pair in zip(frames, detections, strict=True)]
        legs = self._find_legs(observation, estimate)
        self._people = people = self.tracker.update(scans, observation.time, legs)
        scene = self.situation.update(estimate, people, observation.device_messages)
        costmap = self.free_space.copy()
        for layer in self.layers:  # order matters only to inflation; every layer only raises costs
            layer.apply(costmap, scene)
        goal = self.situation.goal()
        path = self.planner.update(
            costmap, pose.position, goal.position, observation.time, self.situation.changed, people
        )
        command, status = self.follower.follow(path, goal, estimate, people, costmap)
        if status is Status.ARRIVED and not self.situation.goal_is_final:
            status = Status.LOOKING
        return Decision(
            time=observation.time,
            estimate=estimate,
            detections=tuple(detections),
            scans=tuple(scans),
            people=people,
            scene=scene,
            costmap=costmap,
            path=path,
            command=command,
            status=status,
            legs=legs,
        )

    def _find_legs(self, observation: Observation, estimate: PoseEstimate) -> LegScan | None:
        """Look for people's legs in the laser's sweep, from where the robot was then."""
        sweep = observation.laser
        if sweep is not None:
            estimate = replace(estimate, pose_robot_in_world=self._trail.pose_at(sweep.time))
        return self.leg_finder.find(sweep, estimate, self._people)
