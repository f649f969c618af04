"""The last word on a command: the robot can always stop before what its laser scanner sees.

It knows nothing of people, map or pose: points of the scan in the body frame, the velocity, and the limits of the base.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numba
import numpy as np

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Twist2D, rotation
from han_bullet.messages import LaserScan
from han_bullet.world_schema import CONTROL_PERIOD

STEP = 0.025  # of a prediction [s]
HALVINGS = 6  # of the interval in which the largest safe part of a command is looked for
SIDEWAYS = 0.5  # a point is passed rather than approached where less of the velocity leads towards it
CREEP = 0.15  # at this speed [m/s] points are passed at NARROW
NARROW = 0.02  # [m] beyond the footprint
NO_WORSE = 1e-3  # what braking at once would come to, within this [m], no command is blamed for
SILENT = 0.5  # a scanner that has spoken before is out of order when it says nothing for so long [s]


class ProtectiveStop:
    """Limit commands so that no point of the scan comes nearer to the footprint than a clearance.

    A command is safe if the base, ramping to it from its present velocity, holding it for the reaction time and then
    braking as hard as it can, keeps the clearance from every point. Of one that is not, the largest part that is safe
    is let through: all directions but towards the point stay free, and so does moving away from one that is too near.
    A point that is only passed takes away the part of the velocity that leads towards it.
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
        limits = {
            "radius": radius,
            "max_acceleration": max_acceleration,
            "max_yaw_acceleration": max_yaw_acceleration,
            "clearance": clearance,
            "reaction": reaction,
        }
        for name, value in limits.items():
            if not 0.0 < value < math.inf:
                raise BadInputError(f"protective stop: {name} is {value!r}; it must be a positive number")
        self.radius = radius
        self.clearance = clearance
        self.reaction = reaction
        self._accelerations = (max_acceleration, max_yaw_acceleration)
        self._points_in_body: Array = np.zeros((0, 2))
        self._seen_at: float | None = None
        self._moved_at = 0.0

    def limit(self, command: Twist2D, scan: LaserScan | None, twist: Twist2D, time: float) -> tuple[Twist2D, bool]:
        """Return the command for the next control period, and whether it had to be limited.

        A limited one changes the velocity by no more than the base can in that period; the turn stays as commanded.

        Args:
            command: What the robot would do.
            scan: That arrived with this tick, or None.
            twist: By the odometry, now.
            time: [s].
        """
        if scan is not None:
            self._points_in_body, self._seen_at, self._moved_at = scan.points_in_body, scan.time, scan.time
        if self._seen_at is None:
            return command, False
        self._move_on(twist, time)
        if time - self._seen_at > SILENT:
            return self._ramped(Twist2D(0.0, 0.0, command.omega), twist), True
        points = self._within_reach(command, twist)
        allowed = self._largest_safe(command, twist, points)
        return (command, False) if allowed is command else (self._ramped(allowed, twist), True)

    def _move_on(self, twist: Twist2D, time: float) -> None:
        """Let the points pass by as the robot moves."""
        duration, self._moved_at = time - self._moved_at, time
        moved = duration * np.array([twist.vx, twist.vy])
        self._points_in_body = (self._points_in_body - moved) @ rotation(twist.omega * duration)

    def _within_reach(self, command: Twist2D, twist: Twist2D) -> Array:
        """Return the points, (n, 2) [m], that the robot could come near to before it stands."""
        farthest = max(command.speed, twist.speed) * self._duration(command, twist) + self.radius + self.clearance
        near: Array = self._points_in_body[np.hypot(*self._points_in_body.T) <= farthest]
        return near

    def _duration(self, command: Twist2D, twist: Twist2D) -> float:
        return self.reaction + max(command.speed, twist.speed) / self._accelerations[0]

    def _largest_safe(self, command: Twist2D, twist: Twist2D, points: Array) -> Twist2D:
        """Return the command if it is safe, else the part of it, or of it along what is passed, that advances more."""
        if not len(points):
            return command
        duration = self._duration(command, twist)
        braking, _ = self._approaches(Twist2D(0.0, 0.0, command.omega), twist, points, duration)

        def offender(candidate: Twist2D) -> Array | None:
            """Return the direction, (2,), of the point that a candidate comes nearest to of those it must not."""
            distances, directions = self._approaches(candidate, twist, points, duration)
            gaps = distances - self.radius
            margin = np.full(len(points), self.clearance)
            if candidate.speed <= CREEP + 1e-9:
                towards = directions @ np.array([candidate.vx, candidate.vy])
                margin[towards <= SIDEWAYS * candidate.speed] = NARROW
            unsafe = (gaps < margin) & (distances < braking - NO_WORSE)
            nearest: Array = directions[np.where(unsafe, gaps, np.inf).argmin()]
            return nearest if unsafe.any() else None

        direction = offender(command)
        if direction is None:
            return command
        along = self._along(command, direction)
        parts = [_part(candidate, offender) for candidate in (command, along) if candidate is not None]
        return max(parts, key=lambda part: part.vx * command.vx + part.vy * command.vy)

    def _along(self, command: Twist2D, direction: Array) -> Twist2D | None:
        """Return a command without what leads in a direction, (2,); None where that is not a small part of it."""
        towards = command.vx * direction[0] + command.vy * direction[1]
        if towards > SIDEWAYS * command.speed:
            return None
        return Twist2D(command.vx - towards * direction[0], command.vy - towards * direction[1], command.omega)

    def _approaches(self, candidate: Twist2D, twist: Twist2D, points: Array, duration: float) -> tuple[Array, Array]:
        now = np.array([twist.vx, twist.vy, twist.omega])
        target = np.array([candidate.vx, candidate.vy, candidate.omega])
        return _approaches(points, now, target, self.reaction, duration, *self._accelerations)

    def _ramped(self, wanted: Twist2D, twist: Twist2D) -> Twist2D:
        """Return what the base can reach of a wanted velocity within a control period."""
        x, y = wanted.vx - twist.vx, wanted.vy - twist.vy
        part = min(1.0, self._accelerations[0] * CONTROL_PERIOD / max(math.hypot(x, y), 1e-9))
        return Twist2D(twist.vx + part * x, twist.vy + part * y, wanted.omega)


def _part(command: Twist2D, offender: Callable[[Twist2D], Array | None]) -> Twist2D:
    """Return the largest part of a command that offends nothing; standing still is what remains."""
    safe, unsafe = 0.0, 1.0
    if offender(command) is None:
        return command
    for _ in range(HALVINGS):
        middle = 0.5 * (safe + unsafe)
        if offender(Twist2D(middle * command.vx, middle * command.vy, command.omega)) is None:
            safe = middle
        else:
            unsafe = middle
    return Twist2D(safe * command.vx, safe * command.vy, command.omega)


@numba.njit(cache=True)
def _approaches(
    points: Array,
    twist: Array,
    target: Array,
    reaction: float,
    duration: float,
    max_acceleration: float,
    max_yaw_acceleration: float,
) -> tuple[Array, Array]:
    """Return how near points come to the robot's centre, (n,) [m], and in which direction each then is, (n, 2).

    The base ramps to the target, holds it until the reaction time is over, and brakes.

    Args:
        points: In the body frame at the start, shape (n, 2) [m].
        twist: Of the body at the start: vx, vy [m/s], omega [rad/s].
        target: The same, commanded.
        reaction: [s].
        duration: Of the prediction [s].
        max_acceleration: [m/s^2].
        max_yaw_acceleration: [rad/s^2].
    """
    nearest = np.full(len(points), np.inf)
    directions = np.zeros((len(points), 2))
    x, y, yaw = 0.0, 0.0, 0.0
    vx, vy, omega = twist
    steps = math.ceil(duration / STEP) + 1
    for step in range(steps + 1):
        for i in range(len(points)):
            dx, dy = points[i, 0] - x, points[i, 1] - y
            distance = math.hypot(dx, dy)
            if distance < nearest[i]:
                nearest[i] = distance
                directions[i, 0], directions[i, 1] = dx / max(distance, 1e-9), dy / max(distance, 1e-9)
        holds = step * STEP < reaction
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
    return nearest, directions
