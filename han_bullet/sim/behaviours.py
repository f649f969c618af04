"""What people of a scenario do: stand, sit, walk along waypoints."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import numpy as np

from han_bullet.geometry import Array, Pose2D, wrap_angle
from han_bullet.messages import Posture
from han_bullet.sim.trigger import RobotNow, StartSignal
from han_bullet.world_schema import Person, Sit, Stand, Walk, World

WALK_TURN_RATE = 2.0  # [rad/s]; people take about a second for a right angle
HAND_OVER_TURN_RATE = 1.5  # [rad/s]
STILL_TURNS = 2.0  # [m]; who has been asked for a hand-over does not turn on after a robot that is nearer
TURN_ACCELERATION = 8.0  # [rad/s^2]
TURN_GAIN = 4.0  # [1/s]; slows the turn as it ends, slower than TURN_ACCELERATION allows, so it does not overshoot
TIME_TO_SPEED = 0.5  # [s] from standing to walking speed and back
CORNER = 0.25  # [m]; a waypoint this near is passed and the next one aimed at
ARRIVED = 0.03  # [m]
WALKING_SPEED = 0.1  # [m/s]; below it a person stands [Mateus2019]


class Behaviour(ABC):
    """Move one person.

    Attributes:
        pose_in_world: Position and direction faced.
        speed: Along that direction [m/s].
    """

    def __init__(self, pose_in_world: Pose2D) -> None:
        self.pose_in_world = pose_in_world
        self.speed = 0.0
        self._turn_rate = 0.0

    @abstractmethod
    def advance(self, robot: RobotNow, dt: float) -> None:
        """Move on by a time step [s]."""

    @property
    def posture(self) -> Posture:
        """Return standing, walking or seated."""
        return Posture.WALKING if self.speed >= WALKING_SPEED else Posture.STANDING

    @property
    def velocity_in_world(self) -> Array:
        """Return the velocity, shape (2,) [m/s]."""
        yaw = self.pose_in_world.yaw
        return self.speed * np.array([math.cos(yaw), math.sin(yaw)])

    def _face(self, yaw: float | None, rate: float, dt: float) -> None:
        """Turn smoothly towards a direction [rad], or come to rest where there is none."""
        wanted = 0.0 if yaw is None else TURN_GAIN * wrap_angle(yaw - self.pose_in_world.yaw)
        change = min(max(wanted, -rate), rate) - self._turn_rate
        self._turn_rate += min(max(change, -TURN_ACCELERATION * dt), TURN_ACCELERATION * dt)
        if self._turn_rate != 0.0:
            pose = self.pose_in_world
            self.pose_in_world = Pose2D(pose.x, pose.y, wrap_angle(pose.yaw + self._turn_rate * dt))


class Standing(Behaviour):
    """Stand; where asked to, turn towards a robot that requests a hand-over, and wait as one stands once it is near."""

    def __init__(self, pose_in_world: Pose2D, *, turns_to_robot: bool = False) -> None:
        super().__init__(pose_in_world)
        self._turns_to_robot = turns_to_robot
        self._towards_robot: float | None = None

    def advance(self, robot: RobotNow, dt: float) -> None:
        """Turn on."""
        if not (self._turns_to_robot and robot.requests_hand_over):
            self._towards_robot = None
        elif self._towards_robot is None or robot.pose_in_world.distance_to(self.pose_in_world.position) >= STILL_TURNS:
            x, y = robot.pose_in_world.position - self.pose_in_world.position
            self._towards_robot = math.atan2(y, x)
        self._face(self._towards_robot, HAND_OVER_TURN_RATE, dt)


class Sitting(Behaviour):
    """Sit."""

    def advance(self, robot: RobotNow, dt: float) -> None:
        """Stay."""

    @property
    def posture(self) -> Posture:
        """Return seated."""
        return Posture.SEATED


class Walking(Behaviour):
    """Stand until the start signal, walk along the waypoints, then stand."""

    def __init__(self, pose_in_world: Pose2D, walk: Walk) -> None:
        super().__init__(pose_in_world)
        self._waypoints = list(walk.waypoints)
        self._cruise = walk.speed
        self._signal = StartSignal(walk.starts)

    def advance(self, robot: RobotNow, dt: float) -> None:
        """Walk on."""
        here = self.pose_in_world
        goal = self._next_waypoint() if self._signal.given(robot, (here.x, here.y)) else None
        if goal is None:
            self._face(None, WALK_TURN_RATE, dt)
            self._approach_speed(0.0, dt)
        else:
            x, y = goal[0] - here.x, goal[1] - here.y
            bearing = math.atan2(y, x)
            self._face(bearing, WALK_TURN_RATE, dt)
            ahead = max(0.0, math.cos(bearing - self.pose_in_world.yaw))
            self._approach_speed(ahead * self._speed_before(math.hypot(x, y)), dt)
        here, step = self.pose_in_world, self.speed * dt
        self.pose_in_world = Pose2D(here.x + step * math.cos(here.yaw), here.y + step * math.sin(here.yaw), here.yaw)

    def _next_waypoint(self) -> tuple[float, float] | None:
        """Return the waypoint to walk to, forgetting those that are reached."""
        while self._waypoints:
            reach = CORNER if len(self._waypoints) > 1 else ARRIVED
            if self.pose_in_world.distance_to(self._waypoints[0]) > reach:
                return self._waypoints[0]
            self._waypoints.pop(0)
        return None

    def _speed_before(self, distance: float) -> float:
        """Return the speed that still allows to stop at the last waypoint, a distance [m] away."""
        if len(self._waypoints) > 1:
            return self._cruise
        return min(self._cruise, math.sqrt(2.0 * self._acceleration * distance))

    @property
    def _acceleration(self) -> float:
        return self._cruise / TIME_TO_SPEED

    def _approach_speed(self, wanted: float, dt: float) -> None:
        most = self._acceleration * dt
        self.speed += min(max(wanted - self.speed, -most), most)


def behaviour_of(person: Person, world: World) -> Behaviour:
    """Build the behaviour that a world file gives a person."""
    behaviour = person.behaviour
    if isinstance(behaviour, Walk):
        return Walking(person.start_pose_in_world, behaviour)
    if isinstance(behaviour, Stand):
        return Standing(person.start_pose_in_world, turns_to_robot=behaviour.turns_to_robot)
    return Sitting(_seat_pose(behaviour, world))


def _seat_pose(sit: Sit, world: World) -> Pose2D:
    area = next(area for area in world.sitting_areas if area.name == sit.on)
    return Pose2D(*area.seat, area.facing)
