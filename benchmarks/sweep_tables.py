"""Sweeps in short: what was met, whom the robot touched, how well people were known, and what the layers change.

Usage: python -m benchmarks.sweep_tables [--write] SWEEP...

Each SWEEP is a folder that `han-bullet sweep --out` filled. --write puts the tables into benchmarks/RESULTS.md, where
`make bench` leaves them alone: a sweep of hundreds of runs with cameras is made once, over hours.
"""

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.results import write_sweeps
from han_bullet.markdown import markdown_table
from han_bullet.paired_statistics import compare, share_interval
from han_bullet.report.sweep_files import Sweep, SweepRow, read_sweep
from han_bullet.report.sweep_tables import assumptions

# Metric of which the mean over runs (worst run) is shown; of several people the mean, and which end is worst.
SHOWN = (
    ("person_position_rmse", max),
    ("mota", min),
    ("robot_position_rmse", max),
    ("personal_space_intrusion", max),
)
PAIRED = ("personal_space_intrusion", "personal_space_share", "transit_time_on", "behind_seated", "minimum_distance")
ABOUT = """\
Of a metric the mean over runs (worst run); `docs/metrics.md` has the definitions. `contacts_by_person` counts who
walked into a robot that stood or did not come nearer, as the person of `jump_in` may. Somebody seated is told to be on
the seat that the map has, where the simulated person sits, so the position's RMSE says nothing in `real3` and
`real3_off`; with true people (`truth`) it is 0 everywhere. Localization is by laser unless a variant says
`told-pose`."""
TOUCHES = ("contacts_person", "contacts_by_person")
WITHOUT = "+without:social"


def number(row: SweepRow, name: str) -> float:
    """Return a metric of a run: its own, else the largest over people or devices, of distances the smallest."""
    found = [row.metrics[name]] if name in row.metrics else row.people_values(name)
    values = [float(value) for value in found if isinstance(value, int | float)]
    return (min if "distance" in name else max)(values, default=math.nan)


def passes(sweep: Sweep, variants: Sequence[str]) -> str:
    """Return a row per world and variant: met of all with Wilson's interval, touches, perception."""
    rows: list[list[object]] = []
    for world in sweep.worlds:
        for variant in variants:
            runs = sweep.of(world, variant)
            if runs:
                met = sum(run.passed and run.error is None for run in runs)
                within = share_interval(met, len(runs))
                touches = [int(np.nansum([number(run, name) for run in runs])) for name in TOUCHES]
                shown = [_mean_and_worst(runs, name, worst) for name, worst in SHOWN]
                share = f"{within.low:.0%} to {within.high:.0%}"
                rows.append([world, variant, f"**{met} of {len(runs)}**", share, *touches, *shown])
    return markdown_table(("world", "variant", "met", "95 %", *TOUCHES, *(name for name, _ in SHOWN)), rows)


def _mean_and_worst(runs: Sequence[SweepRow], name: str, worst: object) -> str:
    values = [value for run in runs if math.isfinite(value := number(run, name))]
    return f"{np.mean(values):.3f} ({worst(values):.3f})" if values and callable(worst) else "-"


def layers_against_none(sweep: Sweep, variant: str) -> str | None:
    """Return paired means with the social layers and without, over common seeds; None where one was not run."""
    rows: list[list[object]] = []
    for world in sweep.worlds:
        for name in PAIRED:
            ways = [_by_seed(sweep.of(world, one), name) for one in (variant, variant + WITHOUT)]
            found = compare(*ways)
            if found is not None and not found.equal:
                within = "-" if found.interval is None else f"{found.interval.low:.4f} to {found.interval.high:.4f}"
                ratio = "-" if found.ratio is None else f"{found.ratio:.2f}"
                means = (f"{found.mean:.4f}", f"{found.baseline_mean:.4f}")
                rows.append([world, name, found.pairs, *means, ratio, within])
    columns = ("world", "metric", "pairs", "with layers", "without", "ratio", "95 % of the difference")
    return markdown_table(columns, rows) if rows else None


def _by_seed(runs: Sequence[SweepRow], name: str) -> dict[int, float]:
    return {run.seed: value for run in runs if math.isfinite(value := number(run, name))}


def transits(sweep: Sweep, variant: str) -> str | None:
    """Return the share of runs that crossed between viewer and device while it was on; None without such a world."""
    rows: list[list[object]] = []
    for world in sweep.worlds:
        for one in (variant, variant + WITHOUT):
            runs = [run for run in sweep.of(world, one) if _went_on(run)]
            crossed = sum(number(run, "transit_time_on") > 0.0 for run in runs)
            if runs:
                rows.append([world, one, f"{crossed} of {len(runs)}"])
    return markdown_table(("world", "variant", "runs that crossed"), rows) if rows else None


def _went_on(run: SweepRow) -> bool:
    return math.isfinite(number(run, "replan_delay"))


def sensitivity(sweep: Sweep) -> str | None:
    """Return how often worlds are met with each value that the paper leaves open scaled; None where none was."""
    scaled = assumptions(sweep.variants)
    rows: list[list[object]] = []
    for assumption in scaled:
        cells = [_met(sweep.of(world, assumption.variant)) for world in sweep.worlds]
        rows.append([assumption.name, f"x {assumption.factor:g}", assumption.unchanged, *cells])
    for unchanged in dict.fromkeys(assumption.unchanged for assumption in scaled):
        rows.insert(0, ["unchanged", "", unchanged, *(_met(sweep.of(world, unchanged)) for world in sweep.worlds)])
    return markdown_table(("value", "", "variant", *sweep.worlds), rows) if scaled else None


def _met(runs: Sequence[SweepRow]) -> str:
    return f"{sum(run.passed for run in runs)} of {len(runs)}" if runs else "-"


def unmet(sweep: Sweep, variants: Sequence[str]) -> str:
    """Return a line for each run that did not meet everything."""
    failed = [run for run in sweep.rows if run.variant in variants and (run.error or not run.passed)]
    return "\n".join(f"- {run.world}, {run.variant}, seed {run.seed}: {run.error or run.failed}" for run in failed)


def section(folder: Path) -> str:
    """Return a sweep's tables."""
    sweep = read_sweep(folder)
    scaled = {assumption.variant for assumption in assumptions(sweep.variants)}
    plain = [variant for variant in sweep.variants if variant not in scaled]
    whole = [variant for variant in plain if not variant.endswith(WITHOUT)]
    commits = ", ".join(sorted({_short(run.git_commit) for run in sweep.rows}))
    parts = [f"### Sweep {folder.name}\n\n{len(sweep.rows)} runs, commit {commits}"]
    parts += [sensitivity(sweep) or passes(sweep, plain)]
    for variant in whole:
        for title, found in (
            ("Social layers against none", layers_against_none(sweep, variant)),
            ("Between viewer and television while it is on", transits(sweep, variant)),
        ):
            if found is not None and any(run.variant == variant + WITHOUT for run in sweep.rows):
                parts.append(f"**{title}: {variant}**, paired by seed\n\n{found}")
    failures = unmet(sweep, whole)
    return "\n\n".join([*parts, f"Not met:\n\n{failures}"] if failures else parts)


def _short(commit: str) -> str:
    """Return a commit's first digits, still marked where files differed."""
    digits, dash, mark = commit.partition("-")
    return digits[:12] + dash + mark


def main() -> None:
    """Print the tables, or write them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("sweeps", nargs="+", type=Path, metavar="SWEEP")
    parser.add_argument("--write", action="store_true", help="into benchmarks/RESULTS.md")
    options = parser.parse_args()
    text = "\n\n".join([ABOUT, *(section(folder) for folder in options.sweeps)])
    if options.write:
        write_sweeps(text)
    else:
        print(text)


if __name__ == "__main__":
    main()
