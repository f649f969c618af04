"""The stack for a real robot: the same as in the simulation, put together from its configuration."""

from __future__ import annotations

from han_bullet.assembly import build_localization, build_stack, build_tracker, known_devices
from han_bullet.detection.model_files import DEFAULT
from han_bullet.detection_workers import DetectionWorkers
from han_bullet.detector_choice import DetectorChoice
from han_bullet.device_channel import DeviceChannel
from han_bullet.localization.dead_reckoning import DeadReckoning
from han_bullet.localization.localizer import Localization
from han_bullet.localization.odometry_model import OdometryModel
from han_bullet.ros.live_setup import LiveSetup
from han_bullet.stack import NavigationStack


def build_eyes(setup: LiveSetup, count: int) -> DetectionWorkers:
    """Return what looks for people in the cameras' images, in at most so many processes."""
    world = setup.world
    return DetectionWorkers(
        [camera.mounted for camera in setup.cameras],
        {camera.mounted.name: camera.empty_scene for camera in setup.cameras if camera.empty_scene is not None},
        world.seats(),
        world.solid_boxes(),
        DetectorChoice(DEFAULT, world.score_threshold),
        count,
    )


def build_live_stack(setup: LiveSetup, eyes: DetectionWorkers, devices: DeviceChannel) -> NavigationStack:
    """Return the stack, whose detector is `eyes`; the robot begins where the world file puts it, standing."""
    world = setup.world
    return build_stack(
        world,
        localization=_localization(setup),
        detector=eyes,
        tracker=build_tracker(world),
        devices=known_devices(world, devices.session),
    )


def _localization(setup: LiveSetup) -> Localization:
    robot = setup.world.robot
    if setup.localization == "odometry":
        model = OdometryModel(slip=robot.slip.distance, yaw_per_way=robot.slip.heading)
        return DeadReckoning(robot.start_pose_in_world, model)
    return build_localization(setup.world, robot.start_pose_in_world, seed=0)
