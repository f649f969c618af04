"""All that a picture of the scene depends on, as one small value that can be sent to a rendering process."""

from __future__ import annotations

from dataclasses import dataclass

from han_bullet.geometry import Pose2D
from han_bullet.sim.gait import BodyPose

DevicesOn = tuple[tuple[str, bool], ...]  # name and state of each device


@dataclass(frozen=True)
class RobotPosture:
    """The robot as it looks.

    Attributes:
        pose_in_world: True pose.
        head_pan: To the left [rad].
        wheel_angles: Front left, front right, rear left, rear right [rad].
    """

    pose_in_world: Pose2D
    head_pan: float = 0.0
    wheel_angles: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SceneState:
    """A moment of the scene.

    Attributes:
        time: [s].
        frame_number: Of the moment; picks the image noise, so equal numbers get equal noise.
        robot: As it looks.
        people: In the order of the world file.
        devices_on: Name and state of each device.
        taken_away: Names of the furniture that is no longer there.
    """

    time: float
    frame_number: int
    robot: RobotPosture
    people: tuple[BodyPose, ...]
    devices_on: DevicesOn = ()
    taken_away: tuple[str, ...] = ()
