"""Maps as files: ROS map_server's pair of a YAML file and a PGM picture <-> `OccupancyGrid`.

A pixel's darkness, 1 - value / white (value / white if `negate`), is how likely its cell is occupied: above
`occupied_thresh` it is, below `free_thresh` it is free. What lies between is unknown, in mode `scale` as in `trinary`:
our grid has three values.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from han_bullet.atomic_file import write_at_once
from han_bullet.errors import BadInputError, quoted
from han_bullet.localization.occupancy_grid import FREE, MOST_CELLS, OCCUPIED, UNKNOWN, OccupancyGrid

WHITE, BLACK, GREY = 254, 0, 205  # as map_server writes free, occupied and unknown cells
OCCUPIED_THRESHOLD, FREE_THRESHOLD = 0.65, 0.196
MODES = ("trinary", "scale")
_GAP, _NUMBER = rb"(?:\s|#[^\n]*\n)+", rb"(\d{1,9})"
HEADER = re.compile(rb"P5" + _GAP + _NUMBER + _GAP + _NUMBER + _GAP + _NUMBER + rb"\s")
LONGEST_HEADER = 4096  # bytes


@dataclass(frozen=True)
class _Description:
    """What the YAML file says, checked."""

    image: Path
    resolution: float
    origin: tuple[float, float]
    negate: bool
    occupied_thresh: float
    free_thresh: float


def write_map(grid: OccupancyGrid, path: Path) -> None:
    """Write a map as PATH, a YAML file, and a picture of the same name beside it."""
    picture = path.with_suffix(".pgm")
    pixels = np.full(grid.cells.shape, GREY, np.uint8)
    pixels[grid.cells == FREE], pixels[grid.cells == OCCUPIED] = WHITE, BLACK
    rows, columns = pixels.shape
    # The first row of a picture is its uppermost, the first of a grid its lowest.
    write_at_once(picture, f"P5\n{columns} {rows}\n255\n".encode() + pixels[::-1].tobytes())
    document = {
        "image": picture.name,
        "mode": MODES[0],
        "resolution": float(grid.resolution),
        "origin": [float(grid.origin_in_world[0]), float(grid.origin_in_world[1]), 0.0],
        "negate": 0,
        "occupied_thresh": OCCUPIED_THRESHOLD,
        "free_thresh": FREE_THRESHOLD,
    }
    write_at_once(path, yaml.safe_dump(document, sort_keys=False, default_flow_style=None).encode())


def read_map(path: Path) -> OccupancyGrid:
    """Read a map by its YAML file.

    Raises:
        BadInputError: A file is missing or is not what it should be; the message has file and field.
    """
    about = _described(path)
    pixels, white = _read_pgm(about.image)
    value = pixels[::-1] / white
    darkness = value if about.negate else 1.0 - value
    cells = np.full(pixels.shape, UNKNOWN, np.int8)
    cells[darkness > about.occupied_thresh] = OCCUPIED
    cells[darkness < about.free_thresh] = FREE
    return OccupancyGrid(cells, np.array(about.origin), about.resolution)


def _described(path: Path) -> _Description:
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError, OSError) as error:
        raise BadInputError(f"map {path}: not readable as YAML: {quoted(error)}") from error
    if not isinstance(document, dict):
        raise BadInputError(f"map {path}: holds {type(document).__name__}, not a mapping such as `resolution: 0.05`")
    image = document.get("image")
    if not isinstance(image, str) or not image:
        raise BadInputError(f"map {path}: image is {image!r}; the name of a PGM file would be right")
    mode = document.get("mode", MODES[0])
    if mode not in MODES:
        raise BadInputError(f"map {path}: mode is {mode!r}; {' or '.join(MODES)} would be right")
    occupied, free = (_number(path, document, name) for name in ("occupied_thresh", "free_thresh"))
    if not 0.0 <= free <= occupied <= 1.0:
        raise BadInputError(
            f"map {path}: free_thresh is {free} and occupied_thresh {occupied}; 0 <= free <= occupied <= 1"
        )
    resolution = _number(path, document, "resolution")
    if resolution <= 0.0:
        raise BadInputError(f"map {path}: resolution is {resolution} m; it must be positive, such as 0.05")
    negate = document.get("negate")
    if negate not in (0, 1):
        raise BadInputError(f"map {path}: negate is {negate!r}; 0 or 1 would be right")
    return _Description(path.parent / image, resolution, _origin(path, document), bool(negate), occupied, free)


def _origin(path: Path, document: dict[str, Any]) -> tuple[float, float]:
    origin = document.get("origin")
    if not isinstance(origin, list) or len(origin) != 3 or not all(_finite(value) for value in origin):
        raise BadInputError(f"map {path}: origin is {origin!r}; [x, y, yaw] would be right")
    if origin[2] != 0:
        raise BadInputError(f"map {path}: origin has a yaw of {origin[2]}; only maps that are not turned can be read")
    return float(origin[0]), float(origin[1])


def _number(path: Path, document: dict[str, Any], name: str) -> float:
    value = document.get(name)
    if not _finite(value):
        raise BadInputError(f"map {path}: {name} is {value!r}; a number would be right")
    return float(value)  # type: ignore[arg-type]


def _finite(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _read_pgm(path: Path) -> tuple[NDArray[np.uint8], int]:
    """Return the picture, shape (rows, columns), uppermost row first, and the value of white."""
    try:
        with path.open("rb") as file:
            header = HEADER.match(file.read(LONGEST_HEADER))
            if header is None:
                raise BadInputError(f"picture {path}: no PGM file, which would begin with P5, width, height and white")
            columns, rows, white = (int(number) for number in header.groups())
            # Before anything is allocated: a few bytes can claim any size.
            if not (0 < rows * columns <= MOST_CELLS and 0 < white <= 255):
                raise BadInputError(
                    f"picture {path}: {columns} x {rows} pixels with white at {white}; "
                    f"1 to {MOST_CELLS} pixels and white at 1 to 255 would be right"
                )
            file.seek(header.end())
            pixels = np.frombuffer(file.read(rows * columns), np.uint8)
    except OSError as error:
        raise BadInputError(f"picture {path}: not readable: {quoted(error)}") from error
    if len(pixels) != rows * columns:
        raise BadInputError(f"picture {path}: has {len(pixels)} of {rows * columns} pixels; it must be whole")
    return pixels.reshape(rows, columns), white
