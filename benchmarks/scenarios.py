"""Worlds over seeds: how often the expectations are met, and the figures behind them.

Usage: python -m benchmarks.scenarios [--worlds real1,real2] [--seeds 10] [--perception cameras|truth] [--out DIR]

One run at a time has the machine to itself, unlike in a sweep, where runs share it: the real-time factor is a figure
here.
"""

import argparse
import os
from pathlib import Path

import numpy as np

from benchmarks.provenance import provenance
from han_bullet.markdown import markdown_table
from han_bullet.runner import RunOptions, RunResult, run_world
from han_bullet.world_file import world_names

SHOWN = (
    "time_to_goal",
    "distance_when_level.walker",
    "minimum_distance.walker",
    "person_position_rmse",
    "phantom_time_longest",
    "phantom_time_total",
    "contacts_person",
)


def summary(world: str, results: list[RunResult]) -> list[object]:
    """Return one row: met of all, then median (worst) of each shown metric, and the real-time factor."""
    met = sum(all(check.passed for check in result.checks) for result in results)
    row: list[object] = [world, f"{met} of {len(results)}"]
    for name in SHOWN:
        found = [m.value for r in results for m in r.metrics if m.name == name and isinstance(m.value, int | float)]
        worst = min(found, default=np.nan) if "distance" in name else max(found, default=np.nan)
        row.append(f"{np.median(found):.2f} ({worst:.2f})" if found else "-")
    row.append(f"{np.median([result.real_time_factor for result in results]):.2f}")
    return row


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--worlds", default=",".join(world_names()))
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--perception", choices=("cameras", "truth"), default="cameras")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=Path("runs/scenarios"))
    options = parser.parse_args()
    rows = []
    for world in options.worlds.split(","):
        results = []
        for seed in range(options.seeds):
            run_options = RunOptions(seed=seed, perception=options.perception, workers=options.workers, video=False)
            results.append(run_world(world, run_options, options.out / f"{world}-{options.perception}-{seed}"))
            failed = [f"{c.metric} = {c.value}, expected {c.expected}" for c in results[-1].checks if not c.passed]
            print(f"<!-- {world} seed {seed}: {'; '.join(failed) or 'all expectations met'} -->", flush=True)
        rows.append(summary(world, results))
    print(f"### Scenarios: {options.perception}, seeds 0 to {options.seeds - 1}; median (worst)\n\n{provenance()}\n")
    print(markdown_table(("world", "expectations met", *SHOWN, "real-time factor"), rows))


if __name__ == "__main__":
    main()
