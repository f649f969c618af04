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
        exposures: Of the cameras with a fault; every other one shows this moment as it is.
    """

    time: float
    frame_number: int
    robot: RobotPosture
    people: tuple[BodyPose, ...]
    devices_on: DevicesOn = ()
    taken_away: tuple[str, ...] = ()
    exposures: tuple[Exposure, ...] = ()

    def exposure_of(self, camera: str) -> Exposure:
        """Return what a camera takes now."""
        faulty = (exposure for exposure in self.exposures if exposure.camera == camera)
        return next(faulty, None) or Exposure(camera, self.time, self)


@dataclass(frozen=True)
class Exposure:
    """A picture to be taken: of which moment, and what is wrong with the camera.

    Attributes:
        camera: Name of the camera.
        time: That the picture will claim as its exposure [s].
        moment: The scene that it shows; a frozen camera's is in the past.
        black: Whether no light reaches the sensor.
        turned: To the left of how the camera was mounted, about the vertical [rad].
    """

    camera: str
    time: float
    moment: SceneState
    black: bool = False
    turned: float = 0.0
