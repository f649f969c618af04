"""The folder of a sweep, read: its rows as values, and what of it is missing."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from han_bullet.assumptions import JOINT
from han_bullet.errors import BadInputError, HanError
from han_bullet.metrics.tally import Value

USUAL_BASELINE = "cameras"


@dataclass(frozen=True)
class SweepRow:
    """One run of a sweep.

    Attributes:
        world, variant, seed: Which run.
        outcome: How its task ended; empty where it died.
        passed: Whether every expectation was met.
        failed: Which were not, as the sweep wrote it.
        error: What the run died of, or None.
        folder: Of the run, relative to the sweep's.
        real_time_factor: Simulated seconds per second; NaN where it died.
        git_commit: Of the program.
        world_sha256: Of the world file.
        metrics: By name, those without a value left out.
    """

    world: str
    variant: str
    seed: int
    outcome: str
    passed: bool
    failed: str
    error: str | None
    folder: str
    real_time_factor: float
    git_commit: str
    world_sha256: str
    metrics: dict[str, Value]

    @property
    def is_mirrored(self) -> bool:
        """Tell whether the world's mirror image was run."""
        return "mirrored" in JOINT.split(self.variant)

    def people_values(self, name: str) -> list[Value]:
        """Return the values of a metric, of one without a person, or of all people or devices that have it."""
        return [value for key, value in self.metrics.items() if key.split(".")[0] == name]


@dataclass(frozen=True)
class Sweep:
    """A sweep as its folder tells it.

    Attributes:
        folder: Where it lies.
        rows: By world, variant and seed.
    """

    folder: Path
    rows: tuple[SweepRow, ...]

    @property
    def worlds(self) -> list[str]:
        """Return the names of its worlds."""
        return sorted({row.world for row in self.rows})

    @property
    def variants(self) -> list[str]:
        """Return its variants, plain ones first."""
        return sorted({row.variant for row in self.rows}, key=lambda variant: (variant.count("+"), variant))

    def of(self, world: str, variant: str) -> list[SweepRow]:
        """Return the rows of a world and a variant, by seed."""
        return [row for row in self.rows if (row.world, row.variant) == (world, variant)]

    def missing(self) -> list[tuple[str, str, list[int]]]:
        """Return the seeds that some run of the sweep had and others of the same world lack: world, variant, seeds.

        Every world is taken to be meant for every variant and seed that occur, but for assumptions, which are meant for
        the worlds that they occur in.
        """
        gaps = []
        for world, variant in itertools.product(self.worlds, self.variants):
            have = {row.seed for row in self.of(world, variant)}
            if not have and "scale:" in variant:
                continue
            lacking = sorted({row.seed for row in self.rows} - have)
            if lacking:
                gaps.append((world, variant, lacking))
        return gaps

    def baseline(self, asked: str | None) -> str:
        """Return the variant that others are compared with: the one asked for, `cameras`, or the first.

        Raises:
            BadInputError: The sweep has no such variant.
        """
        if asked is None:
            return USUAL_BASELINE if USUAL_BASELINE in self.variants else self.variants[0]
        if asked not in self.variants:
            raise BadInputError(
                f"baseline {asked!r} is no variant of {str(self.folder)!r}; it has {', '.join(self.variants)}"
            )
        return asked


def is_sweep(folder: Path) -> bool:
    """Tell whether a folder holds rows of a sweep."""
    return any((folder / "rows").glob("*.parquet"))


def read_sweep(folder: Path) -> Sweep:
    """Read a sweep.

    Raises:
        BadInputError: There are no rows, or they are not a sweep's.
        HanError: pyarrow is not installed.
    """
    try:
        from han_bullet.sweep_rows import METRIC, read_rows
    except ModuleNotFoundError as error:
        raise HanError("the report of a sweep needs pyarrow; install han_bullet[sweep]") from error
    try:
        rows = _rows(read_rows(folder).to_pylist(), METRIC)
    except (KeyError, TypeError, ValueError) as error:
        raise BadInputError(f"{folder}: rows without the columns of a sweep ({error!r})") from error
    by_run = {(row.world, row.variant, row.seed): row for row in rows}
    return Sweep(folder, tuple(by_run[key] for key in sorted(by_run)))


def _rows(documents: Iterable[dict[str, Any]], prefix: str) -> list[SweepRow]:
    return [
        SweepRow(
            world=str(row["world"]),
            variant=str(row["variant"]),
            seed=int(row["seed"]),
            outcome=str(row["outcome"] or ""),
            passed=bool(row["passed"]),
            failed=str(row["failed"] or ""),
            error=row["error"] or None,
            folder=str(row["folder"]),
            real_time_factor=_number(row["real_time_factor"]),
            git_commit=str(row["git_commit"] or "unknown"),
            world_sha256=str(row["world_sha256"] or ""),
            metrics={
                name.removeprefix(prefix): value
                for name, value in row.items()
                if name.startswith(prefix) and value is not None
            },
        )
        for row in documents
    ]


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)
