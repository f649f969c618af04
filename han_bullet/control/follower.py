"""Follow a way with an omnidirectional base."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from han_bullet.control.proximity import ProximityLimit
from han_bullet.control.way import Way
from han_bullet.costmap.grid import INSCRIBED, Costmap
from han_bullet.errors import check_positive
from han_bullet.geometry import Array, Pose2D, Twist2D, rotation, wrap_angle
from han_bullet.messages import Path, PoseEstimate, Status, TrackedPerson
from han_bullet.world_schema import CONTROL_PERIOD

LOOK_AHEAD = 0.5  # along the way [m]; shorter follows the 45 degree corners of the grid, longer cuts into people
BRAKING = 0.7  # part of the acceleration limit that an approach to the goal plans with; the rest corrects errors
TURN_AT = 0.5  # from the goal on, the robot turns to the goal's yaw [m]
FACE_AHEAD = 1.0  # while travelling it faces the way this far ahead [m]; farther than the target, so that it looks calm
SLOWEST_FACING_AWAY = 0.3  # part of its speed at which the robot moves where its front does not look
CLOSE_ENOUGH = 0.5  # part of the tolerance in which it stops and only turns, lest it chase a goal that trembles
STANDING = 0.05  # below it the robot stands [m/s]; what one control period can take away


class Follower:
    """Turn a way into velocities: look ahead along it, slow down for curves, people and the goal, face ahead."""

    def __init__(
        self,
        *,
        radius: float = 0.3,
        max_speed: float = 1.0,
        max_acceleration: float = 1.0,
        max_yaw_rate: float = 1.5,
        max_yaw_acceleration: float = 3.0,
        tolerance: tuple[float, float] = (0.15, 0.2),
        control_period: float = CONTROL_PERIOD,
        proximity: ProximityLimit | None = None,
    ) -> None:
        """Configure the follower.

        Args:
            radius: Of the robot's footprint [m].
            max_speed: [m/s].
            max_acceleration: [m/s^2].
            max_yaw_rate: [rad/s].
            max_yaw_acceleration: [rad/s^2].
            tolerance: Of the goal, in position [m] and yaw [rad].
            control_period: Between two calls [s].
            proximity: How to slow down near people; None takes the defaults.
        """
        check_positive("follower", radius=radius, max_speed=max_speed, max_acceleration=max_acceleration)
        check_positive("follower", max_yaw_rate=max_yaw_rate, max_yaw_acceleration=max_yaw_acceleration)
        check_positive(
            "follower", tolerance_position=tolerance[0], tolerance_yaw=tolerance[1], control_period=control_period
        )
        self.max_speed = max_speed
        self.max_acceleration = max_acceleration
        self.max_yaw_rate = max_yaw_rate
        self.max_yaw_acceleration = max_yaw_acceleration
        self.tolerance_position, self.tolerance_yaw = tolerance
        self.control_period = control_period
        self.proximity = proximity or ProximityLimit(robot_radius=radius, max_deceleration=max_acceleration)
        self._velocity_in_world: Array = np.zeros(2)
        self._omega = 0.0
        self._arrived_at: Pose2D | None = None

    def follow(
        self,
        path: Path | None,
        goal: Pose2D,
        estimate: PoseEstimate,
        people: Sequence[TrackedPerson],
        costmap: Costmap,
        speed_factor: float = 1.0,
    ) -> tuple[Twist2D, Status]:
        """Return the command for the next control period, and what the robot is up to.

        Without a way, or at the end of one that stops short of the goal, it waits.

        Args:
            path: The way from the robot to the goal or towards it, or None.
            goal: Where to stop, and how to stand there.
            estimate: Where the robot is at this tick; it stops where it does not know.
            people: Confirmed tracks.
            costmap: What the way was planned on.
            speed_factor: Part of the largest speed that its sensors allow, in [0, 1]; with 0 it stops and waits.
        """
        pose = estimate.pose_robot_in_world
        if estimate.lost:
            return self.stand(pose), Status.LOST
        if self._has_arrived(goal, pose):
            return self.stand(pose), Status.ARRIVED
        if speed_factor == 0.0:
            return self.stand(pose), Status.BLIND
        if pose.distance_to(goal.position) <= self.tolerance_position:  # even if somebody now blocks the goal's cell
            path = path or Path(np.vstack([pose.position, goal.position]), 0.0)
        if path is None:
            return self.stand(pose), Status.WAITING
        yaw = goal.yaw if pose.distance_to(goal.position) < TURN_AT else pose.yaw
        way = Way(_ending_at(goal.position, path.points_in_world, costmap.resolution))
        if self._stands_before(goal, way):
            return self._command(np.zeros(2), self._turn(yaw - pose.yaw), pose), Status.WAITING
        if way.length > TURN_AT:
            yaw = way.direction_to(FACE_AHEAD, pose.yaw)
        velocity: Array = np.zeros(2)
        yielding = False
        if pose.distance_to(goal.position) > CLOSE_ENOUGH * self.tolerance_position:
            target = self._target(way, costmap)
            fastest = speed_factor * self.max_speed
            velocity, yielding = self._velocity(way, target, fastest, wrap_angle(yaw - pose.yaw), people)
        return self._command(velocity, self._turn(yaw - pose.yaw), pose), Status.YIELDING if yielding else Status.MOVING

    def stand(self, pose: Pose2D) -> Twist2D:
        """Return the command that brakes to a stand, and then keeps standing, at that pose."""
        return self._command(np.zeros(2), 0.0, pose)

    def drive(self, wanted: Twist2D, pose: Pose2D) -> Twist2D:
        """Return the command nearest to what somebody wants who drives the robot that the limits allow at that pose."""
        self.forget()
        part = min(1.0, self.max_speed / max(wanted.speed, 1e-9))
        omega = min(max(wanted.omega, -self.max_yaw_rate), self.max_yaw_rate)
        return self._command(part * wanted.linear_in_world(pose.yaw), omega, pose)

    def forget(self) -> None:
        """Forget that it has arrived anywhere: it has another goal, or somebody drives it away."""
        self._arrived_at = None

    def overruled(self, command: Twist2D, pose: Pose2D) -> None:
        """Take note that the base got another command than the one returned last, at that pose."""
        halfway = pose.yaw + 0.5 * command.omega * self.control_period
        self._velocity_in_world, self._omega = command.linear_in_world(halfway), command.omega

    def _has_arrived(self, goal: Pose2D, pose: Pose2D) -> bool:
        """Tell whether the robot stands at the goal; once there it stays, until the goal moves away."""
        if self._arrived_at is not None and self._arrived_at.distance_to(goal.position) <= self.tolerance_position:
            return True
        near = pose.distance_to(goal.position) <= self.tolerance_position
        turned = abs(wrap_angle(goal.yaw - pose.yaw)) <= self.tolerance_yaw
        standing = float(np.hypot(*self._velocity_in_world)) <= STANDING
        self._arrived_at = goal if near and turned and standing else None
        return self._arrived_at is not None

    def _stands_before(self, goal: Pose2D, way: Way) -> bool:
        """Tell whether the robot stands at the end of a way that stops short of the goal.

        It sets off again only for more than the tolerance: that end trembles as the tracks of people do.
        """
        short = goal.distance_to(way.end) > self.tolerance_position
        standing = float(np.hypot(*self._velocity_in_world)) <= STANDING
        return short and standing and way.length <= self.tolerance_position

    def _target(self, way: Way, costmap: Costmap) -> Array:
        """Return the point to steer to: as far ahead as the straight line to it stays free."""
        target = way.mean_about(LOOK_AHEAD)
        ahead = LOOK_AHEAD
        while ahead > costmap.resolution and not _leads_out(costmap, way.start, target):
            ahead -= costmap.resolution
            target = way.at(ahead)
        return target

    def _velocity(
        self, way: Way, target: Array, fastest: float, facing_error: float, people: Sequence[TrackedPerson]
    ) -> tuple[Array, bool]:
        """Return the wanted velocity in the world, (2,) [m/s], and whether a person holds the robot up."""
        to_target = target - way.start
        distance = float(np.hypot(*to_target))
        if distance < 1e-6:
            return np.zeros(2), False
        direction = to_target / distance
        speed = min(fastest, math.sqrt(2.0 * BRAKING * self.max_acceleration * way.length))
        speed = min(speed, self._curve_speed(direction, distance))
        if way.length > TURN_AT:
            speed *= max(math.cos(facing_error), SLOWEST_FACING_AWAY)
        allowed = self.proximity.limit(speed, direction, way, people)
        return allowed * direction, allowed < STANDING < speed

    def _curve_speed(self, direction: Array, distance: float) -> float:
        """Return the speed [m/s] at which the arc from the present course to the target needs the limit."""
        speed = float(np.hypot(*self._velocity_in_world))
        if speed < STANDING:
            return self.max_speed
        course = self._velocity_in_world / speed
        sine = abs(float(course[0] * direction[1] - course[1] * direction[0]))
        sine = 1.0 if course @ direction < 0.0 else sine
        curvature = 2.0 * sine / distance
        return math.sqrt(self.max_acceleration / max(curvature, 1e-6))

    def _turn(self, error: float) -> float:
        """Return the yaw rate [rad/s] that ends a yaw error [rad] without overshoot."""
        error = wrap_angle(error)
        stoppable = math.sqrt(2.0 * BRAKING * self.max_yaw_acceleration * abs(error))
        return math.copysign(min(stoppable, 2.0 * abs(error), self.max_yaw_rate), error)

    def _command(self, velocity_in_world: Array, omega: float, pose: Pose2D) -> Twist2D:
        """Return the twist nearest to a wanted one that the accelerations allow after the previous command."""
        change = velocity_in_world - self._velocity_in_world
        largest = self.max_acceleration * self.control_period
        change *= min(1.0, largest / max(float(np.hypot(*change)), 1e-9))
        self._velocity_in_world = self._velocity_in_world + change
        step = self.max_yaw_acceleration * self.control_period
        self._omega += min(max(omega - self._omega, -step), step)
        # The base turns during the period: the yaw half-way through makes the mean velocity the wanted one.
        in_body = rotation(pose.yaw + 0.5 * self._omega * self.control_period).T @ self._velocity_in_world
        return Twist2D(float(in_body[0]), float(in_body[1]), float(self._omega))


def _ending_at(goal_in_world: Array, points: Array, resolution: float) -> Array:
    """Let a way that ends in the goal's cell end at the goal itself; one that stops short of it stays."""
    if np.abs(points[-1] - goal_in_world).max() > resolution:
        return points
    return np.vstack([points[:-1] if len(points) > 1 else points, goal_in_world])


def _leads_out(costmap: Costmap, start_in_world: Array, end_in_world: Array) -> bool:
    """Tell whether a straight line enters no blocked cell, but for those that it begins in."""
    blocked = costmap.costs_on_line(start_in_world, end_in_world) >= INSCRIBED
    return not blocked[int(np.argmin(blocked)) :].any()
