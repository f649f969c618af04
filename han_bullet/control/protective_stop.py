"""The last word on a command: the robot can always stop before what its laser scanner sees.

It knows nothing of tracks, map or pose: points of the scan, how they move, the robot's velocity, and the base's limits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.control.legs import LegMotion
from han_bullet.errors import check_positive
from han_bullet.geometry import Array, Pose2D, Twist2D, moved, rotation
from han_bullet.messages import LaserScan
from han_bullet.world_schema import CONTROL_PERIOD

STEP = 0.025  # of a prediction [s]
HALVINGS = 6  # of the interval in which the largest safe part of a command is looked for
SIDEWAYS = 0.5  # a point is passed rather than approached where less of the velocity leads towards it
CREEP = 0.15  # at this speed [m/s] points that stand are passed nearer: at NARROW, legs at the clearance
NARROW = 0.02  # [m] beyond the footprint
SHOULDERS = 0.25  # [m] beyond the footprint: by so much people are wider than their legs
FORESIGHT = 0.5  # by so much [s] people may be farther on their way than they are taken to be: who sets off gets faster
NO_WORSE = 1e-6  # no command is blamed for what braking at once comes to, within this [m]; more adds up to a creep
# Points that old [s] say nothing any more: a scanner out of order is the matter of health, which slows down.
SILENT = 0.5


class ProtectiveStop:
    """Limit commands so that no point of the scan comes nearer to the footprint than a clearance.

    A command is safe if the base, ramping to it from its present velocity, holding it for the reaction time and then
    braking as hard as it can, keeps the clearance from every point. Of one that is not, the largest part that is safe
    is let through: all directions but towards the point stay free, and so does moving away from one that is too near.
    A point that is only passed takes away the part of the velocity that leads towards it. Legs are taken to go on as
    they go, if not faster; they get the room that the body above them needs, and nothing is passed along those that
    move.
    """

    def __init__(
        self,
        *,
        radius: float = 0.3,
        max_acceleration: float = 1.0,
        max_yaw_acceleration: float = 3.0,
        clearance: float = 0.05,
        reaction: float = 0.1 + CONTROL_PERIOD,
    ) -> None:
        """Configure the limits.

        Args:
            radius: Of the robot's footprint [m].
            max_acceleration: Of the base, braking too [m/s^2].
            max_yaw_acceleration: [rad/s^2].
            clearance: Between footprint and points [m].
            reaction: Before the brakes hold: the age of a scan and a control period [s].
        """
        check_positive("protective stop", radius=radius, clearance=clearance, reaction=reaction)
        check_positive("protective stop", max_acceleration=max_acceleration, max_yaw_acceleration=max_yaw_acceleration)
        self.radius = radius
        self.clearance = clearance
        self.reaction = reaction
        self.control_period = CONTROL_PERIOD  # [s]; of a loop that is slower, its own
        self._accelerations = (max_acceleration, max_yaw_acceleration)
        self._legs = LegMotion()
        self._is_leg: NDArray[np.bool_] = np.zeros(0, bool)
        self._points_in_odom: Array = np.zeros((0, 2))
        self._velocities_in_odom: Array = np.zeros((0, 2))
        self._seen_at: float | None = None
        self._pose_in_odom = Pose2D(0.0, 0.0, 0.0)  # a frame of our own: where the first command came
        self._moved_at = 0.0
        self._base: Twist2D | None = None  # how the base moves by the commands that it got

    def limit(self, command: Twist2D, scan: LaserScan | None, twist: Twist2D, time: float) -> tuple[Twist2D, bool]:
        """Return the command for the next control period, and whether it had to be limited.

        A limited one changes the speed by no more than the base can in that period; of its turning it may ask for more.

        Args:
            command: What the robot would do.
            scan: That arrived with this tick, or None.
            twist: By the odometry, now.
            time: [s].
        """
        self._move_on(twist, time)
        if scan is not None:
            self._take_in(scan, twist, time)
        allowed = self._allowed(command, twist, time)
        # By its commands, not by odometry: slipping wheels tell of more speed than there is, and it would not brake.
        now = self._base or twist
        sent = command if allowed is command else self._ramped(allowed, now)
        self._base = self._ramped(sent, now)
        return sent, sent is not command

    def _allowed(self, command: Twist2D, twist: Twist2D, time: float) -> Twist2D:
        if self._seen_at is None or time - self._seen_at > SILENT:
            return command
        return self._largest_safe(command, twist, self._surroundings(command, twist, time))

    def _move_on(self, twist: Twist2D, time: float) -> None:
        """Move the robot on by its odometry."""
        self._pose_in_odom = moved(self._pose_in_odom, twist, time - self._moved_at)
        self._moved_at = time

    def _take_in(self, scan: LaserScan, twist: Twist2D, time: float) -> None:
        then = moved(self._pose_in_odom, twist, scan.time - time)
        self._is_leg, self._velocities_in_odom = self._legs.update(scan, then)
        self._points_in_odom, self._seen_at = then.to_world(scan.points_in_body), scan.time

    def _surroundings(self, command: Twist2D, twist: Twist2D, time: float) -> _Points:
        """Return the points that the robot could come near to before it stands."""
        age = 0.0 if self._seen_at is None else time - self._seen_at
        pose, velocities = self._pose_in_odom, self._velocities_in_odom
        points = pose.to_body(self._points_in_odom + age * velocities)
        duration, going = self._duration(command, twist), np.hypot(*velocities.T)
        reach = (
            max(command.speed, twist.speed) * duration
            + going * (duration + FORESIGHT)
            + self.radius
            + self.clearance
            + SHOULDERS
        )
        near = np.hypot(*points.T) <= reach
        margins = np.where(self._is_leg[near], max(SHOULDERS, self.clearance), self.clearance)
        going = going[near] > 0.0
        narrow = np.where(going, margins, np.where(self._is_leg[near], self.clearance, NARROW))
        return _Points(points[near], velocities[near] @ rotation(pose.yaw), margins, narrow)

    def _duration(self, command: Twist2D, twist: Twist2D) -> float:
        return self.reaction + max(command.speed, twist.speed) / self._accelerations[0]

    def _largest_safe(self, command: Twist2D, twist: Twist2D, points: _Points) -> Twist2D:
        """Return the command if it is safe, else the part of it, or of it along what is passed, that advances more."""
        if not len(points.in_body):
            return command
        duration = self._duration(command, twist)
        braking: Array | None = None  # how near they come if it brakes at once; mostly nobody asks

        def offended(candidate: Twist2D) -> _Offended | None:
            """Return the point that a candidate comes nearest to of those it must not."""
            nonlocal braking
            distances, directions = self._approaches(candidate, twist, points, duration)
            gaps = distances - self.radius
            margins = points.margins
            if candidate.speed <= CREEP + 1e-9:
                towards = directions @ np.array([candidate.vx, candidate.vy])
                margins = np.where(towards <= SIDEWAYS * candidate.speed, points.narrow_margins, margins)
            unsafe = gaps < margins
            if unsafe.any():
                braking = self._approaches(Twist2D(), twist, points, duration)[0] if braking is None else braking
                unsafe &= distances < braking - NO_WORSE
            nearest = int(np.where(unsafe, gaps, np.inf).argmin())
            return _Offended(directions[nearest], bool(points.velocities[nearest].any())) if unsafe.any() else None

        first = offended(command)
        if first is None:
            return command
        if offended(Twist2D(0.0, 0.0, command.omega)) is not None:  # turning would bend the way on which it brakes
            command = Twist2D(command.vx, command.vy, 0.0)
        along = None if first.moves else _along(command, first.direction)
        parts = [_part(candidate, offended) for candidate in (command, along) if candidate is not None]
        return max(parts, key=lambda part: part.vx * command.vx + part.vy * command.vy)

    def _approaches(self, candidate: Twist2D, twist: Twist2D, points: _Points, duration: float) -> tuple[Array, Array]:
        """Return how near the points come if the brakes hold after the reaction time, or already with the next command.

        The latter is what can be asked for then, so that a safe command leaves a safe one; in a bend it is another way.
        """
        now = np.array([twist.vx, twist.vy, twist.omega])
        target = np.array([candidate.vx, candidate.vy, candidate.omega])
        holds = np.array([self.reaction, self.control_period])
        found: tuple[Array, Array] = _approaches(
            points.in_body, points.velocities, now, target, holds, duration, *self._accelerations
        )
        return found

    def _ramped(self, wanted: Twist2D, now: Twist2D) -> Twist2D:
        """Return what the base can reach of a wanted velocity within a control period; the yaw rate is as wanted."""
        x, y = wanted.vx - now.vx, wanted.vy - now.vy
        part = min(1.0, self._accelerations[0] * self.control_period / max(math.hypot(x, y), 1e-9))
        return Twist2D(now.vx + part * x, now.vy + part * y, wanted.omega)


@dataclass(frozen=True)
class _Points:
    """What is around the robot.

    Attributes:
        in_body: Shape (n, 2) [m].
        velocities: Over the floor, along the body's axes, shape (n, 2) [m/s].
        margins: Room that each needs beyond the footprint, shape (n,) [m].
        narrow_margins: The same where it is passed at a creep.
    """

    in_body: Array
    velocities: Array
    margins: Array
    narrow_margins: Array


@dataclass(frozen=True)
class _Offended:
    """A point that a command comes too near to, in which direction, (2,), it then is, and whether it moves."""

    direction: Array
    moves: bool


def _along(command: Twist2D, direction: Array) -> Twist2D | None:
    """Return a command without what leads in a direction, (2,); None where that is not a small part of it."""
    towards = command.vx * direction[0] + command.vy * direction[1]
    if not 0.0 < towards <= SIDEWAYS * command.speed:
        return None
    return Twist2D(command.vx - towards * direction[0], command.vy - towards * direction[1], command.omega)


def _part(command: Twist2D, offended: Callable[[Twist2D], _Offended | None]) -> Twist2D:
    """Return the largest part of a command that offends nothing; standing still is what remains."""
    safe, unsafe = 0.0, 1.0
    if offended(command) is None:
        return command
    for _ in range(HALVINGS):
        middle = 0.5 * (safe + unsafe)
        if offended(Twist2D(middle * command.vx, middle * command.vy, command.omega)) is None:
            safe = middle
        else:
            unsafe = middle
    return Twist2D(safe * command.vx, safe * command.vy, command.omega)


@numba.njit(cache=True)
def _approaches(
    points: Array,
    velocities: Array,
    twist: Array,
    target: Array,
    holds: Array,
    duration: float,
    max_acceleration: float,
    max_yaw_acceleration: float,
) -> tuple[Array, Array]:
    """Return how near points come to the robot's centre, (n,) [m], and in which direction each then is, (n, 2).

    The base ramps to the target, holds it until the brakes hold, which is at any of some times, and brakes.

    Args:
        points: In the body frame at the start, shape (n, 2) [m].
        velocities: Along its axes, shape (n, 2) [m/s].
        twist: Of the body at the start: vx, vy [m/s], omega [rad/s].
        target: The same, commanded.
        holds: Times at which the brakes may begin to hold, shape (k,) [s].
        duration: Of the prediction [s].
        max_acceleration: [m/s^2].
        max_yaw_acceleration: [rad/s^2].
    """
    squared = np.full(len(points), np.inf)
    offsets = np.zeros((len(points), 2))
    for hold in holds:
        way = _way(twist, target, hold, duration, max_acceleration, max_yaw_acceleration)
        for i in range(len(points)):
            vx, vy = velocities[i]
            for step in range(len(way)):
                dx = points[i, 0] + step * STEP * vx - way[step, 0]
                dy = points[i, 1] + step * STEP * vy - way[step, 1]
                if vx != 0.0 or vy != 0.0:
                    # They may be there sooner: of their way within the foresight, the nearest point counts.
                    ahead = -(dx * vx + dy * vy) / max(vx * vx + vy * vy, 1e-12)
                    ahead = min(max(ahead, 0.0), FORESIGHT)
                    dx, dy = dx + ahead * vx, dy + ahead * vy
                if dx * dx + dy * dy < squared[i]:
                    squared[i] = dx * dx + dy * dy
                    offsets[i, 0], offsets[i, 1] = dx, dy
    nearest = np.hypot(offsets[:, 0], offsets[:, 1])
    return nearest, offsets / np.maximum(nearest, 1e-9).reshape(-1, 1)


@numba.njit(cache=True)
def _way(
    twist: Array, target: Array, hold: float, duration: float, max_acceleration: float, max_yaw_acceleration: float
) -> Array:
    """Return where the base is after each step, x and y in the body frame at the start, shape (n, 2) [m]."""
    steps = math.ceil(duration / STEP) + 1
    way = np.zeros((steps + 1, 2))
    x, y, yaw = 0.0, 0.0, 0.0
    vx, vy, omega = twist
    for step in range(steps):
        holds = step * STEP < hold
        change_x, change_y = (target[0] if holds else 0.0) - vx, (target[1] if holds else 0.0) - vy
        part = min(1.0, max_acceleration * STEP / max(math.hypot(change_x, change_y), 1e-9))
        turn = (target[2] if holds else 0.0) - omega
        next_omega = omega + min(max(turn, -max_yaw_acceleration * STEP), max_yaw_acceleration * STEP)
        mean_x, mean_y = vx + 0.5 * part * change_x, vy + 0.5 * part * change_y
        middle = yaw + 0.25 * (omega + next_omega) * STEP
        c, s = math.cos(middle), math.sin(middle)
        x, y = x + STEP * (c * mean_x - s * mean_y), y + STEP * (s * mean_x + c * mean_y)
        yaw += 0.5 * (omega + next_omega) * STEP
        vx, vy, omega = vx + part * change_x, vy + part * change_y, next_omega
        way[step + 1, 0], way[step + 1, 1] = x, y
    return way
