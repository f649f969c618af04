"""How much faster a sweep is with two processes than with one.

Usage: python -m benchmarks.sweep_speed [--worlds real2,sim1] [--seeds 3] [--variant cameras] [--duration 5]

The same plan is carried out with one process and with two, in turn, each time afresh. Worlds are cut short, so that a
round takes a minute. "Steady" leaves out the start: it counts from the first row to the last, by the number of runs
that ended in it. Processor time per run tells what two processes take from each other (caches, memory, a core's clock)
even where others use the machine too.
"""

import argparse
import os
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import yaml

from benchmarks.provenance import provenance
from han_bullet.markdown import markdown_table
from han_bullet.sweep.plan import PlannedRun, plan_sweep
from han_bullet.sweep.running import Onlooker, run_sweep
from han_bullet.world_file import world_document

PROCESSES = (1, 2)


@dataclass(frozen=True)
class Speed:
    """How fast a sweep was.

    Attributes:
        whole: From the call to its return [s].
        steady: Runs per minute between the first row and the last.
        processor: Time of all its processes per run in between [s].
        factors: Real-time factor of each run.
    """

    whole: float
    steady: float
    processor: float
    factors: tuple[float, ...]


class _Times(Onlooker):
    def __init__(self) -> None:
        self.times: list[float] = []
        self.processor_times: list[float] = []

    def ended(self, row: dict[str, Any]) -> None:
        self.times.append(time.perf_counter())
        self.processor_times.append(_processor_time())


def _processor_time() -> float:
    """Return the time that this process and all below it have used so far [s]."""
    processes = [psutil.Process(), *psutil.Process().children(recursive=True)]
    return sum(sum(process.cpu_times()[:2]) for process in processes)


def measure(plan: Sequence[PlannedRun], processes: int) -> Speed:
    """Carry a plan out afresh; return how fast it was."""
    watch, started = _Times(), time.perf_counter()
    with tempfile.TemporaryDirectory() as out:
        rows = run_sweep(plan, Path(out), processes=processes, onlooker=watch)
    whole = time.perf_counter() - started
    assert len(rows) == len(plan) and all(row["error"] is None for row in rows)
    between = len(plan) - 1
    steady = 60.0 * between / (watch.times[-1] - watch.times[0])
    processor = (watch.processor_times[-1] - watch.processor_times[0]) / between
    return Speed(whole, steady, processor, tuple(row["real_time_factor"] for row in rows))


def shortened(world: str, duration: float, folder: Path) -> Path:
    """Return a copy of a shipped world that ends after a duration [s]."""
    path = folder / f"{world}.yaml"
    path.write_text(yaml.safe_dump(world_document(world) | {"duration": duration}))
    return path


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--worlds", default="real2,sim1")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--variant", default="cameras")
    parser.add_argument("--duration", type=float, default=5.0, help="of each world [s]")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    speeds: dict[int, list[Speed]] = {count: [] for count in PROCESSES}
    with tempfile.TemporaryDirectory() as folder:
        worlds = [shortened(world, options.duration, Path(folder)) for world in options.worlds.split(",")]
        plan = plan_sweep(worlds, range(options.seeds), [options.variant])
        for _ in range(options.rounds):
            for count in PROCESSES:
                speeds[count].append(measure(plan, count))
    print(f"### A sweep with one process and with two: {options.variant}\n\n{provenance()}\n")
    load = f"load of the machine {os.getloadavg()[0]:.1f}"
    print(f"{len(plan)} runs of at most {options.duration:g} s, {options.rounds} rounds in turn; {load}\n")
    headings = ("processes", "whole [s]", "runs per minute, steady", "processor time per run [s]", "real-time factor")
    print(markdown_table(headings, _rows(speeds)))
    one, two = (speeds[count] for count in PROCESSES)
    whole = np.median([a.whole / b.whole for a, b in zip(one, two, strict=True)])
    steady = np.median([b.steady / a.steady for a, b in zip(one, two, strict=True)])
    print(f"\ntwo processes are {whole:.2f} times as fast as one, start included; {steady:.2f} times once started")


def _rows(speeds: dict[int, list[Speed]]) -> list[tuple[object, ...]]:
    """Return the medians over the rounds."""
    return [
        (
            count,
            float(np.median([speed.whole for speed in found])),
            float(np.median([speed.steady for speed in found])),
            float(np.median([speed.processor for speed in found])),
            float(np.median([factor for speed in found for factor in speed.factors])),
        )
        for count, found in speeds.items()
    ]


if __name__ == "__main__":
    main()
