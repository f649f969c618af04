"""Put a stack together for a world: the one place where a world's parameters meet the stages' constructors."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from han_bullet.control.follower import Follower
from han_bullet.control.protective_stop import ProtectiveStop
from han_bullet.control.proximity import SMALLEST_GAP, ProximityLimit
from han_bullet.control.recovery import Clearable, Recovery
from han_bullet.costmap.body import BodyLayer
from han_bullet.costmap.grid import Costmap
from han_bullet.costmap.layer import Layer
from han_bullet.costmap.layers import standard_layers
from han_bullet.detection.camera_detector import FrameDetector
from han_bullet.device_channel import SIMULATED
from han_bullet.errors import BadInputError
from han_bullet.geometry import Pose2D
from han_bullet.health.sensor_health import SensorHealth
from han_bullet.known_devices import KnownDevices
from han_bullet.localization.lidar import LidarLocalization
from han_bullet.localization.localizer import Localization
from han_bullet.localization.odometry_model import OdometryModel
from han_bullet.messages import Device, GoTo, HandOver, Task
from han_bullet.planning.planner import Planner
from han_bullet.situation import Situation
from han_bullet.stack import NavigationStack
from han_bullet.static_map import building_map
from han_bullet.tracking.association import Association, GlobalNearestNeighbour, NearestNeighbour
from han_bullet.tracking.field_of_view import FieldOfView
from han_bullet.tracking.legs import LaserLegs, LegFinder
from han_bullet.tracking.nnjpda import Nnjpda
from han_bullet.tracking.projection import GroundProjection
from han_bullet.tracking.tracker import MultiCameraTracker, PeopleTracker
from han_bullet.world_schema import CONTROL_PERIOD, GoToTask, World

ASSOCIATIONS: dict[str, type[Association]] = {
    "nnjpda": Nnjpda,
    "nn": NearestNeighbour,
    "gnn": GlobalNearestNeighbour,
}

OF_LOCALIZATION = 2  # its random numbers are none of the simulator's, which are the streams before
HULL_MARGIN = 0.05  # [m]: what of a robot hides people is a little wider than its footprint: wheels, rim


def build_tracker(world: World, association: str = "nnjpda") -> MultiCameraTracker:
    """Return the tracker of people for a world.

    Raises:
        BadInputError: The association has no such name.
    """
    if association not in ASSOCIATIONS:
        raise BadInputError(f"association {association!r} is not known; there are {', '.join(ASSOCIATIONS)}")
    return MultiCameraTracker(
        field_of_view=field_of_view(world),
        seats=world.seats(),
        floor=world.floor,
        association=ASSOCIATIONS[association](),
    )


def build_localization(world: World, start: Pose2D, seed: int) -> Localization:
    """Return the localization by laser for a world.

    Args:
        world: Its building is the map, at the scanner's height.
        start: Where the robot was put, as far as the robot knows; a seed's variation is what it does not know.
        seed: Of what it draws.

    Raises:
        BadInputError: The robot has no laser.
    """
    if world.robot.laser is None:
        raise BadInputError(f"world {world.name!r} has a robot without laser; localization truth would be right")
    away, turned = world.seed_varies.robot_start, world.seed_varies.heading  # either way, uniformly: variance a^2 / 3
    return LidarLocalization(
        building_map(world),
        start,
        np.diag([away**2, away**2, turned**2]) / 3.0 + np.diag([1e-4, 1e-4, 1e-4]),
        np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(OF_LOCALIZATION,))),
        odometry_model=OdometryModel(slip=world.robot.slip.distance, yaw_per_way=world.robot.slip.heading),
    )


def field_of_view(world: World) -> FieldOfView:
    """Return what the world's building and robot let cameras see."""
    return FieldOfView(world.solid_boxes(), robot_radius=world.robot.radius + HULL_MARGIN)


def build_projection(world: World) -> GroundProjection:
    """Return what places detected people on the world's floor."""
    return GroundProjection(
        robot_radius=world.robot.radius, floor=world.floor, obstacles=world.solid_boxes(), seats=world.seats()
    )


def build_stack(
    world: World,
    *,
    localization: Localization,
    detector: FrameDetector,
    tracker: PeopleTracker,
    leg_finder: LegFinder | None = None,
    without: Collection[str] = (),
    pass_side: str = "left",
    layers: Sequence[Layer] = (),
    devices: KnownDevices | None = None,
    sees: bool = True,
    own_senses: bool = True,
) -> NavigationStack:
    """Return the stack for a world.

    Args:
        world: The concrete world.
        localization: Says where the robot is.
        detector: Finds people in frames.
        tracker: Follows them on the floor.
        leg_finder: Finds their legs; None looks for them in the laser's scans.
        without: Names of layers to leave out.
        pass_side: On which side of walking people the robot overtakes, "left" or "right".
        layers: Further layers, applied after the standard ones.
        devices: Of `known_devices`, to look into them; None makes them.
        sees: Whether the robot relies on the world's cameras, whose health is then watched.
        own_senses: Whether observations hold laser and odometry; those of a replay do not.

    Raises:
        BadInputError: A layer or a layer's parameter that does not exist, or a layer without a name.
    """
    for layer in layers:
        if not isinstance(getattr(layer, "name", None), str):
            raise BadInputError(f"layer {type(layer).__name__} has no name; a class attribute `name` would be right")
    robot, settings = world.robot, world.costmap
    task = task_of(world)
    layers = [
        *standard_layers(
            world.solid_boxes(),
            robot_radius=robot.radius,
            robot_speed=robot.max_speed,
            inflation_radius=settings.inflation_radius,
            cost_scaling_factor=settings.cost_scaling_factor,
            pass_side=pass_side,
            without=without,
            parameters=world.layers,
        ),
        *layers,
    ]
    return NavigationStack(
        localization=localization,
        detector=detector,
        projection=build_projection(world),
        leg_finder=leg_finder or LaserLegs(obstacles=world.solid_boxes(), seats=world.seats()),
        tracker=tracker,
        situation=Situation(task=task, devices=devices or known_devices(world), seats=world.seats()),
        free_space=Costmap.covering(world.floor_intervals(), settings.resolution),
        layers=layers,
        planner=build_planner(world, layers),
        follower=Follower(
            radius=robot.radius,
            max_speed=robot.max_speed,
            max_acceleration=robot.max_acceleration,
            max_yaw_rate=robot.max_yaw_rate,
            max_yaw_acceleration=robot.max_yaw_acceleration,
            tolerance=world.task.tolerance,
            control_period=CONTROL_PERIOD,
            proximity=_proximity(world, layers),
        ),
        protective_stop=ProtectiveStop(
            radius=robot.radius,
            max_acceleration=robot.max_acceleration,
            max_yaw_acceleration=robot.max_yaw_acceleration,
        ),
        recovery=Recovery(
            relocalize=localization.relocalize,
            obstacles=[layer for layer in layers if isinstance(layer, Clearable)],
            wait=world.recovery.wait,
            clear=world.recovery.clear,
            ask=world.recovery.ask,
            search=world.recovery.relocalize,
        ),
        health=sensor_health(world, sees=sees, own_senses=own_senses),
    )


def build_planner(world: World, layers: Sequence[Layer]) -> Planner:
    """Return the planner for a world and the layers of its costmap, of which one says how large people are."""
    settings = world.costmap
    radii = [layer.largest_radius for layer in layers if isinstance(layer, BodyLayer)]
    return Planner(
        weight=settings.astar_weight,
        replan_period=1.0 / settings.replan_rate,
        largest_body=max(radii, default=0.0) + settings.resolution,
    )


def _proximity(world: World, layers: Sequence[Layer]) -> ProximityLimit:
    """Return how the robot slows down near people, who are as large as on the costmap, and whose rim is near enough."""
    robot = world.robot
    bodies = [layer for layer in layers if isinstance(layer, BodyLayer)]
    body = bodies[0] if bodies else BodyLayer(robot_radius=robot.radius)
    return ProximityLimit(
        robot_radius=robot.radius,
        max_deceleration=robot.max_acceleration,
        body_radius=body.body_radius,
        smallest_gap=min(SMALLEST_GAP, 0.8 * body.smallest_margin),  # a start at the rim is allowed
    )


def sensor_health(world: World, *, sees: bool, own_senses: bool) -> SensorHealth:
    """Return what watches the cameras and the robot's own senses, its laser and its wheels."""
    periods = {camera.name: camera.ticks_per_frame * CONTROL_PERIOD for camera in world.cameras if sees}
    robot = world.robot
    laser = robot.laser.ticks_per_scan * CONTROL_PERIOD if robot.laser is not None and own_senses else None
    slip = robot.slip if own_senses else None
    return SensorHealth(periods, noisy=world.image_noise > 0.0, laser=laser, slip=slip, seats=world.seats())


def task_of(world: World) -> Task:
    """Return the robot's task as the stack knows it."""
    task = world.task
    if isinstance(task, GoToTask):
        return GoTo(Pose2D(*task.pose))
    return HandOver(np.array(task.place), task.distance)


def known_devices(world: World, session: str = SIMULATED) -> KnownDevices:
    """Return the devices, taken to be off until their first message; the session is that of the simulated ones."""
    devices = [Device(device.name, np.array(device.position), on=False) for device in world.devices]
    return KnownDevices(devices, session=session)
