"""Carry out a sweep: what is done already is kept, what dies is tried again, every run leaves a row."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from pathlib import Path
from typing import Any

from distributed import Client, Future, KilledWorker, as_completed

from han_bullet.errors import WorkerDiedError, quoted
from han_bullet.provenance import git_commit
from han_bullet.sweep.plan import PlannedRun
from han_bullet.sweep.record import keep
from han_bullet.sweep.task import Outcome, carry_out
from han_bullet.sweep.workers import local_workers, remote_workers
from han_bullet.sweep_rows import read_row


class Onlooker:
    """Is told how a sweep goes on; a subclass overrides what it wants to know."""

    def started(self, runs: int, kept: Sequence[dict[str, Any]]) -> None:
        """Take note of the number of runs to carry out, and of the rows kept from an earlier time."""

    def ended(self, row: dict[str, Any]) -> None:
        """Take note of the row of a run that has just ended."""


def run_sweep(
    plan: Sequence[PlannedRun],
    out: Path,
    *,
    processes: int | None = None,
    scheduler: str | None = None,
    fresh: bool = False,
    onlooker: Onlooker | None = None,
) -> list[dict[str, Any]]:
    """Carry out the runs that have no row yet; return the rows of all, in the plan's order.

    Args:
        plan: As `plan_sweep` makes it.
        out: Folder of the sweep; made if need be.
        processes: Of this machine; None takes one per core.
        scheduler: Address of a dask cluster to use instead.
        fresh: Whether to do again what is done.
        onlooker: Is told about every row.

    Raises:
        BadInputError: The cluster cannot be used.
        WorkerDiedError: The cluster went away; what is done is kept, and a second call goes on from there.
    """
    onlooker = onlooker or Onlooker()
    rows = {} if fresh else {run: row for run in plan if (row := kept_row(run, out)) is not None}
    waiting = [run for run in plan if run not in rows]
    onlooker.started(len(waiting), list(rows.values()))
    if waiting:
        count = min(processes or os.cpu_count() or 1, len(waiting))
        with remote_workers(scheduler) if scheduler else local_workers(count) as client:
            for run in waiting:  # what is to be replaced must not be taken for done after an interruption
                (out / run.row).unlink(missing_ok=True)
            for run, row in _carry_out_all(client, waiting, out):
                rows[run] = row
                onlooker.ended(row)
    return [rows[run] for run in plan]


def kept_row(run: PlannedRun, out: Path) -> dict[str, Any] | None:
    """Return the row of a run that need not be done again: it reached its end in a world file with the same content.

    The commit may be another one: `of_other_commits` tells which.
    """
    row = read_row(out / run.row)
    good = row is not None and row["error"] is None and row["world_sha256"] == run.world.sha256
    return row if good else None


def of_other_commits(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the rows that another commit than the present one made."""
    here = git_commit()
    return [row for row in rows if row["git_commit"] != here]


def _carry_out_all(
    client: Client, runs: Sequence[PlannedRun], out: Path
) -> Iterator[tuple[PlannedRun, dict[str, Any]]]:
    """Carry out runs in any order; give each with its row as soon as that is written."""
    futures = {client.submit(carry_out, run.world.files, run.options, pure=False): run for run in runs}
    ending = as_completed(list(futures), loop=client.loop)
    for future in ending:
        if future.status == "lost":  # it lay with a worker that died before we had it, and is made once more
            ending.add(future)
            continue
        run = futures.pop(future)
        outcome = _outcome(future)
        future.release()  # the worker forgets the files, and its death can no longer take them along
        keep(run, outcome, out)
        row = read_row(out / run.row)
        assert row is not None
        yield run, row


def _outcome(future: Future[Outcome]) -> Outcome:
    """Return what came of a run; that it died, or ended its worker several times, is an outcome too."""
    try:
        return future.result()
    except CancelledError as error:
        raise WorkerDiedError("the dask scheduler is gone; the same command goes on where it stopped") from error
    except KilledWorker as error:
        return Outcome({}, f"its worker process died each of {error.allowed_failures + 1} times")
    except Exception as error:  # whatever it is, the other runs go on
        return Outcome({}, f"{type(error).__name__}: {quoted(error)}")
