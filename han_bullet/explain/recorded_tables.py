"""The tables of a run that a replay alone needs: poses, odometry, commands, scans, frames and what was found in them.

What reads one raises BadInputError where a column is missing or a cell is not what a run writes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Pose2D, Twist2D
from han_bullet.messages import Detections, ImageHealth, LaserScan, LegScan, Odometry, PoseEstimate
from han_bullet.recorder import (
    COMMANDS_HEADER,
    DETECTIONS_HEADER,
    FRAMES_HEADER,
    LASER_HEADER,
    LEGS_HEADER,
    ODOMETRY_HEADER,
    POSES_HEADER,
    ray_columns,
)
from han_bullet.run_folder import Table
from han_bullet.world_schema import CONTROL_PERIOD

Image = tuple[int, str]  # tick of the exposure, and camera


@dataclass(frozen=True)
class FrameRow:
    """A line of frames.csv: which camera's frame of which time [s] arrived, and what its pixels told."""

    camera: str
    exposed: float
    health: ImageHealth | None = None


def of_every_tick(table: Table, count: int | None = None) -> Table:
    """Return a table if it has a row per tick: as many as there are, where that is known.

    Raises:
        BadInputError: It has not.
    """
    ticks = table.ticks().tolist()
    if ticks != list(range(len(ticks) if count is None else count)) or not ticks:
        end = "..." if count is None else f"..., {(count - 1) * CONTROL_PERIOD:g}"
        raise BadInputError(
            f"{table.path}: its times are not 0, {CONTROL_PERIOD:g}, {end} s; a row per tick would be right"
        )
    return table


def poses_of(table: Table) -> dict[int, PoseEstimate]:
    """Return where the robot believed itself to be, by tick."""
    rows = table.numbers(*POSES_HEADER).tolist()
    estimates = (
        PoseEstimate(time, Pose2D(x, y, yaw), _symmetric(upper), lost=bool(lost))
        for time, x, y, yaw, lost, *upper in rows
    )
    return dict(zip(table.ticks().tolist(), estimates, strict=True))


def _symmetric(upper: Sequence[float]) -> Array:
    """Return the symmetric matrix, shape (3, 3), of the numbers of its upper triangle, row by row."""
    matrix = np.zeros((3, 3))
    matrix[np.triu_indices(3)] = upper
    matrix.T[np.triu_indices(3)] = upper
    return matrix


def odometry_of(table: Table) -> dict[int, Odometry]:
    """Return what the wheels told, by tick."""
    rows = table.numbers(*ODOMETRY_HEADER).tolist()
    values = (Odometry(time, Pose2D(x, y, yaw), Twist2D(vx, vy, omega)) for time, x, y, yaw, vx, vy, omega in rows)
    return dict(zip(table.ticks().tolist(), values, strict=True))


def commands_of(table: Table) -> dict[int, Twist2D]:
    """Return what the robot was told to do then, by tick."""
    twists = (Twist2D(*row) for row in table.numbers(*COMMANDS_HEADER[1:]).tolist())
    return dict(zip(table.ticks().tolist(), twists, strict=True))


def frames_of(table: Table) -> dict[int, list[FrameRow]]:
    """Return which frames arrived, by tick; ticks without are missing."""
    found: dict[int, list[FrameRow]] = {}
    exposed = table.numbers("exposed")[:, 0].tolist()
    told = zip(*(table.words(name) for name in FRAMES_HEADER[3:]), strict=True)
    rows = zip(table.ticks().tolist(), table.words("camera"), exposed, told, strict=True)
    for index, (tick, camera, time, (checksum, *numbers)) in enumerate(rows):
        try:
            brightness, contrast, right, down = map(float, numbers) if checksum else (0.0,) * 4
            health = ImageHealth(int(checksum), brightness, contrast, (right, down)) if checksum else None
        except ValueError as error:
            raise table.unreadable(index, str(error)) from error
        found.setdefault(tick, []).append(FrameRow(camera, time, health))
    return found


def scans_of(table: Table) -> dict[int, LaserScan]:
    """Return what the laser measured, by tick; ticks without are missing."""
    rays = len(table.columns) - len(LASER_HEADER)
    rows = zip(table.ticks().tolist(), table.numbers(*LASER_HEADER, *ray_columns(rays)), strict=True)
    found = {}
    for tick, row in rows:
        time, start, increment, nearest, farthest, *place = row[: len(LASER_HEADER)].tolist()
        ranges = row[len(LASER_HEADER) :]
        found[tick] = LaserScan(time, ranges, start, increment, nearest, farthest, Pose2D(*place))
    return found


def detections_of(
    table: Table, feet: Mapping[Image, Mapping[int, float]], seats: Mapping[Image, tuple[str, ...]]
) -> dict[Image, Detections]:
    """Gather the boxes of each frame, as the detector ordered them, with known feet and the seats seen empty."""
    frames: dict[Image, list[list[float]]] = {image: [] for image in seats}
    boxes = table.numbers(*DETECTIONS_HEADER[2:]).tolist()
    for tick, camera, box in zip(table.ticks().tolist(), table.words("camera"), boxes, strict=True):
        frames.setdefault((tick, camera), []).append(box)
    found = {}
    for image, rows in frames.items():
        known, of_frame = feet.get(image, {}), np.array(rows).reshape(-1, len(DETECTIONS_HEADER) - 2)
        ends = np.array([known.get(number, math.nan) for number in range(len(rows))])
        found[image] = Detections(
            of_frame[:, :4], of_frame[:, 4], of_frame[:, 5], feet=ends, empty_seats=seats.get(image, ())
        )
    return found


def empty_seats_of(table: Table) -> dict[Image, tuple[str, ...]]:
    """Return the seats that each frame showed to be empty; frames without are missing."""
    found: dict[Image, tuple[str, ...]] = {}
    for tick, camera, seat in zip(table.ticks().tolist(), table.words("camera"), table.words("seat"), strict=True):
        found[tick, camera] = (*found.get((tick, camera), ()), seat)
    return found


def feet_of(table: Table) -> dict[Image, dict[int, float]]:
    """Gather the rows of known feet [px] of each frame, by the number of their box."""
    frames: dict[Image, dict[int, float]] = {}
    ends, numbers = table.numbers("row")[:, 0].tolist(), table.whole_numbers("detection").tolist()
    for tick, camera, number, row in zip(table.ticks().tolist(), table.words("camera"), numbers, ends, strict=True):
        frames.setdefault((tick, camera), {})[number] = row
    return frames


def legs_of(table: Table) -> dict[int, LegScan]:
    """Gather what the laser said at each tick: measurements, and the people whose place was empty."""
    times = {tick: time for tick, (time,) in zip(table.ticks().tolist(), table.numbers("time").tolist(), strict=True)}
    measured: dict[int, list[list[float]]] = {tick: [] for tick in times}
    vacant: dict[int, tuple[int, ...]] = dict.fromkeys(times, ())
    columns = (table.words(name) for name in LEGS_HEADER[1:])
    for index, (tick, *cells, person) in enumerate(zip(table.ticks().tolist(), *columns, strict=True)):
        try:
            if person:
                vacant[tick] = (*vacant[tick], int(person))
            else:
                measured[tick].append([float(cell) for cell in cells])
        except ValueError as error:
            raise table.unreadable(index, str(error)) from error
    return {tick: _leg_scan(time, measured[tick], vacant[tick]) for tick, time in times.items()}


def _leg_scan(time: float, rows: Sequence[Sequence[float]], vacant: tuple[int, ...]) -> LegScan:
    x, y, right, up, correlation = np.array(rows).reshape(-1, 5).T
    both = correlation * right * up
    covariances = np.array([[right**2, both], [both, up**2]]).transpose(2, 0, 1)
    return LegScan(time, np.column_stack([x, y]), covariances, vacant)
