"""The simulated world: one command in, one observation out; the truth by another way."""

from __future__ import annotations

from dataclasses import replace
from types import TracebackType

import numpy as np
import pybullet

from han_bullet.device_channel import DeviceChannel, EmbeddedChannel
from han_bullet.geometry import Twist2D
from han_bullet.messages import CameraImage, LaserScan, Observation, Truth
from han_bullet.sim.contacts import ContactSensor
from han_bullet.sim.devices import Television
from han_bullet.sim.faults import CameraFaults, Faults, Shot
from han_bullet.sim.laser import LaserScanner
from han_bullet.sim.odometry import WheelOdometry
from han_bullet.sim.pedestrian import Pedestrian
from han_bullet.sim.renderer import FrameSource, Image
from han_bullet.sim.robot import MecanumRobot
from han_bullet.sim.room import CollisionRoom
from han_bullet.sim.scene_state import SceneState
from han_bullet.sim.trigger import RobotNow, StartSignal
from han_bullet.sim.viewer import Viewer
from han_bullet.world_schema import CONTROL_PERIOD, LASER, PHYSICS_PERIOD, World

GRAVITY = -9.81  # [m/s^2]
STEPS_PER_TICK = round(CONTROL_PERIOD / PHYSICS_PERIOD)


class Simulator:
    """Simulate a world tick by tick.

    Attributes:
        world: As given.
        channel: The network of the devices.
    """

    def __init__(
        self,
        world: World,
        *,
        renderer: FrameSource | None,
        seed: int = 0,
        gui: bool = False,
        channel: DeviceChannel | None = None,
    ) -> None:
        """Load the world; call reset before the first step.

        Args:
            world: A concrete world; nothing in here varies it.
            renderer: Takes the pictures, and stays the caller's to close; None gives observations without frames.
            seed: Of the errors of odometry and laser, and of what faults of the world lose.
            gui: Whether to open a window on the scene.
            channel: Network of the devices, and stays the caller's to close; None takes one inside this process.

        Raises:
            BadInputError: A URDF or a texture does not exist.
        """
        self.world = world
        self._frame_source = renderer
        self._mounts = {camera.name: camera.mount for camera in world.cameras}  # computed once
        self._seed = seed
        self.channel = channel or EmbeddedChannel()
        self._viewer = Viewer(world) if gui else None
        self._client: int | None = None
        self._is_new = False
        try:
            self._load()
        except BaseException:
            self.close()
            raise

    def reset(self) -> Observation:
        """Put everything back to the start and return the first observation, with a frame of every camera."""
        if not self._is_new:
            self._load()
        self._is_new = False
        return self._observe()

    def step(self, command: Twist2D) -> Observation:
        """Advance by one control period [0.05 s] under a command, a twist in the body frame."""
        self._robot.command(command)
        for _ in range(STEPS_PER_TICK):
            self._step_physics()
        self._tick += 1
        for person in self._people:
            person.pose_body(CONTROL_PERIOD)
        self._odometry.advance(self._robot.pose_in_world, self._faults.slip)
        return self._observe()

    def request_hand_over(self, active: bool) -> None:
        """Let the robot ask for the attention of people who then turn to it, or stop asking."""
        self._requests_hand_over = active

    def request_way(self, active: bool) -> None:
        """Let the robot ask people to make way, or stop asking."""
        self._requests_way = active

    @property
    def truth(self) -> Truth:
        """Return the simulator's own state at this tick; never part of an observation."""
        return self._truth

    @property
    def truth_time(self) -> float:
        """Return the time simulated so far [s]."""
        return self._tick * CONTROL_PERIOD

    @property
    def render_state(self) -> SceneState:
        """Return what a picture taken now depends on."""
        people = tuple(person.body_pose for person in self._people)
        truth = self._truth
        return SceneState(self.truth_time, self._tick, self._robot.posture, people, truth.devices_on, truth.taken_away)

    def close(self) -> None:
        """Close the physics and the window; the frame source stays open."""
        if self._client is not None:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = None
        if self._viewer is not None:
            self._viewer.close()
            self._viewer = None

    def __enter__(self) -> Simulator:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _load(self) -> None:
        """Build the physics from nothing: an engine that has run before keeps caches that change the last bits."""
        if self._client is not None:
            pybullet.disconnect(physicsClientId=self._client)
        self._client = client = pybullet.connect(pybullet.DIRECT)
        pybullet.setGravity(0.0, 0.0, GRAVITY, physicsClientId=client)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=PHYSICS_PERIOD, deterministicOverlappingPairs=1, physicsClientId=client
        )
        self._room = room = CollisionRoom(client, self.world.all_boxes())
        self._ends = {piece: StartSignal(piece.until) for piece in self.world.furniture if piece.until is not None}
        self._taken_away: tuple[str, ...] = ()
        self._people = [Pedestrian(client, person, self.world) for person in self.world.people]
        self._robot = MecanumRobot(client, self.world.robot)
        self._devices = [Television(tv) for tv in self.world.devices]
        bodies = {body: (box.name, box.kind) for body, box in room.bodies.items()}
        bodies |= {person.body: (person.name, "person") for person in self._people}
        self._contacts = ContactSensor(client, self._robot.body, bodies)
        self._faults = Faults(self.world, self._seed)
        self._camera_faults = CameraFaults(self.world.cameras, self._faults)
        self._load_senses()
        self._tick, self._step = 0, 0
        self._requests_hand_over = self._requests_way = False
        self._truth = self._look()
        self._is_new = True  # nothing has moved, nobody has been told anything

    def _load_senses(self) -> None:
        """Mount odometry and laser, their errors drawn anew from the seed, each from a row of its own."""
        laser_rng, slip_rng = map(np.random.default_rng, np.random.SeedSequence(self._seed).spawn(2))
        settings, robot = self.world.robot, self._robot
        self._laser = LaserScanner(self.world, settings.laser, laser_rng) if settings.laser is not None else None
        self._odometry = WheelOdometry(robot.wheels, settings.slip, robot.pose_in_world, slip_rng)

    def _step_physics(self) -> None:
        robot = self._robot_now()
        self._take_away(robot)
        for device in self._devices:
            device.advance(robot)
        for person in self._people:
            person.advance(robot, PHYSICS_PERIOD)
        self._robot.drive()
        pybullet.stepSimulation(physicsClientId=self._client)
        self._robot.measure()
        self._contacts.sample()
        self._step += 1

    def _take_away(self, robot: RobotNow) -> None:
        """Take away the furniture whose time has come."""
        for piece in [piece for piece, end in self._ends.items() if end.given(robot, piece.position)]:
            del self._ends[piece]
            self._taken_away += (piece.name,)
            self._room.take_away(piece.name)
            if self._laser is not None:
                self._laser.take_away(piece.name)

    def _robot_now(self) -> RobotNow:
        time, robot = self._step * PHYSICS_PERIOD, self._robot
        requests = self._requests_hand_over, self._requests_way
        return RobotNow(time, robot.pose_in_world, robot.twist_in_body.speed, *requests)

    def _look(self) -> Truth:
        return Truth(
            self.truth_time,
            self._robot.pose_in_world,
            self._robot.twist_in_body,
            tuple(person.truth for person in self._people),
            tuple((device.name, device.on) for device in self._devices),
            self._contacts.read(),
            self._taken_away,
        )

    def _observe(self) -> Observation:
        for device in self._devices:
            device.advance(self._robot_now())
        self._faults.update(self._robot_now())
        self._truth = self._look()
        if self._viewer is not None:
            self._viewer.show(self.render_state)
        time = self.truth_time
        for device in self._devices:
            device.tell(time, self.channel, lost=self._faults.loses(device.name, self._tick))
        return Observation(time, self._odometry.read(time), self._scan(), self._images(), self.channel.receive())

    def _scan(self) -> LaserScan | None:
        """Sweep the laser when it is due."""
        settings = self.world.robot.laser
        if self._laser is None or settings is None or self._tick % settings.ticks_per_scan:
            return None
        if self._faults.loses(LASER, self._tick):
            return None
        people = [person.body_pose for person in self._people]
        return self._laser.scan(self.truth_time, self._truth.pose_robot_in_world, people)

    def _images(self) -> tuple[CameraImage, ...]:
        """Take the pictures that arrive."""
        if self._frame_source is None:
            return ()
        state = self.render_state
        shots = self._camera_faults.take(state)
        if not shots:
            return ()
        unusual = tuple(shot.exposure for shot in shots if shot.exposure != state.exposure_of(shot.camera.name))
        names = [shot.camera.name for shot in shots]
        images = self._frame_source.render(names, replace(state, exposures=unusual))
        return tuple(self._image(*pair) for pair in zip(shots, images, strict=True))

    def _image(self, shot: Shot, image: Image) -> CameraImage:
        camera = shot.camera
        return CameraImage(
            camera.name, shot.exposure.time, image, camera.intrinsics, self._mounts[camera.name], camera.fixed
        )
