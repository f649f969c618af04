"""What the robot knows besides people: devices, sitting areas, its task, and where that task sends it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Pose2D
from han_bullet.known_devices import KnownDevices
from han_bullet.messages import Fault, GoTo, HandOver, LaserScan, PoseEstimate, Scene, Seat, Task, TrackedPerson

CHOOSE_WITHIN = 1.5  # [m] of the place where the task expects the person [Mateus2019]
SAME_PLACE = 0.5  # [m]: a new track this near to where the person was last is theirs
GONE_WITHIN = 0.3  # [m] of the stop before somebody who is not seen there: they have left
FREEZE_HEADING_AT = 2.0  # [m]: nearer than this, the bearing to the robot says nothing new about the person
FIRST_LOOK_AT = 3.0  # [m] before the place the robot brakes while nobody has been seen there; it stands at 2.5


class Situation:
    """Keep the devices' last states and the task, and turn them into the layers' scene and the planner's goal.

    Args:
        task: What to do; None: nothing yet.
        devices: Networked devices and what is known of them; None where there are none.
        seats: Sitting areas of the map.
    """

    def __init__(self, *, task: Task | None, devices: KnownDevices | None = None, seats: Sequence[Seat] = ()) -> None:
        self.changed = False
        self._task = task
        self._devices = devices or KnownDevices()
        self._seats = tuple(seats)
        self._postures: dict[int, str] = {}
        self._scene = Scene(0.0, task=task)
        self._pose_robot_in_world = Pose2D(0.0, 0.0, 0.0)

    def update(
        self,
        estimate: PoseEstimate,
        people: Sequence[TrackedPerson],
        device_messages: Sequence[bytes] = (),
        laser: LaserScan | None = None,
        pose_robot_at_scan: Pose2D | None = None,
    ) -> Scene:
        """Take in where the robot is, people, what devices sent, what the laser sees and from where it does.

        Afterwards `changed` says whether a device or somebody's posture has changed: that calls for a new plan.
        """
        self._pose_robot_in_world = pose = estimate.pose_robot_in_world
        device_changed = self._devices.update(device_messages, estimate.time)
        postures = {person.id: person.posture.value for person in people}
        known = self._postures.keys() & postures.keys()
        self.changed = device_changed or any(self._postures[key] != postures[key] for key in known)
        self._postures = postures
        if isinstance(self._task, HandOver) and not estimate.lost:
            self._task = _with_person(self._task, people, pose)
        self._scene = Scene(
            estimate.time, tuple(people), self._devices.states, self._seats, self._task, pose, laser, pose_robot_at_scan
        )
        return self._scene

    def take(self, task: Task | None) -> Task | None:
        """Take another task, or none, from the next update on; return it as it is meant.

        A hand-over to a person by id is meant to be where they are now.

        Raises:
            BadInputError: Nobody with that id is tracked; the old task stays.
        """
        if isinstance(task, HandOver):
            place = task.place_in_world if task.person is None else self._place_of(task.person)
            task = HandOver(np.array(place, float), task.distance, task.person)
        self._task = task
        return task

    def _place_of(self, person: int) -> Array:
        places = {tracked.id: tracked.position_in_world for tracked in self._scene.people}
        if person not in places:
            right = f"one of {', '.join(map(str, sorted(places)))}" if places else "a place, as nobody is tracked now,"
            raise BadInputError(f"person {person!r} of the hand-over is not tracked; {right} would be right")
        return places[person]

    @property
    def device_faults(self) -> tuple[Fault, ...]:
        """Return which devices are silent, as of the last update."""
        return self._devices.faults

    def goal(self) -> Pose2D | None:
        """Return where the robot has to be for its task, as of the last update; None where it has none."""
        return None if self._task is None else goal_of(self._task, self._pose_robot_in_world)

    @property
    def goal_is_final(self) -> bool:
        """Tell whether reaching the goal completes the task, rather than giving a view of who is missing."""
        return not isinstance(self._task, HandOver) or self._task.person is not None


def goal_of(task: Task, pose_robot_in_world: Pose2D) -> Pose2D:
    """Return where a robot, now at a pose, has to be for a task."""
    return task.pose_in_world if isinstance(task, GoTo) else _hand_over_pose(task, pose_robot_in_world)


def _with_person(task: HandOver, people: Sequence[TrackedPerson], pose_robot_in_world: Pose2D) -> HandOver:
    """Choose the nearest track to the place, keep it, and take the bearing to the robot as its heading.

    Who is out of sight, while the robot goes round something, is still taken to stand where they were.
    """
    chosen = next((person for person in people if person.id == task.person), None)
    if chosen is None:
        chosen = _nearest(people, task.place_in_world if task.position_in_world is None else task.position_in_world)
        chosen = chosen or _nearest(people, task.place_in_world)
    if chosen is None:
        gone = task.position_in_world is not None and (
            pose_robot_in_world.distance_to(task.position_in_world) <= task.distance + GONE_WITHIN
        )
        lost = dataclasses.replace(task, person=None)
        return dataclasses.replace(lost, heading=None, position_in_world=None) if gone else lost
    same = chosen.id == task.person or (
        task.position_in_world is not None and math.dist(chosen.position_in_world, task.position_in_world) <= SAME_PLACE
    )
    known = dataclasses.replace(task, person=chosen.id, position_in_world=chosen.position_in_world)
    near = pose_robot_in_world.distance_to(chosen.position_in_world) < FREEZE_HEADING_AT
    if task.heading is not None and same and near:
        return known
    towards_robot = pose_robot_in_world.position - chosen.position_in_world
    return dataclasses.replace(known, heading=math.atan2(towards_robot[1], towards_robot[0]))


def _nearest(people: Sequence[TrackedPerson], place_in_world: Array) -> TrackedPerson | None:
    """Return who is nearest to a place, (2,) [m], of those who are near enough to be meant."""
    near = [person for person in people if math.dist(person.position_in_world, place_in_world) <= CHOOSE_WITHIN]
    return min(near, key=lambda person: math.dist(person.position_in_world, place_in_world), default=None)


def _hand_over_pose(task: HandOver, pose_robot_in_world: Pose2D) -> Pose2D:
    """Return the stop before the chosen person, facing them; as long as nobody is known, the place, up to a look at it.

    A stop on the straight line to the place could lie inside a piece of furniture; the way to the place does not.
    """
    if task.position_in_world is None or task.heading is None:
        ahead = task.place_in_world - pose_robot_in_world.position
        near = pose_robot_in_world.distance_to(task.place_in_world) <= FIRST_LOOK_AT
        x, y = pose_robot_in_world.position if near else task.place_in_world
        return Pose2D(float(x), float(y), math.atan2(ahead[1], ahead[0]))
    x, y = task.position_in_world + task.distance * np.array([math.cos(task.heading), math.sin(task.heading)])
    return Pose2D(float(x), float(y), task.heading + math.pi)
