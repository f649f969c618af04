"""A real robot's configuration with all that the files hold which it names: world, calibrations, empty scenes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from han_bullet.calibration.calibration import Calibration
from han_bullet.detection.pictures import Image, check_picture, read_picture
from han_bullet.errors import BadInputError
from han_bullet.geometry import Pose2D
from han_bullet.mounted_camera import MountedCamera
from han_bullet.ros.live_config import CameraSource, LiveConfig, absolute, read_config
from han_bullet.world_file import find_world, load_world
from han_bullet.world_schema import Camera, CeilingCamera, Laser, World, check_sensor_names

LOOKS_AT = 5.0  # [m] along the view
LEAST_TILT = 0.1  # [m] aside over that way
FIELDS_OF_VIEW = (5.1, 119.9)  # [deg], that a world's camera may have
RATE = 10.0  # [Hz] of a calibrated camera


@dataclass(frozen=True)
class LiveCamera:
    """A real camera.

    Attributes:
        mounted: As the stack knows it.
        topic: Of its images.
        period: Between two that are used, at least [s].
        calibration: Undoes its lens's distortion; None: there is none.
        empty_scene: What it sees without people, shape (height, width, 3), RGB; None: nobody knows.
    """

    mounted: MountedCamera
    topic: str
    period: float
    calibration: Calibration | None
    empty_scene: Image | None


@dataclass(frozen=True)
class LiveSetup:
    """A robot's configuration with all that its files hold.

    Attributes:
        world: Building, robot, seats, task; of its cameras those in use, without people.
        cameras: In the order of the file.
        odometry, command, goal: Topics.
        laser: Topic, or None.
        scanner_in_body: Where the scanner is on the robot.
        mqtt: Address of the devices' broker, or None.
        localization: "lidar" or "odometry".
    """

    world: World
    cameras: tuple[LiveCamera, ...]
    odometry: str
    command: str
    goal: str
    laser: str | None
    scanner_in_body: Pose2D
    mqtt: str | None
    localization: str


def load_live_setup(path: Path) -> LiveSetup:
    """Read a configuration and the files that it names, which lie relative to it.

    Raises:
        BadInputError: One of the files is missing or not what it should be; the message has file and field.
    """
    config, folder = read_config(path), path.parent
    try:
        world = load_world(_world(config.world, folder))
        pairs = [_camera(source, world, folder) for source in config.cameras]
        laser = _laser(config, world)
        _check_names([source.name for source in config.cameras], world)
    except BadInputError as error:
        raise BadInputError(f"{path}: {error}") from error
    robot = world.robot.model_copy(update={"laser": laser})
    cameras = tuple(camera for camera, _ in pairs)
    mount = config.laser.mount if config.laser is not None else None
    return LiveSetup(
        world=world.model_copy(
            update={"robot": robot, "cameras": tuple(known for _, known in pairs), "people": (), "faults": ()}
        ),
        cameras=cameras,
        odometry=absolute(config.odometry.topic),
        command=absolute(config.command.topic),
        goal=absolute(config.goal.topic),
        laser=None if config.laser is None else absolute(config.laser.topic),
        scanner_in_body=Pose2D(*mount) if mount else Pose2D(0.0 if laser is None else laser.forward, 0.0, 0.0),
        mqtt=config.mqtt,
        localization=config.localization,
    )


def _world(name: str, folder: Path) -> str | Path:
    """Return a world file beside the configuration, or a shipped world's name."""
    beside = folder / name
    return beside if beside.suffix in {".yaml", ".yml"} and beside.is_file() else find_world(name)


def _check_names(cameras: Sequence[str], world: World) -> None:
    """Raise BadInputError unless real cameras and the world's devices can be told apart, and from laser and wheels."""
    try:
        check_sensor_names(cameras, [device.name for device in world.devices])
    except ValueError as error:
        raise BadInputError(str(error)) from error


def _camera(source: CameraSource, world: World, folder: Path) -> tuple[LiveCamera, Camera]:
    """Return a camera and what a world file would say of it."""
    if source.calibration is None:
        known = world.camera(source.name)
        known = known.model_copy(update={"rate": source.rate or known.rate})
        calibration, mounted = None, MountedCamera.of_world(known)
    else:
        calibration = Calibration.load(folder / source.calibration)
        mounted = MountedCamera(source.name, calibration.intrinsics, calibration.camera_in_world, fixed=True)
        known = _stand_in(mounted, source.rate or RATE)
    empty = None if source.empty_scene is None else _empty_scene(mounted, folder / source.empty_scene)
    if empty is not None and calibration is not None:
        empty = calibration.undistort(empty)
    return LiveCamera(mounted, absolute(source.topic), 1.0 / known.rate, calibration, empty), known


def _stand_in(camera: MountedCamera, rate: float) -> CeilingCamera:
    """Return the camera of a world file that is most like a calibrated one: what has to do with pixels never asks it.

    Its rate is what its health is watched by, and its place is shown on ROS; roll and the image's middle are lost.
    """
    place, view = camera.mount[:3, 3], camera.mount[:3, 2]
    if np.hypot(*(LOOKS_AT * view[:2])) < LEAST_TILT:
        raise BadInputError(f"camera {camera.name!r} looks straight down, where nobody is recognized; tilt it")
    angle = 2.0 * np.degrees(np.arctan(0.5 * camera.intrinsics.height / camera.intrinsics.fy))
    return CeilingCamera(
        name=camera.name,
        position=tuple(place.tolist()),
        look_at=tuple((place + LOOKS_AT * view).tolist()),
        vertical_field_of_view=float(np.clip(angle, *FIELDS_OF_VIEW)),
        size=(camera.intrinsics.width, camera.intrinsics.height),
        rate=rate,
    )


def _empty_scene(camera: MountedCamera, path: Path) -> Image:
    if not camera.fixed:
        raise BadInputError(f"camera {camera.name!r} is on the robot and has no empty scene; leave empty_scene out")
    check_picture(path)
    image = read_picture(path)
    size = camera.intrinsics.width, camera.intrinsics.height
    if image.shape[1::-1] != size:
        raise BadInputError(
            f"empty_scene {path} is {image.shape[1]} x {image.shape[0]} px; {size[0]} x {size[1]} is right"
        )
    return image


def _laser(config: LiveConfig, world: World) -> Laser | None:
    """Return the world file's laser, at the rate of the real one."""
    if config.laser is None:
        return None
    known = world.robot.laser or Laser()
    return known.model_copy(update={"rate": config.laser.rate or known.rate})
