"""When things begin: at a time, when the robot moves, when it comes near, when it asks people to make way."""

from __future__ import annotations

from dataclasses import dataclass

from han_bullet.geometry import Pose2D
from han_bullet.world_schema import Trigger

MOVING_SPEED = 0.05  # [m/s]; from here on the robot counts as having moved


@dataclass(frozen=True)
class RobotNow:
    """What people and devices can notice of the robot.

    Attributes:
        time: [s].
        pose_in_world: True pose.
        speed: True speed [m/s].
        requests_hand_over: Whether it asks for the person's attention.
        requests_way: Whether it asks people to make way.
    """

    time: float
    pose_in_world: Pose2D
    speed: float
    requests_hand_over: bool = False
    requests_way: bool = False


class StartSignal:
    """Watch for a trigger's event and stay on once its delay has passed."""

    def __init__(self, trigger: Trigger) -> None:
        self._trigger = trigger
        self._event: float | None = 0.0 if trigger.when == "time" else None

    def given(self, robot: RobotNow, position_in_world: tuple[float, float]) -> bool:
        """Tell whether it is time.

        Args:
            robot: The robot now; call this often, an event between two calls is missed.
            position_in_world: Of the one who waits [m].
        """
        if self._event is None and self._happens(robot, position_in_world):
            self._event = robot.time
        return self._event is not None and robot.time >= self._event + self._trigger.delay - 1e-9

    def _happens(self, robot: RobotNow, position_in_world: tuple[float, float]) -> bool:
        if self._trigger.when == "robot_moves":
            return robot.speed > MOVING_SPEED
        if self._trigger.when == "robot_asks":
            return robot.requests_way
        return robot.pose_in_world.distance_to(position_in_world) <= self._trigger.distance
