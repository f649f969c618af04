"""The rows of a sweep, one per run, read from the Parquet files that it leaves."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from han_bullet.errors import BadInputError, quoted


def read_rows(out: Path) -> pa.Table:
    """Return all rows of a sweep; metrics that a run does not have are null.

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
        raise BadInputError(f"{out}: no rows of a sweep; a folder that `han-bullet sweep` wrote would be right")
    return pa.concat_tables(tables, promote_options="default")
