"""Rows of a sweep as files: whole or not there, of one type per column, and together a table."""

from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest

from han_bullet.errors import BadInputError
from han_bullet.sweep_rows import COLUMNS, read_row, read_rows, write_row


def values(world: str, seed: int, **others: Any) -> dict[str, Any]:
    """A row in which nothing is known but the world, the seed and the others."""
    return dict.fromkeys(COLUMNS.names) | {"world": world, "variant": "truth", "seed": seed} | others


def write(out: Path, world: str, seed: int, units: dict[str, str], **metrics: Any) -> Path:
    path = out / f"rows/{world}.truth.{seed}.parquet"
    write_row(path, values(world, seed, **{f"metric.{name}": value for name, value in metrics.items()}), units)
    return path


def test_a_row_comes_back_as_it_was_written(tmp_path: Path) -> None:
    path = write(tmp_path, "a", 3, {"contacts": "1", "side": "", "time": "s"}, contacts=2, side="left", time=None)
    row = read_row(path)
    assert row is not None
    assert (row["world"], row["seed"], row["error"], row["passed"]) == ("a", 3, None, None)
    assert (row["metric.contacts"], row["metric.side"], row["metric.time"]) == (2.0, "left", None)
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def test_a_metric_has_one_type_whatever_its_value(tmp_path: Path) -> None:
    units = {"number": "m", "word": ""}
    for seed, (number, word) in enumerate([(1, "left"), (0.5, None), (None, None), (True, "right")]):
        write(tmp_path, "a", seed, units, number=number, word=word)
    table = read_rows(tmp_path)
    assert table.schema.field("metric.number").type == pa.float64()
    assert table.schema.field("metric.word").type == pa.string()
    assert table["metric.number"].to_pylist() == [1.0, 0.5, None, 1.0]


def test_rows_of_different_worlds_make_one_table_in_order(tmp_path: Path) -> None:
    write(tmp_path, "b", 10, {"of_b": "m"}, of_b=2.0)
    write(tmp_path, "b", 9, {"of_b": "m"}, of_b=1.0)
    write(tmp_path, "a", 0, {"of_a": "m"}, of_a=3.0)
    write(tmp_path, "a", 1, {})
    table = read_rows(tmp_path)
    assert table.column_names == [*COLUMNS.names, "metric.of_a", "metric.of_b"]
    assert table.schema.field("threshold").type == pa.float64()
    assert table["seed"].to_pylist() == [0, 1, 9, 10]
    assert table["metric.of_a"].to_pylist() == [3.0, None, None, None]
    assert table["metric.of_b"].to_pylist() == [None, None, 1.0, 2.0]


def test_a_row_that_was_being_written_does_not_count(tmp_path: Path) -> None:
    path = write(tmp_path, "a", 0, {})
    path.with_name("a.truth.1.parquet.tmp").write_bytes(path.read_bytes()[:100])
    assert read_rows(tmp_path).num_rows == 1


def test_what_is_no_row_counts_as_missing_when_going_on_and_is_named_when_reading(tmp_path: Path) -> None:
    path = write(tmp_path, "a", 0, {})
    path.write_bytes(path.read_bytes()[:100])
    assert read_row(path) is None and read_row(tmp_path / "rows/none.parquet") is None
    with pytest.raises(BadInputError, match=r"a\.truth\.0\.parquet: not a row"):
        read_rows(tmp_path)


def test_a_folder_without_rows_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match="no rows of a sweep"):
        read_rows(tmp_path)
