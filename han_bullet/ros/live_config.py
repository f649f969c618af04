"""The configuration of a real robot: which world it is in, its cameras and topics; a YAML file, checked."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import yaml
from pydantic import Field, ValidationError, model_validator

from han_bullet.errors import BadInputError, quoted
from han_bullet.ros.topics import TELEOPERATION
from han_bullet.world_file import first_fault, read_yaml
from han_bullet.world_schema import Name, Part, Point3, Positive, check_period

PAGE = "docs/ros_live.md"
RATES = "20, 10, 5 or 4 Hz"

TopicName = Annotated[str, Field(pattern=r"^/?[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*$")]


class Topic(Part):
    """Where something comes from or goes to."""

    topic: TopicName


class CameraSource(Topic):
    """A camera: one that hangs still and was calibrated, or one of the world file."""

    name: Name
    calibration: Path | None = Field(None, description="of `han-bullet calibrate`; None: the world file has the camera")
    empty_scene: Path | None = Field(None, description="a picture of what a fixed camera sees without people")
    rate: Positive | None = Field(None, description="images used at most [Hz]; None: the world file's, or 10")

    @model_validator(mode="after")
    def _period_is_a_multiple(self) -> CameraSource:
        check_period("rate", self.rate or 10.0, RATES)
        return self


class LaserSource(Topic):
    """A planar laser scanner, level with the floor."""

    mount: Point3 | None = Field(None, description="x, y [m], yaw [rad] on the robot; None: as the world file has it")
    rate: Positive | None = Field(None, description="of its scans [Hz]; None: the world file's")

    @model_validator(mode="after")
    def _period_is_a_multiple(self) -> LaserSource:
        check_period("rate", self.rate or 10.0, RATES)
        return self


class LiveConfig(Part):
    """What the file holds."""

    world: str = Field(
        description="name or path of a world file: building, robot, seats, task; its people play no part"
    )
    cameras: Annotated[tuple[CameraSource, ...], Field(min_length=1)]
    odometry: Topic = Topic(topic="/odom")
    laser: LaserSource | None = None
    command: Topic = Topic(topic="/cmd_vel")
    goal: Topic = Topic(topic="/move_base_simple/goal")
    mqtt: str | None = Field(None, description="broker of the world's devices, HOST[:PORT]; None: they speak by ROS")
    localization: Literal["lidar", "odometry"] = Field(description="odometry: dead reckoning from the world's start")

    @model_validator(mode="after")
    def _fits_together(self) -> LiveConfig:
        names = [camera.name for camera in self.cameras]
        topics = [*(camera.topic for camera in self.cameras), self.odometry.topic, self.command.topic, self.goal.topic]
        topics += [] if self.laser is None else [self.laser.topic]
        for what, given in (("camera name", names), ("topic", [absolute(topic) for topic in topics])):
            twice = sorted({one for one in given if given.count(one) > 1})
            if twice:
                raise ValueError(f"{what} {twice[0]!r} is given twice; each must have its own")
        if absolute(self.command.topic) == TELEOPERATION:
            raise ValueError(
                f"command is {TELEOPERATION!r}, on which the robot is driven by hand; /cmd_vel would be right"
            )
        if self.localization == "lidar" and self.laser is None:
            raise ValueError("localization is 'lidar', but no laser is given; a laser or 'odometry' would be right")
        return self


def absolute(topic: str) -> str:
    """Return a topic's name with its leading slash."""
    return "/" + topic.lstrip("/")


def read_config(path: Path) -> LiveConfig:
    """Read and check a configuration, without the files that it names.

    Raises:
        BadInputError: It is missing, no YAML or does not fit the schema; the message has file and field.
    """
    try:
        document = read_yaml(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise BadInputError(f"{path}: not readable as YAML: {quoted(error)}") from error
    try:
        return LiveConfig.model_validate(document)
    except ValidationError as error:
        raise BadInputError(f"{path}: {first_fault(error, PAGE)}") from error
