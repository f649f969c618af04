"""The folder of a finished run, read: its result, its tables by column, its world."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from han_bullet.errors import BadInputError, quoted
from han_bullet.geometry import Array
from han_bullet.messages import RecoveryStep, Status
from han_bullet.metrics.tally import Value
from han_bullet.world_schema import CONTROL_PERIOD, InjectedFault

Doing = tuple[float, Status, RecoveryStep | None]  # since when [s]; None: the robot goes on
Step = tuple[float, RecoveryStep | None]


class _Entry(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True)


class MetricEntry(_Entry):
    """A figure in result.json."""

    name: str
    value: Value
    unit: str
    definition: str


class CheckEntry(_Entry):
    """An expectation in result.json."""

    metric: str
    expected: str
    value: Value
    passed: bool


class FaultEntry(_Entry):
    """A fault in result.json: of a sensor, from when and until when [s] it was noticed; None: to the end."""

    sensor: str
    kind: str
    since: float = Field(alias="from")
    until: float | None


class OrderEntry(_Entry):
    """An order in result.json, with the pose of one to go, the place, distance and person of a hand-over."""

    time: float
    order: str
    pose: tuple[float, float, float] | None = None
    place: tuple[float, float] | None = None
    distance: float | None = None
    person: int | None = None


class ResultFile(_Entry):
    """What result.json says, as far as a report shows it or a replay needs it."""

    world: str
    world_sha256: str
    seed: int
    perception: str
    localization: str | None
    cameras: tuple[str, ...]
    association: str | None
    detector: dict[str, Any] | None
    device_session: str
    layers: tuple[str, ...]
    pass_side: str = Field(alias="pass")
    mirrored: bool
    scaled: tuple[str, ...]
    versions: dict[str, str]
    git_commit: str
    outcome: str
    outcome_detail: str | None
    faults: tuple[FaultEntry, ...] = ()
    asked_faults: tuple[InjectedFault, ...] = ()
    metrics: tuple[MetricEntry, ...]
    checks: tuple[CheckEntry, ...]
    orders: tuple[OrderEntry, ...] = ()
    timings: dict[str, float | int | None]

    def metric(self, name: str) -> MetricEntry | None:
        """Return a metric by its name."""
        return next((metric for metric in self.metrics if metric.name == name), None)


def is_run(folder: Path) -> bool:
    """Tell whether a folder holds a finished run."""
    return (folder / "result.json").is_file()


def read_result(folder: Path) -> ResultFile:
    """Read result.json.

    Raises:
        BadInputError: It is missing, or not what a run writes.
    """
    path = folder / "result.json"
    try:
        return ResultFile.model_validate_json(path.read_text(encoding="utf-8"))
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(map(str, first["loc"])) or "the document"
        raise BadInputError(f"{path}: {field}: {first['msg']}; a file that `han-bullet run` wrote is needed") from error
    except (OSError, UnicodeDecodeError) as error:
        raise BadInputError(f"{path}: not readable: {quoted(error)}") from error


@dataclass(frozen=True)
class Table:
    """A table of a run.

    Attributes:
        path: Of the file.
        columns: The cells by the column's name, in the order of the lines.
    """

    path: Path
    columns: Mapping[str, Sequence[str]]

    def words(self, name: str) -> Sequence[str]:
        """Return a column as it is written.

        Raises:
            BadInputError: There is no such column.
        """
        if name not in self.columns:
            raise BadInputError(f"{self.path}: has no column {name!r}; a run of this version writes it")
        return self.columns[name]

    def numbers(self, *names: str) -> Array:
        """Return columns as numbers, shape (lines, columns).

        Raises:
            BadInputError: A column is missing, or a cell is no number.
        """
        return np.column_stack([self._numbers(name) for name in names])

    def ticks(self) -> NDArray[np.int64]:
        """Return of which tick each line is, by the column `time`, shape (lines,).

        Raises:
            BadInputError: A time is no number.
        """
        return self.whole_numbers("time", CONTROL_PERIOD)

    def whole_numbers(self, name: str, unit: float = 1.0) -> NDArray[np.int64]:
        """Return a column in whole multiples of a unit, shape (lines,).

        Raises:
            BadInputError: The column is missing, or a cell is no number, or too large for one that is counted.
        """
        multiples = np.rint(self._numbers(name) / unit)
        countable = np.abs(multiples) < 2**31  # not for NaN either
        if not countable.all():
            index = int(countable.argmin())
            raise self.unreadable(index, f"its {name} is {self.columns[name][index]!r}")
        return multiples.astype(np.int64)

    def unreadable(self, index: int, why: str) -> BadInputError:
        """Return the complaint about a line, counted from 0."""
        return BadInputError(f"{self.path}: line {index + 2} cannot be read: {why}")

    def _numbers(self, name: str) -> Array:
        cells = self.words(name)
        try:
            return np.array(cells, np.float64)
        except ValueError:
            for index, cell in enumerate(cells):
                try:
                    float(cell)
                except ValueError as error:
                    raise self.unreadable(index, quoted(error)) from error
            raise


def read_table(path: Path) -> Table:
    """Read a table; a last line that is not whole is left out.

    Raises:
        BadInputError: It is missing, or no table.
    """
    try:
        with path.open(encoding="utf-8", newline="") as file:
            header, *lines = csv.reader(file)
    except (OSError, UnicodeDecodeError, csv.Error, ValueError) as error:
        raise BadInputError(f"{path}: cannot be read: {quoted(error)}") from error
    if lines and len(lines[-1]) < len(header):
        lines.pop()
    for index, line in enumerate(lines):
        if len(line) != len(header):
            raise Table(path, {}).unreadable(index, f"it has {len(line)} cells; {len(header)} would be right")
    return Table(path, dict(zip(header, zip(*lines, strict=True) if lines else ((),) * len(header), strict=True)))


def read_doings(folder: Path) -> list[Doing]:
    """Return since when the robot was up to what, from the beginning on.

    Raises:
        BadInputError: status.csv is missing, or no table of statuses.
    """
    table = read_table(folder / "status.csv")
    rows = zip(table.numbers("time").tolist(), table.words("status"), table.words("step"), strict=True)
    doings: list[Doing] = []
    for index, ((time,), status, step) in enumerate(rows):
        if status.upper() not in Status.__members__:
            raise table.unreadable(index, f"its status is {status!r}")
        if step and step.upper() not in RecoveryStep.__members__:
            raise table.unreadable(index, f"its step is {step!r}")
        doings.append((time, Status[status.upper()], RecoveryStep[step.upper()] if step else None))
    return doings


def steps_of(doings: Sequence[Doing]) -> list[Step]:
    """Return when the robot began which step, since it could not go on, and when it could again."""
    steps: list[Step] = [(0.0, None)]
    for time, _, step in doings:
        if step is not steps[-1][1]:
            steps.append((time, step))
    return steps[1:]
