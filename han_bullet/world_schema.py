"""What a world is: the one schema of world files, as checked values.

Building, furniture, devices, cameras, people, robot, task, what a seed varies, parameters that differ from the
defaults, and what must come true. Lengths are metres, angles radians but for fields of view [deg], times seconds of
simulation time. docs/world_file.md has an annotated example; `world_file.py` reads the files.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Intrinsics, Pose2D, SolidBox, camera_on_robot, look_at
from han_bullet.messages import Seat

PHYSICS_PERIOD = 1.0 / 240.0  # [s]
CONTROL_PERIOD = 0.05  # [s]

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]
Point2 = tuple[Finite, Finite]
Point3 = tuple[Finite, Finite, Finite]
Interval = tuple[Finite, Finite]


class Part(BaseModel):
    """Base of every part of a world: unknown keys are errors, values do not change."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class FloorArea(Part):
    """An axis-parallel piece of floor; the robot may only be where some floor area is."""

    x: Interval = Field(description="from, to [m]")
    y: Interval = Field(description="from, to [m]")
    texture: str = Field("tiles", description="name of a picture in urdf/textures, without its ending")

    @model_validator(mode="after")
    def _ordered(self) -> FloorArea:
        if self.x[0] >= self.x[1] or self.y[0] >= self.y[1]:
            raise ValueError(f"floor area is empty: x {list(self.x)}, y {list(self.y)}; write [smaller, larger]")
        return self

    def contains(self, points_in_world: Array, margin: float = 0.0) -> NDArray[np.bool_]:
        """Tell which points, shape (..., 2) [m], lie on the area grown by a margin [m]."""
        lower, upper = np.array([self.x, self.y]).T
        inside = (points_in_world >= lower - margin) & (points_in_world <= upper + margin)
        return np.asarray(inside.all(axis=-1), np.bool_)


class Wall(Part):
    """A straight upright wall between two floor points, centred on their line."""

    start: Point2 = Field(description="[m]")
    end: Point2 = Field(description="[m]")
    height: Positive = Field(2.8, description="[m]")
    thickness: Positive = Field(0.1, description="[m]")
    texture: str = "plaster"


class Trigger(Part):
    """When something begins."""

    when: Literal["time", "robot_moves", "robot_near", "robot_asks"] = Field(
        "time", description="robot_asks: it asks people to make way, since it cannot go on"
    )
    delay: NonNegative = Field(0.0, description="after that event; for `time`, after the start [s]")
    distance: Positive = Field(2.0, description="for `robot_near`: between the centres [m]")


class Furniture(Part):
    """A solid piece of furniture: a box of the given size, drawn as a URDF where one is named."""

    name: Name
    position: Point2 = Field(description="centre on the floor [m]")
    yaw: Finite = Field(0.0, description="[rad]")
    size: tuple[Positive, Positive, Positive] = Field(description="along its own x, y, z [m]")
    bottom: NonNegative = Field(0.0, description="height of its lower side above the floor [m]")
    urdf: str | None = Field(None, description="file in urdf/, origin at the centre of the footprint; None draws a box")
    texture: str = "wood"
    known: bool = Field(True, description="whether it is on the robot's map")
    until: Trigger | None = Field(None, description="when it is taken away; null: never")

    @model_validator(mode="after")
    def _map_stays_true(self) -> Furniture:
        if self.known and self.until is not None:
            raise ValueError(
                f"{self.name} is on the robot's map, which never changes, and taken away; give known: false"
            )
        return self


class SittingArea(Part):
    """A place to sit, where people are seated rather than standing."""

    name: Name
    seat: Point2 = Field(description="where a seated person's body is [m]")
    facing: Finite = Field(description="direction in which one sits [rad]")
    reach_in_front: Positive = Field(0.8, description="how far before the seat the feet are looked for [m]")
    width: Positive = Field(1.9, description="extent along the seat [m]")
    watches: Name | None = Field(None, description="device that one looks at from here")


class TV(Part):
    """A television that says over the network whether it is on."""

    name: Name
    kind: Literal["tv"] = "tv"
    position: Point2 = Field(description="[m]")
    size: tuple[Positive, Positive, Positive] = Field((1.2, 0.08, 0.7), description="width, depth, height [m]")
    bottom: NonNegative = Field(0.6, description="[m]")
    facing: Finite = Field(description="direction of the screen's normal [rad]")
    on: bool = Field(False, description="at the start")
    turns_on: Trigger | None = None


def check_period(what: str, rate: float, right: str) -> None:
    """Raise unless a rate's period is an integer multiple of the control period."""
    ticks = 1.0 / (rate * CONTROL_PERIOD)
    if abs(ticks - round(ticks)) > 1e-6 or round(ticks) < 1:
        raise ValueError(
            f"{what}: the period 1/{rate:g} s is not an integer multiple of the control period {CONTROL_PERIOD} s; "
            f"{right} would be"
        )


class CameraBase(Part):
    """What ceiling and onboard cameras share."""

    name: Name
    vertical_field_of_view: Annotated[float, Field(gt=5.0, lt=120.0)] = Field(45.0, description="[deg]")
    size: tuple[Annotated[int, Field(ge=64)], Annotated[int, Field(ge=64)]] = Field((640, 480), description="[px]")
    rate: Positive = Field(10.0, description="[Hz]")

    @property
    def intrinsics(self) -> Intrinsics:
        """Return the pinhole calibration."""
        width, height = self.size
        return Intrinsics.from_vertical_field_of_view(width, height, math.radians(self.vertical_field_of_view))

    @property
    def ticks_per_frame(self) -> int:
        """Return the camera's period as a number of control ticks."""
        return round(1.0 / (self.rate * CONTROL_PERIOD))

    @model_validator(mode="after")
    def _period_is_a_multiple(self) -> CameraBase:
        check_period("the camera's rate", self.rate, "20, 10, 5 or 4 Hz")
        return self


class CeilingCamera(CameraBase):
    """A camera that hangs still."""

    fixed: ClassVar[bool] = True

    kind: Literal["ceiling"] = "ceiling"
    position: Point3 = Field(description="[m]")
    look_at: Point3 = Field(description="a point in the middle of the image [m]")

    @property
    def camera_in_world(self) -> Array:
        """Return the pose, shape (4, 4)."""
        return look_at(np.array(self.position), np.array(self.look_at))

    @property
    def mount(self) -> Array:
        """Return the pose in what the camera is fixed to, here the world, shape (4, 4)."""
        return self.camera_in_world

    @model_validator(mode="after")
    def _looks_somewhere(self) -> CeilingCamera:
        if np.hypot(self.look_at[0] - self.position[0], self.look_at[1] - self.position[1]) < 0.05:
            raise ValueError(f"look_at {list(self.look_at)} lies straight below or above the camera; move it aside")
        return self


class OnboardCamera(CameraBase):
    """A camera on the robot's head."""

    fixed: ClassVar[bool] = False

    kind: Literal["onboard"] = "onboard"
    height: Positive = Field(1.2, description="above the floor [m]")
    forward: Finite = Field(0.25, description="ahead of the robot's centre [m]")
    pitch_down: Annotated[float, Field(ge=-1.2, le=1.2)] = Field(0.05, description="[rad]")

    @property
    def mount(self) -> Array:
        """Return the pose in the robot's body, shape (4, 4)."""
        return camera_on_robot(Pose2D(0.0, 0.0, 0.0), self.forward, self.height, self.pitch_down)


Camera = Annotated[CeilingCamera | OnboardCamera, Field(discriminator="kind")]


class Stand(Part):
    """Stand where one starts."""

    kind: Literal["stand"] = "stand"
    turns_to_robot: bool = Field(
        False, description="turn towards the robot that asks for a hand-over, until it is 2 m away"
    )


class Sit(Part):
    """Sit on a sitting area for the whole run; the start pose is the area's seat and facing."""

    kind: Literal["sit"] = "sit"
    on: Name = Field(description="name of the sitting area")


class Walk(Part):
    """Walk along waypoints, then stand."""

    kind: Literal["walk"] = "walk"
    waypoints: Annotated[tuple[Point2, ...], Field(min_length=1)] = Field(description="[m]")
    speed: Positive = Field(description="[m/s]")
    starts: Trigger = Trigger()


class Person(Part):
    """A person of the scenario."""

    name: Name
    start: Point3 = Field(description="x, y [m], yaw [rad]")
    outfit: Annotated[int, Field(ge=0, le=7)] = Field(0, description="which clothes, 0 to 7")
    build: Literal["slim", "broad"] = "slim"
    behaviour: Annotated[Stand | Sit | Walk, Field(discriminator="kind")] = Stand()

    @property
    def start_pose_in_world(self) -> Pose2D:
        """Return the start pose."""
        return Pose2D(*self.start)


class Laser(Part):
    """A planar laser scanner on the robot's middle line that looks straight ahead; it sees furniture and legs."""

    rate: Positive = Field(10.0, description="[Hz]")
    field_of_view: Annotated[float, Field(gt=0.0, le=360.0)] = Field(270.0, description="half to either side [deg]")
    resolution: Annotated[float, Field(ge=0.1)] = Field(0.5, description="between neighbouring rays [deg]")
    range_max: Positive = Field(8.0, description="[m]")
    noise: NonNegative = Field(0.01, description="standard deviation of a range [m]")
    height: Annotated[float, Field(ge=0.1, le=0.6)] = Field(0.25, description="above the floor, where legs are [m]")
    forward: Finite = Field(0.2, description="ahead of the robot's centre [m]")

    @property
    def ticks_per_scan(self) -> int:
        """Return the scanner's period as a number of control ticks."""
        return round(1.0 / (self.rate * CONTROL_PERIOD))

    @property
    def ray_count(self) -> int:
        """Return the number of rays in a scan, the first and the last at the edges of the field of view."""
        return round(self.field_of_view / self.resolution) + 1

    @model_validator(mode="after")
    def _fits_together(self) -> Laser:
        check_period("the laser's rate", self.rate, "20, 10, 5 or 4 Hz")
        steps = self.field_of_view / self.resolution
        if abs(steps - round(steps)) > 1e-6 or round(steps) < 1:
            raise ValueError(
                f"field_of_view {self.field_of_view:g} is not a whole number of steps of resolution "
                f"{self.resolution:g} deg; 270 and 0.5 would be"
            )
        return self


class Slip(Part):
    """How far odometry errs, as standard deviations; zeros make it exact."""

    distance: NonNegative = Field(0.02, description="of the distance, one error for the whole run, relative")
    heading: NonNegative = Field(0.0175, description="after 1 m of way, growing with its square root [rad]")
    turn: NonNegative = Field(0.02, description="of the angle turned, one error for the whole run, relative")


class Robot(Part):
    """The robot: its body is urdf/mbot.urdf; these are its start, its limits and its own senses."""

    start: Point3 = Field(description="x, y [m], yaw [rad]")
    urdf: str = Field("mbot.urdf", description="file in urdf/")
    radius: Positive = Field(0.3, description="of the footprint [m]")
    max_speed: Positive = Field(1.0, description="[m/s]")
    max_acceleration: Positive = Field(1.0, description="[m/s^2]")
    max_yaw_rate: Positive = Field(1.5, description="[rad/s]")
    max_yaw_acceleration: Positive = Field(3.0, description="[rad/s^2]")
    laser: Laser | None = Field(Laser(), description="null: none")
    slip: Slip = Slip()

    @property
    def start_pose_in_world(self) -> Pose2D:
        """Return the start pose."""
        return Pose2D(*self.start)


class GoToTask(Part):
    """Reach a pose."""

    kind: Literal["go_to"] = "go_to"
    pose: Point3 = Field(description="x, y [m], yaw [rad]")
    tolerance: tuple[Positive, Positive] = Field((0.15, 0.2), description="[m], [rad]")

    @property
    def place(self) -> Point2:
        """Return where the pose is [m]."""
        return self.pose[:2]


class HandOverTask(Part):
    """Approach the person who stands near a place from the front."""

    kind: Literal["hand_over"] = "hand_over"
    place: Point2 = Field(description="where the person is expected [m]")
    distance: Positive = Field(0.9, description="between the centres at the stop [m]")
    tolerance: tuple[Positive, Positive] = Field((0.15, 0.2), description="[m], [rad]")


class SeedVariation(Part):
    """How far a seed moves things; a uniform draw within plus or minus the value. Zero keeps the file's value."""

    robot_start: NonNegative = Field(0.15, description="[m], each axis")
    person_start: NonNegative = Field(0.15, description="[m], each axis")
    heading: NonNegative = Field(0.15, description="of robot and people [rad]")
    speed: Annotated[float, Field(ge=0.0, lt=1.0)] = Field(0.15, description="of walkers, relative")
    start_delay: NonNegative = Field(1.0, description="added to triggers, 0 to this [s]")
    image_noise: tuple[NonNegative, NonNegative] = Field((2.0, 6.0), description="standard deviation [grey levels]")
    light: bool = Field(True, description="direction and colour")
    outfits: bool = Field(True, description="clothes and builds")


class Light(Part):
    """The light of the building; a seed may move it."""

    direction: Point3 = Field((0.4, -0.5, 1.0), description="towards the light")
    colour: tuple[NonNegative, NonNegative, NonNegative] = (1.0, 1.0, 1.0)
    ambient: NonNegative = 0.6
    diffuse: NonNegative = 0.4


class CostmapSettings(Part):
    """Grid and planner parameters."""

    resolution: Positive = Field(0.05, description="[m]")
    inflation_radius: Positive = Field(0.55, description="[m]")
    cost_scaling_factor: Positive = Field(10.0, description="decay of the inflation [1/m]")
    astar_weight: NonNegative = Field(10.0, description="how much a full social cost lengthens a metre")
    replan_rate: Annotated[float, Field(ge=2.0)] = Field(4.0, description="[Hz]")

    @model_validator(mode="after")
    def _period_is_a_multiple(self) -> CostmapSettings:
        check_period("replan_rate", self.replan_rate, "20, 10, 5, 4 or 2 Hz")
        return self


class RecoverySettings(Part):
    """How long the robot tries what, once it cannot go on, before it gives up; a step of 0 s is left out."""

    wait: Positive = Field(10.0, description="for the way to become free by itself [s]")
    clear: NonNegative = Field(5.0, description="after it forgot what its sensors saw of obstacles [s]")
    ask: NonNegative = Field(10.0, description="people to make way [s]")
    relocalize: NonNegative = Field(10.0, description="when it is lost: to find itself on the map [s]")


ALL_CAMERAS, LASER, WHEELS = "all", "laser", "wheels"  # targets of faults besides cameras and devices, by name


def check_sensor_names(cameras: Sequence[str], devices: Sequence[str]) -> None:
    """Raise ValueError unless each name of a camera or a device stands for it alone, where faults are told."""
    for kind, names in (("cameras", cameras), ("devices", devices)):
        for name in names:
            if name in (ALL_CAMERAS, LASER, WHEELS):
                raise ValueError(f"{kind}: the name {name!r} stands for something else in faults; choose another")
    shared = [name for name in devices if name in cameras]
    if shared:
        raise ValueError(f"devices: the name {shared[0]!r} is a camera's, too; names of what may fail must differ")


class FaultPart(Part):
    """What goes wrong for a while; see docs/faults.md."""

    target: Name = Field(ALL_CAMERAS, description="a camera, `all` of them, `laser`, `wheels` or a device")
    starts: Trigger = Field(Trigger(), description="a trigger, or seconds after the start")
    until: Positive | None = Field(None, description="end [s]; none: it stays")

    @field_validator("starts", mode="before")
    @classmethod
    def _seconds_are_a_trigger(cls, value: Any) -> Any:
        return {"delay": value} if isinstance(value, int | float) else value

    @model_validator(mode="after")
    def _ends_after_its_start(self) -> FaultPart:
        if self.until is not None and self.starts.when == "time" and self.until <= self.starts.delay:
            raise ValueError(
                f"the fault starts at {self.starts.delay:g} s and ends at {self.until:g} s; later is right"
            )
        return self


class Frozen(FaultPart):
    """A camera sends its last picture again and again, with new stamps."""

    kind: Literal["frozen"] = "frozen"


class Black(FaultPart):
    """No light reaches a camera."""

    kind: Literal["black"] = "black"


class Dropped(FaultPart):
    """Frames of a camera, scans of the laser or messages of a device get lost."""

    kind: Literal["dropped"] = "dropped"
    share: Annotated[float, Field(gt=0.0, le=1.0)] = Field(1.0, description="of them, drawn by the seed")


class Late(FaultPart):
    """Frames of a camera arrive later than they were taken; their stamps are right."""

    kind: Literal["late"] = "late"
    delay: Positive = Field(0.5, description="[s]")


class Knocked(FaultPart):
    """A camera hangs otherwise than everybody believes."""

    kind: Literal["knocked"] = "knocked"
    degrees: Annotated[float, Field(ge=-45.0, le=45.0)] = Field(3.0, description="to the left about the vertical [deg]")


class Slippery(FaultPart):
    """The wheels slip more than usual."""

    kind: Literal["slip"] = "slip"
    target: Name = WHEELS
    times: Positive = Field(5.0, description="the usual slip")


InjectedFault = Annotated[Frozen | Black | Dropped | Late | Knocked | Slippery, Field(discriminator="kind")]


class Expectation(Part):
    """A metric and the range that it must end in."""

    metric: str
    at_least: float | None = None
    at_most: float | None = None
    equals: bool | str | int | None = None

    @model_validator(mode="after")
    def _has_a_bound(self) -> Expectation:
        if self.at_least is None and self.at_most is None and self.equals is None:
            raise ValueError(f"expectation on {self.metric!r} has no bound; give at_least, at_most or equals")
        return self


class World(Part):
    """A scenario."""

    name: Name
    description: str = Field(description="one line for `han-bullet worlds`")
    floor: Annotated[tuple[FloorArea, ...], Field(min_length=1)]
    walls: tuple[Wall, ...] = ()
    furniture: tuple[Furniture, ...] = ()
    sitting_areas: tuple[SittingArea, ...] = ()
    devices: tuple[TV, ...] = ()
    cameras: tuple[Camera, ...] = ()
    people: tuple[Person, ...] = ()
    robot: Robot
    task: Annotated[GoToTask | HandOverTask, Field(discriminator="kind")]
    duration: Positive = Field(60.0, description="the episode ends at the latest then [s]")
    light: Light = Light()
    image_noise: NonNegative = Field(4.0, description="standard deviation; a seed draws its own [grey levels]")
    seed_varies: SeedVariation = SeedVariation()
    layers: dict[str, dict[str, float]] = Field(default_factory=dict, description="layer -> parameter -> value")
    costmap: CostmapSettings = CostmapSettings()
    recovery: RecoverySettings = RecoverySettings()
    score_threshold: Finite | None = Field(
        None, description="least ACF score of a proposal of the shipped model; None: its own"
    )
    faults: tuple[InjectedFault, ...] = Field((), description="of sensors; the stack is not told")
    expectations: tuple[Expectation, ...] = ()

    @model_validator(mode="after")
    def _names_fit_together(self) -> World:
        for kind in ("furniture", "sitting_areas", "devices", "cameras", "people"):
            names = [part.name for part in getattr(self, kind)]
            twice = sorted({name for name in names if names.count(name) > 1})
            if twice:
                raise ValueError(f"{kind}: the name {twice[0]!r} is given twice; names must differ")
        devices = [device.name for device in self.devices]
        check_sensor_names([camera.name for camera in self.cameras], devices)
        for piece in self.furniture:
            if piece.name in devices:
                raise ValueError(f"furniture: the name {piece.name!r} is a device's, too; names of things must differ")
        for area in self.sitting_areas:
            if area.watches is not None and area.watches not in devices:
                raise ValueError(f"sitting_areas: {area.name} watches {area.watches!r}, which is none of {devices}")
        seats = [area.name for area in self.sitting_areas]
        for person in self.people:
            if isinstance(person.behaviour, Sit) and person.behaviour.on not in seats:
                raise ValueError(f"people: {person.name} sits on {person.behaviour.on!r}, which is none of {seats}")
        for fault in self.faults:
            self._check_target(fault)
        return self

    def _check_target(self, fault: InjectedFault) -> None:
        """Raise ValueError unless a fault can happen to its target, and its start be noticed there."""
        cameras = [ALL_CAMERAS, *(camera.name for camera in self.cameras)]
        possible = {
            "slip": [WHEELS],
            "dropped": [
                *cameras,
                *([LASER] if self.robot.laser is not None else []),
                *(device.name for device in self.devices),
            ],
        }.get(fault.kind, cameras)
        if fault.target not in possible:
            right = ", ".join(possible)
            raise ValueError(f"faults: target of {fault.kind!r} is {fault.target!r}; one of {right} would be right")
        onboard = [camera.name for camera in self.cameras if isinstance(camera, OnboardCamera)]
        if fault.starts.when == "robot_near" and fault.target in [LASER, WHEELS, *onboard]:
            raise ValueError(f"faults: {fault.target!r} is on the robot, which is always near; another start is right")
        if fault.starts.when == "robot_near" and fault.target == ALL_CAMERAS and onboard:
            raise ValueError(
                f"faults: {onboard[0]!r}, one of {ALL_CAMERAS!r}, is on the robot, which is always near; another "
                "start, or a fault of each fixed camera, is right"
            )

    def floor_intervals(self) -> list[tuple[Interval, Interval]]:
        """Return the x and y intervals of every floor area [m]."""
        return [(area.x, area.y) for area in self.floor]

    def solid_boxes(self) -> tuple[SolidBox, ...]:
        """Return every wall, piece of furniture and device of the robot's map as a box."""
        return self._boxes([piece for piece in self.furniture if piece.known])

    def lasting_boxes(self) -> tuple[SolidBox, ...]:
        """Return what is there for the whole run, on the map or not."""
        return self._boxes([piece for piece in self.furniture if piece.until is None])

    def all_boxes(self) -> tuple[SolidBox, ...]:
        """Return what is there at the start, on the map or not."""
        return self._boxes(self.furniture)

    def _boxes(self, furniture: Sequence[Furniture]) -> tuple[SolidBox, ...]:
        return (
            *map(_wall_box, range(len(self.walls)), self.walls),
            *map(_object_box, furniture),
            *map(_tv_box, self.devices),
        )

    def seats(self) -> tuple[Seat, ...]:
        """Return the sitting areas as the stack knows them."""
        return tuple(
            Seat(a.name, np.array(a.seat), a.facing, a.reach_in_front, a.width, a.watches) for a in self.sitting_areas
        )

    def with_cameras(self, names: Sequence[str]) -> World:
        """Return the world with these of its cameras alone, without the faults of the others.

        Raises:
            BadInputError: No camera has such a name.
        """
        kept = tuple(self.camera(name) for name in names)
        gone = {camera.name for camera in self.cameras} - set(names)
        faults = tuple(fault for fault in self.faults if fault.target not in gone)
        return self.model_copy(update={"cameras": kept, "faults": faults})

    def with_faults(self, faults: Sequence[InjectedFault]) -> World:
        """Return the world with further faults.

        Raises:
            BadInputError: One of them cannot happen to its target.
        """
        for fault in faults:
            try:
                self._check_target(fault)
            except ValueError as error:
                raise BadInputError(str(error)) from error
        return self.model_copy(update={"faults": (*self.faults, *faults)})

    def camera(self, name: str) -> CeilingCamera | OnboardCamera:
        """Return a camera by its name.

        Raises:
            BadInputError: No camera has that name.
        """
        for camera in self.cameras:
            if camera.name == name:
                return camera
        raise BadInputError(f"camera {name!r} is not in world {self.name!r}; it has {[c.name for c in self.cameras]}")


def _wall_box(index: int, wall: Wall) -> SolidBox:
    start, end = np.array(wall.start), np.array(wall.end)
    along = end - start
    centre = np.array([*(0.5 * (start + end)), 0.5 * wall.height])
    size = np.array([np.hypot(*along), wall.thickness, wall.height])
    return SolidBox(f"wall{index}", "wall", centre, size, math.atan2(along[1], along[0]))


def _object_box(piece: Furniture) -> SolidBox:
    centre = np.array([*piece.position, piece.bottom + 0.5 * piece.size[2]])
    return SolidBox(piece.name, "object", centre, np.array(piece.size), piece.yaw)


def _tv_box(tv: TV) -> SolidBox:
    centre = np.array([*tv.position, tv.bottom + 0.5 * tv.size[2]])
    return SolidBox(tv.name, "object", centre, np.array(tv.size), tv.facing - 0.5 * math.pi)
