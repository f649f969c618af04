"""How the robot moved: speed, acceleration, jerk, turning."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from han_bullet.episode import Tick
from han_bullet.geometry import Array, wrap_angle
from han_bullet.metrics.tally import Definition, Definitions, Tally, Value

STRIDE = 0.1  # [m]: directions of travel over less are noise of a base that stands

_ACCELERATION = (
    "absolute change of the robot's true velocity vector in the world between ticks, over dt (of the place: over dt^2)"
)
_JERK = (
    "absolute second difference of the robot's true velocity vector in the world, over dt^2 (of the place: third "
    "difference over dt^3)"
)


class MotionTally(Tally):
    """How the robot moved."""

    group = "motion"
    definitions: ClassVar[Definitions] = {
        "mean_speed": Definition(
            "m/s",
            "mean over all ticks of the robot's true translational speed, standing included",
            elsewhere="Francis2023: V_avg; HuNav: avg_robot_linear_speed; SocNavBench: robot_speed",
            headline=True,
        ),
        "max_speed": Definition(
            "m/s",
            "largest true translational speed of the robot at a tick",
            elsewhere="Francis2023: V_max",
            headline=True,
        ),
        "mean_acceleration": Definition("m/s^2", f"mean {_ACCELERATION}", "lower", "Francis2023: A_avg"),
        "max_acceleration": Definition(
            "m/s^2",
            f"largest {_ACCELERATION}",
            "lower",
            "Francis2023: A_max; SocNavBench: acceleration",
            headline=True,
        ),
        "mean_jerk": Definition(
            "m/s^3",
            f"mean {_JERK}",
            "lower",
            "Francis2023: J_avg; HuNav: avg_overacceleration, of the speed's first difference",
        ),
        "max_jerk": Definition("m/s^3", f"largest {_JERK}", "lower", "Francis2023: J_max; SocNavBench: jerk"),
        "cumulative_heading_change": Definition(
            "rad",
            "sum of the absolute turns of the robot's true yaw between ticks, each wrapped to [-pi, pi); the first yaw "
            "is no turn",
            "lower",
            "HuNav: cumulative_heading_changes",
            headline=True,
        ),
        "path_irregularity": Definition(
            "rad/m",
            "unnecessary turning of the direction of travel per metre: (sum of absolute turns between chords - "
            f"absolute angle between first and last chord) / chords' length; a chord ends where the true centre first "
            f"is {STRIDE:g} m or more from its beginning. Wherever the base faces, wherever the origin is; 0 on a "
            "straight line or one steady bend below half a circle; none with fewer than two chords",
            "lower",
            "SocNavBench: path_irregularity, there from the origin; SEAN: path irregularity, above a searched way's, "
            "in rad",
        ),
    }

    def __init__(self) -> None:
        self._rows: list[tuple[float, ...]] = []  # time, x, y, yaw, velocity in the world

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        pose, twist = tick.truth.pose_robot_in_world, tick.truth.twist_robot_in_body
        self._rows.append((tick.truth.time, pose.x, pose.y, pose.yaw, *twist.linear_in_world(pose.yaw)))

    def values(self) -> dict[str, Value]:
        """Return speeds, their changes, and turns."""
        if not self._rows:
            return dict.fromkeys(self.definitions)
        rows = np.array(self._rows)
        time, yaw, velocity = rows[:, 0], rows[:, 3], rows[:, 4:]
        step = np.diff(time)[:, None]
        acceleration = np.diff(velocity, axis=0) / step
        jerk = np.diff(acceleration, axis=0) / step[1:]
        values: tuple[Value, ...] = (
            *_mean_and_max(velocity),
            *_mean_and_max(acceleration),
            *_mean_and_max(jerk),
            float(np.abs(wrap_angle(np.diff(yaw))).sum()),
            path_irregularity(rows[:, 1:3]),
        )
        return dict(zip(self.definitions, values, strict=True))


def path_irregularity(places: Array) -> float | None:
    """Return the unnecessary turning [rad/m] of a way, shape (n, 2) [m]; None where it has fewer than two chords."""
    ends = [places[0]]
    for place in places:
        if math.dist(place, ends[-1]) >= STRIDE:
            ends.append(place)
    if len(ends) < 3:
        return None
    chords = np.diff(ends, axis=0)
    directions = np.arctan2(chords[:, 1], chords[:, 0])
    turned = float(np.abs(wrap_angle(np.diff(directions))).sum())
    needed = abs(wrap_angle(float(directions[-1] - directions[0])))
    return max(0.0, turned - needed) / float(np.hypot(*chords.T).sum())


def _mean_and_max(vectors: Array) -> tuple[float, float]:
    """Return the mean and largest norm of vectors, shape (n, 2); 0 of none."""
    norms = np.hypot(vectors[:, 0], vectors[:, 1])
    return (float(norms.mean()), float(norms.max())) if len(norms) else (0.0, 0.0)
