"""The rows of a sweep: one Parquet file per run, written as soon as the run ends, read together as one table."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from han_bullet.atomic_file import write_at_once
from han_bullet.errors import BadInputError, quoted

METRIC = "metric."  # how the columns of metrics begin

COLUMNS = pa.schema(
    [
        ("world", pa.string()),
        ("variant", pa.string()),
        ("seed", pa.int64()),
        ("perception", pa.string()),
        ("association", pa.string()),
        ("pass_side", pa.string()),
        ("without", pa.string()),
        ("cameras", pa.string()),
        ("threshold", pa.float64()),
        ("outcome", pa.string()),
        ("passed", pa.bool_()),
        ("failed", pa.string()),
        ("error", pa.string()),
        ("folder", pa.string()),
        ("simulated_s", pa.float64()),
        ("loop_s", pa.float64()),
        ("real_time_factor", pa.float64()),
        ("git_commit", pa.string()),
        ("world_sha256", pa.string()),
    ]
)
"""What every row has; docs/sweep.md says what it means. The metrics of the run follow."""


def write_row(path: Path, values: dict[str, Any], units: dict[str, str]) -> None:
    """Write a row in one go.

    Args:
        path: The file; its folder is made.
        values: One for each of `COLUMNS` and, with `METRIC` before the name, for each metric.
        units: Of each metric by its name; an empty one marks words, every other one a number.
    """
    fields = [*COLUMNS, *(pa.field(f"{METRIC}{name}", _type(unit)) for name, unit in units.items())]
    columns = {field.name: values[field.name] for field in fields}
    row = {name: float(v) if name.startswith(METRIC) and isinstance(v, int) else v for name, v in columns.items()}
    content = pa.BufferOutputStream()
    pq.write_table(pa.Table.from_pylist([row], schema=pa.schema(fields)), content)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_at_once(path, content.getvalue().to_pybytes())


def _type(unit: str) -> pa.DataType:
    return pa.float64() if unit else pa.string()


def read_row(path: Path) -> dict[str, Any] | None:
    """Return a row, or None where there is no file or it holds no row."""
    try:
        rows: list[dict[str, Any]] = pq.read_table(path, partitioning=None).to_pylist()
    except (FileNotFoundError, pa.ArrowInvalid):
        return None
    return rows[0] if len(rows) == 1 and rows[0].keys() >= set(COLUMNS.names) else None


def read_rows(out: Path) -> pa.Table:
    """Return all rows of a sweep, by world, variant and seed; metrics that a run does not have are null.

    Args:
        out: The sweep's folder; it may still be running.

    Raises:
        BadInputError: There are no rows, or a file holds none.
    """
    tables = []
    for path in sorted((out / "rows").glob("*.parquet")):
        try:
            tables.append(pq.read_table(path, partitioning=None))
        except pa.ArrowInvalid as error:
            raise BadInputError(f"{path}: not a row of a sweep: {quoted(error)}") from error
    if not tables:
        raise BadInputError(f"{out}: no rows of a sweep; a folder that `han-bullet sweep --out` wrote would be right")
    table = pa.concat_tables([COLUMNS.empty_table(), *tables], promote_options="default")
    return table.sort_by([(name, "ascending") for name in ("world", "variant", "seed")])
