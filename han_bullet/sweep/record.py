"""What a sweep keeps of a run: its folder of files and its row."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

from han_bullet.atomic_file import write_at_once
from han_bullet.provenance import git_commit
from han_bullet.sweep.plan import PlannedRun
from han_bullet.sweep.task import Outcome
from han_bullet.sweep_rows import METRIC, write_row


def keep(run: PlannedRun, outcome: Outcome, out: Path) -> None:
    """Write a run's files, then, last, its row: where there is a row, the files are whole.

    Args:
        run: What was asked for.
        outcome: What came of it.
        out: The sweep's folder.
    """
    folder = out / run.folder
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name, content in outcome.files.items():
        write_at_once(folder / name, content)
    result = None if outcome.error else json.loads(outcome.files["result.json"])
    metrics = result["metrics"] if result else []
    units = {metric["name"]: metric["unit"] for metric in metrics}
    write_row(out / run.row, _values(run, result, outcome.error), units)


def _values(run: PlannedRun, result: dict[str, Any] | None, error: str | None) -> dict[str, Any]:
    """Return the row's values; `result` is the run's result.json, None where it did not reach its end."""
    options = run.options
    seeing = options.perception == "cameras"
    asked: dict[str, Any] = {
        "world": run.world.name,
        "variant": run.variant,
        "seed": options.seed,
        "perception": options.perception,
        "association": options.association if seeing else None,
        "pass_side": options.pass_side,
        "without": ",".join(options.without),
        "cameras": ",".join(options.cameras or run.world.cameras) if seeing else "",
        "threshold": options.detector.threshold,
        "error": error,
        "folder": run.folder,
        "world_sha256": run.world.sha256,
    }
    if result is None:
        came = dict.fromkeys(("outcome", "simulated_s", "loop_s", "real_time_factor"))
        return asked | came | {"passed": False, "failed": "", "git_commit": git_commit()}
    failed = [check for check in result["checks"] if not check["passed"]]
    return asked | {
        "pass_side": result["pass"],  # a mirrored run's own
        "outcome": result["outcome"],
        "passed": not failed,
        "failed": "; ".join(f"{c['metric']} = {c['value']}, expected {c['expected']}" for c in failed),
        **{name: float(result["timings"][name]) for name in ("simulated_s", "loop_s", "real_time_factor")},
        "git_commit": result["git_commit"],
        **{f"{METRIC}{metric['name']}": metric["value"] for metric in result["metrics"]},
    }
