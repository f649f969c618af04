"""How well the robot knew where it was."""

from __future__ import annotations

import math
from typing import ClassVar

from han_bullet.episode import Tick
from han_bullet.geometry import wrap_angle
from han_bullet.metrics.tally import Definition, Definitions, Tally, Value, root_mean_square
from han_bullet.world_schema import CONTROL_PERIOD


class LocalizationTally(Tally):
    """Believed poses beside the true ones; 0 throughout where the simulator tells the pose."""

    group = "perception"
    definitions: ClassVar[Definitions] = {
        "robot_position_rmse": Definition(
            "m",
            "root mean square, over all ticks, of the distance between the robot's believed and true centre",
            "lower",
            "absolute trajectory error",
            headline=True,
        ),
        "robot_position_error_max": Definition(
            "m", "largest distance between the robot's believed and true centre at a tick", "lower", headline=True
        ),
        "robot_yaw_rmse": Definition(
            "rad",
            "root mean square, over all ticks, of the difference of the robot's believed and true yaw, wrapped to "
            "[-pi, pi)",
            "lower",
            headline=True,
        ),
        "lost_time": Definition(
            "s", "time during which the robot said that it did not know where it was; a tick counts whole", "lower"
        ),
    }

    def __init__(self) -> None:
        self._offsets: list[float] = []  # [m]
        self._turns: list[float] = []  # [rad]
        self._lost_ticks = 0

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        estimate, true = tick.decision.estimate, tick.truth.pose_robot_in_world
        believed = estimate.pose_robot_in_world
        self._offsets.append(math.hypot(believed.x - true.x, believed.y - true.y))
        self._turns.append(wrap_angle(believed.yaw - true.yaw))
        self._lost_ticks += estimate.lost

    def values(self) -> dict[str, Value]:
        """Return the errors so far."""
        if not self._offsets:
            return dict.fromkeys(self.definitions)
        return {
            "robot_position_rmse": root_mean_square(self._offsets),
            "robot_position_error_max": max(self._offsets),
            "robot_yaw_rmse": root_mean_square(self._turns),
            "lost_time": self._lost_ticks * CONTROL_PERIOD,
        }
