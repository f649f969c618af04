"""What a run leaves behind as tables: the truth, what was sensed and found, what was believed of it, what devices said.

Rows are flushed tick by tick, so that a run that dies leaves whole lines behind. Numbers have a fixed format, so that
equal runs give equal files.
"""

from __future__ import annotations

import contextlib
import functools
import math
from abc import abstractmethod
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path

import numpy as np

from han_bullet.device_payload import read_payload
from han_bullet.episode import Hook, Tick
from han_bullet.errors import BadInputError
from han_bullet.messages import Truth
from han_bullet.world_schema import World

DECIMALS = 6  # micrometres and microseconds: below every figure's meaning, above float noise of a replay
VARIANCE_DECIMALS = 9  # a deviation of 30 um or urad still shows
LASER_HEADER = ("time", "angle_min", "angle_increment", "range_min", "range_max", "x", "y", "yaw")
POSES_HEADER = ("time", "x", "y", "yaw", "lost", "xx", "xy", "xyaw", "yy", "yyaw", "yawyaw")
ODOMETRY_HEADER = ("time", "x", "y", "yaw", "vx", "vy", "omega")
COMMANDS_HEADER = ("time", "vx", "vy", "omega")
STATUS_HEADER = ("time", "status", "step")
TRACKS_HEADER = ("time", "id", "x", "y", "vx", "vy", "yaw", "posture")
DETECTIONS_HEADER = ("time", "camera", "x", "y", "width", "height", "score", "probability")
FRAMES_HEADER = ("time", "camera", "exposed", "checksum", "brightness", "contrast", "shift_right", "shift_down")
FEET_HEADER = ("time", "camera", "detection", "row")
EMPTY_SEATS_HEADER = ("time", "camera", "seat")
LEGS_HEADER = ("time", "x", "y", "deviation_x", "deviation_y", "correlation", "vacant")
MESSAGES_HEADER = ("time", "device", "sent", "on", "session")

Cell = float | int | str | None


class TableRecorder(Hook):
    """Write a comma-separated table, some rows per tick.

    Args:
        path: The file; an older one is replaced.
        header: Names of the columns.
    """

    def __init__(self, path: Path, header: Sequence[str]) -> None:
        self._file = path.open("w", encoding="utf-8", newline="\n")
        self._file.write(",".join(header) + "\n")
        self._file.flush()

    @abstractmethod
    def rows(self, tick: Tick) -> Iterable[Sequence[Cell]]:
        """Return the rows of one tick, in the order of the header."""

    def record(self, tick: Tick) -> None:
        """Write the rows of one tick."""
        self._write(self.rows(tick))

    def _write(self, rows: Iterable[Sequence[Cell]]) -> None:
        lines = [_line(row) for row in rows]
        if lines:
            self._file.writelines(lines)
            self._file.flush()

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def _line(row: Sequence[Cell]) -> str:
    """Write a row; one of floats alone, such as a scan, at once and not cell by cell."""
    if set(map(type, row)) == {float}:
        return _floats(len(row)) % tuple(row)
    return ",".join(map(_text, row)) + "\n"


@functools.cache
def _floats(count: int) -> str:
    return ",".join([f"%.{DECIMALS}f"] * count) + "\n"


def _text(cell: Cell) -> str:
    """Write floats with `DECIMALS` digits and what is unknown as an empty cell; names hold no commas by schema."""
    if cell is None:
        return ""
    return f"{cell:.{DECIMALS}f}" if isinstance(cell, float) else str(cell)


class TraceRecorder(TableRecorder):
    """Write the truth: one row per tick with the robot's pose in the world, its twist in the body and every person.

    Args:
        path: The file.
        world: Names the people, in the order of the columns.
    """

    def __init__(self, path: Path, world: World) -> None:
        robot = ("time", *(f"robot.{name}" for name in ("x", "y", "yaw", "vx", "vy", "omega")))
        people = [f"{person.name}.{name}" for person in world.people for name in ("x", "y", "yaw", "posture")]
        super().__init__(path, (*robot, *people))

    def rows(self, tick: Tick) -> Iterable[Sequence[Cell]]:
        """Return the one row of a tick."""
        yield self._row(tick.truth)

    def note(self, truth: Truth) -> None:
        """Write the row of a tick on which no stack of ours has decided."""
        self._write([self._row(truth)])

    def _row(self, truth: Truth) -> Sequence[Cell]:
        pose, twist = truth.pose_robot_in_world, truth.twist_robot_in_body
        row: list[Cell] = [truth.time, pose.x, pose.y, pose.yaw, twist.vx, twist.vy, twist.omega]
        for person in truth.people:
            place = person.pose_in_world
            row += [place.x, place.y, place.yaw, person.posture.value]
        return [float(cell) if isinstance(cell, int) else cell for cell in row]


class PosesRecorder(TableRecorder):
    """Write where the robot believes itself to be, and the covariance of that: one row per tick.

    Args:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, POSES_HEADER)

    def rows(self, tick: Tick) -> Iterable[Sequence[Cell]]:
        """Return the one row of a tick."""
        estimate = tick.decision.estimate
        pose = estimate.pose_robot_in_world
        covariance = (f"{cell:.{VARIANCE_DECIMALS}f}" for cell in estimate.covariance[np.triu_indices(3)].tolist())
        yield estimate.time, float(pose.x), float(pose.y), float(pose.yaw), int(estimate.lost), *covariance


class OdometryRecorder(TableRecorder):
    """Write what the wheels told: one row per tick with the pose in the odom frame and the twist in the body.

    Args:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, ODOMETRY_HEADER)

    def rows(self, tick: Tick) -> Iterable[Sequence[Cell]]:
        """Return the one row of a tick."""
        odometry = tick.observation.odometry
        pose, twist = odometry.pose_robot_in_odom, odometry.twist_robot_in_body
        yield [float(cell) for cell in (odometry.time, pose.x, pose.y, pose.yaw, twist.vx, twist.vy, twist.omega)]


class CommandsRecorder(TableRecorder):
    """Write the command on each tick's observation, a twist in the body, with all digits.

    The simulator, driven by them, does everything again to the last bit.

    Args:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, COMMANDS_HEADER)

    def rows(self, tick: Tick) -> Iterable[Sequence[Cell]]:
        """Return the one row of a tick."""
        command = tick.decision.command
        yield tick.truth.time, *(repr(float(cell)) for cell in (command.vx, command.vy, command.omega))


class StatusRecorder(TableRecorder):
    """Write what the robot is up to, and what it tries where it cannot go on: one row per change.

    Args:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, STATUS_HEADER)
        self._last: tuple[Cell, ...] = ()

    def rows(self, tick: Tick) -> Iterable[Sequence[Cell]]:
        """Return the row of a tick that differs from the one before."""
        decision = tick.decision
        now = decision.status.name.lower(), None if decision.step is None else decision.step.name.lower()
        if now != self._last:
            self._last = now
            yield tick.truth.time, *now


class LaserRecorder(TableRecorder):
    """Write what the laser measured: one row per scan, with the scanner's place on the robot, and its ranges last.

    Args:
        path: The file.
        rays: Of a scan.
    """

    def __init__(self, path: Path, rays: int) -> None:
        super().__init__(path, (*LASER_HEADER, *ray_columns(rays)))

    def rows(self, tick: Tick) -> Iterable[Sequence[Cell]]:
        """Return the row of a tick's scan, if there is one; where nothing was met, the range is inf."""
        scan = tick.observation.laser
        if scan is not None:
            at = scan.scanner_in_body
            limits = (scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max)
            yield [*map(float, (scan.time, *limits, at.x, at.y, at.yaw)), *scan.ranges.tolist()]


def ray_columns(rays: int) -> tuple[str, ...]:
    """Return the names of the columns of a scan's ranges."""
    return tuple(f"range{ray}" for ray in range(rays))


class TracksRecorder(TableRecorder):
    """Write what the robot believes: one row per tick and confirmed track.

    Args:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, TRACKS_HEADER)

    def rows(self, tick: Tick) -> Iterable[Sequence[Cell]]:
        """Return a row per track; its yaw is empty where nobody knows it."""
        for track in tick.decision.people:
            place, velocity = track.position_in_world.tolist(), track.velocity_in_world.tolist()
            yaw = None if track.heading is None else float(track.heading)
            yield tick.truth.time, track.id, *place, *velocity, yaw, track.posture.value


class DetectionsRecorder(TableRecorder):
    """Write what the detector found: one row per box; the time is that of the exposure.

    Args:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, DETECTIONS_HEADER)

    def rows(self, tick: Tick) -> Iterable[Sequence[Cell]]:
        """Return a row per box, in the order of the cameras."""
        for found in tick.decision.detections:
            columns = (found.boxes.tolist(), found.scores.tolist(), found.probabilities.tolist())
            for box, score, probability in zip(*columns, strict=True):
                yield found.time, found.camera, *box, score, probability


class FramesRecorder(TableRecorder):
    """Write which frames reached the robot, at the tick at which they arrived, and what their pixels told.

    Args:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, FRAMES_HEADER)

    def rows(self, tick: Tick) -> Iterable[Sequence[Cell]]:
        """Return a row per frame, in the order of the cameras."""
        for found in tick.decision.detections:
            row: list[Cell] = [tick.truth.time, found.camera, found.time]
            if (seen := found.health) is not None:
                row += [seen.checksum, seen.brightness, seen.contrast, *seen.shift]
            yield row + [None] * (len(FRAMES_HEADER) - len(row))


class FeetRecorder(TableRecorder):
    """Write where the feet end of whom a camera knows it better than by the box: the row of the image [px].

    Args:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, FEET_HEADER)

    def rows(self, tick: Tick) -> Iterable[Sequence[Cell]]:
        """Return a row per known foot, with the number of its box among those of the frame, from 0."""
        for found in tick.decision.detections:
            for number, row in enumerate([] if found.feet is None else found.feet.tolist()):
                if math.isfinite(row):
                    yield found.time, found.camera, number, row


class EmptySeatsRecorder(TableRecorder):
    """Write which sitting areas fixed cameras showed to be empty.

    Args:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, EMPTY_SEATS_HEADER)

    def rows(self, tick: Tick) -> Iterable[Sequence[Cell]]:
        """Return a row per frame and seat that it shows to be empty."""
        for found in tick.decision.detections:
            for seat in found.empty_seats:
                yield found.time, found.camera, seat


class LegsRecorder(TableRecorder):
    """Write what the laser said of people: a row per measurement, and one per person whose place is empty.

    Args:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, LEGS_HEADER)

    def rows(self, tick: Tick) -> Iterable[Sequence[Cell]]:
        """Return a row per measurement [m], then one per empty place with the person's id."""
        legs = tick.decision.legs
        if legs is None:
            return
        for place, covariance in zip(legs.positions.tolist(), legs.covariances.tolist(), strict=True):
            (xx, xy), (_, yy) = covariance
            yield legs.time, *place, math.sqrt(xx), math.sqrt(yy), xy / math.sqrt(xx * yy), None
        for person in legs.vacant:
            yield legs.time, None, None, None, None, None, person


class MessagesRecorder(TableRecorder):
    """Write what devices told the robot: one row per well-formed message, at the tick at which it arrived.

    Args:
        path: The file.
        devices: Names of the world's devices.
    """

    def __init__(self, path: Path, devices: Collection[str]) -> None:
        super().__init__(path, MESSAGES_HEADER)
        self._devices = devices

    def rows(self, tick: Tick) -> Iterable[Sequence[Cell]]:
        """Return a row per message, in the order of their arrival."""
        for payload in tick.observation.device_messages:
            with contextlib.suppress(BadInputError):
                message = read_payload(payload, self._devices)
                yield tick.truth.time, message.device, message.time, int(message.on), message.session
