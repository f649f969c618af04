"""Marked points: where floor points of known position show in an image; CSV and YAML files of them.

A CSV file has the header `u,v,x,y` or `u,v,x,y,z` and a row per point; a YAML file has a list of such mappings, alone
or under `points`, as a calibration's own file does.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from han_bullet.atomic_file import write_at_once
from han_bullet.errors import BadInputError, quoted
from han_bullet.geometry import Array

COLUMNS, HEIGHT = ("u", "v", "x", "y"), "z"
FEWEST, MOST = 4, 1000
LINE = 1e-3  # points whose spread across their main direction is this part of that along it are on one line
CSV_ENDING = ".csv"
YAML_ENDINGS = frozenset({".yaml", ".yml"})


@dataclass(frozen=True)
class MarkedPoints:
    """Places in an image and in the world that belong together.

    Attributes:
        pixels: As marked, counted from the image's upper left corner (the first pixel's middle is 0.5, 0.5), shape
            (n, 2) [px].
        points_in_world: Shape (n, 3) [m].
    """

    pixels: Array
    points_in_world: Array

    @classmethod
    def of_rows(cls, rows: Sequence[Sequence[float]]) -> MarkedPoints:
        """Build from rows u, v [px], x, y, z [m]."""
        table = np.array(rows, float).reshape(-1, 5)
        return cls(table[:, :2], table[:, 2:])

    def rows(self) -> list[list[float]]:
        """Return the rows u, v [px], x, y, z [m]."""
        table: list[list[float]] = np.hstack([self.pixels, self.points_in_world]).tolist()
        return table

    def without(self, index: int) -> MarkedPoints:
        """Return all points but one."""
        return MarkedPoints(np.delete(self.pixels, index, axis=0), np.delete(self.points_in_world, index, axis=0))

    def __len__(self) -> int:
        return len(self.pixels)


def check_points(points: MarkedPoints, size: tuple[int, int]) -> None:
    """Make sure that points can tell where a camera is.

    Args:
        points: Any number, the first being point 1 in messages.
        size: Width and height of the image [px].

    Raises:
        BadInputError: They are too few or too many, lie outside the image, on one another or on one line.
    """
    if not FEWEST <= len(points) <= MOST:
        raise BadInputError(f"{len(points)} points are marked; {FEWEST} to {MOST} would be right, better 8 or more")
    for number, (u, v) in enumerate(points.pixels.tolist(), 1):
        if not (0.0 <= u <= size[0] and 0.0 <= v <= size[1]):
            raise BadInputError(
                f"point {number} is marked at u {u:g}, v {v:g}, outside the image of {size[0]} x {size[1]} px; u is "
                "the column, v the row"
            )
    for what, places in (("pixel", points.pixels), ("place", points.points_in_world)):
        _check_apart(what, places)
        spread = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
        if spread[1] < LINE * spread[0]:
            where = "in the image" if what == "pixel" else "on the floor"
            raise BadInputError(
                f"all {len(points)} points lie on one line {where}; mark some beside it, such as the corners of "
                "a rectangle"
            )


def _check_apart(what: str, places: Array) -> None:
    """Raise where two places, (n, k), are the same."""
    first: dict[tuple[float, ...], int] = {}
    for number, place in enumerate(map(tuple, places.tolist()), 1):
        if place in first:
            at = ", ".join(f"{value:g}" for value in place)
            raise BadInputError(
                f"points {first[place]} and {number} have the same {what} ({at}); each must have its own"
            )
        first[place] = number


def read_points(path: Path) -> MarkedPoints:
    """Read a CSV or YAML file of points.

    Raises:
        BadInputError: It is missing or not what it should be; the message has file and row.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
        rows = _yaml_rows(text) if path.suffix.lower() in YAML_ENDINGS else _csv_rows(text, path)
    except (OSError, UnicodeDecodeError, yaml.YAMLError, csv.Error) as error:
        raise BadInputError(f"points {path}: not readable: {quoted(error)}") from error
    try:
        return rows_of_points(rows)
    except BadInputError as error:
        raise BadInputError(f"points {path}: {error}") from error


def rows_of_points(rows: Sequence[Any] | None) -> MarkedPoints:
    """Return points given as mappings of u, v, x, y and, where it is not 0, z; none for None.

    Raises:
        BadInputError: A row is not that; the message has its number.
    """
    if rows is not None and not isinstance(rows, list):
        raise BadInputError("no list of points such as `- {u: 310, v: 402.5, x: 3.0, y: 0.0}`")
    return MarkedPoints.of_rows([_row(row, f"point {number}") for number, row in enumerate(rows or [], 1)])


def write_points(points: MarkedPoints, path: Path) -> None:
    """Write points as a CSV file."""
    lines = [",".join((*COLUMNS, HEIGHT)), *(",".join(f"{value:.10g}" for value in row) for row in points.rows())]
    write_at_once(path, ("\n".join(lines) + "\n").encode())


def _csv_rows(text: str, path: Path) -> list[dict[str, Any]]:
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    reader = csv.reader(io.StringIO("\n".join(lines)), skipinitialspace=True)
    header = [name.strip() for name in next(reader, [])]
    if header not in ([*COLUMNS], [*COLUMNS, HEIGHT]):
        raise BadInputError(
            f"points {path}: the first line is {','.join(header)[:80]!r}; u,v,x,y or u,v,x,y,z would be right"
        )
    rows = list(reader)
    for number, row in enumerate(rows, 1):
        if len(row) != len(header):
            raise BadInputError(
                f"points {path}: point {number} has {len(row)} values; {len(header)} would be right: {','.join(header)}"
            )
    return [dict(zip(header, row, strict=True)) for row in rows]


def _yaml_rows(text: str) -> Any:
    document = yaml.safe_load(text)
    return document.get("points", document) if isinstance(document, dict) else document or []


def _row(row: Any, where: str) -> list[float]:
    """Return u, v, x, y, z of a row given as a mapping."""
    if not isinstance(row, dict) or not set(COLUMNS) <= set(row) <= {*COLUMNS, HEIGHT}:
        columns = ", ".join(map(str, row)) if isinstance(row, dict) else repr(row)[:80]
        raise BadInputError(f"{where} has {columns}; u, v, x, y and, above the floor, z would be right")
    return [_number(row.get(name, 0.0), f"{where}: {name}") for name in (*COLUMNS, HEIGHT)]


def _number(value: Any, where: str) -> float:
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise BadInputError(f"{where} is {value!r}; a finite number would be right")
    return number
