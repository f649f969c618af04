"""How soon `han-bullet run` takes its first simulated step, and how much memory a run needs.

Usage: python -m benchmarks.footprint [--world real2] [--rounds 5] [--workers 2]

Real processes are watched from outside. The first step is over when trace.csv, which is flushed tick by tick, has a
row beyond that of the start; the processor time by then tells a busy machine from a slow start. Memory is sampled from
then on, over the process and all below it: the greatest sum of their proportional shares (PSS: a page that n processes
use counts 1/n in each) and, as an upper bound, the sum of each one's own peak (RSS), which counts shared pages in each.
A run that is thrown away comes first, so that caches are warm.
"""

import argparse
import contextlib
import dataclasses
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.provenance import provenance
from han_bullet.markdown import markdown_table
from han_bullet.memory import peak_resident, process_tree, proportional_share

PROGRAM = Path(sys.executable).with_name("han-bullet")
RUNS = {
    "five cameras": ("--no-video",),
    "five cameras, video": (),
    "--perception truth": ("--perception", "truth", "--no-video"),
}
OTHERS = (("--help",), ("worlds",))
STEP_CHECK_PERIOD = 0.01  # [s]
MEMORY_PERIOD = 0.2  # [s]
ROWS_AFTER_ONE_STEP = 3  # lines of trace.csv: the header, the start, the first step


@dataclass(frozen=True)
class Footprint:
    """What one run took.

    Attributes:
        first_step: From the start of the process to the end of the first simulated step [s].
        processor: What all processes together had used of the processors by then [s].
        shared: Greatest sum of proportional shares [MiB].
        resident: Sum of each process's own peak [MiB].
        processes: How many there were.
    """

    first_step: float
    processor: float
    shared: float
    resident: float
    processes: int


class MemoryWatch:
    """Sample the memory of a process and all below it, and keep the peaks.

    Args:
        process: Its id.
    """

    def __init__(self, process: int) -> None:
        self._process = process
        self._residents: dict[int, int] = {}
        self._shared = 0

    def sample(self) -> None:
        """Look once."""
        processes = list(process_tree(self._process))
        self._shared = max(self._shared, sum(map(proportional_share, processes)))
        for process in processes:
            self._residents[process] = max(peak_resident(process), self._residents.get(process, 0))

    def footprint(self, first_step: float, processor: float) -> Footprint:
        """Return what was seen, with the times of the first step [s]."""
        resident = sum(self._residents.values())
        return Footprint(first_step, processor, self._shared / 1024, resident / 1024, len(self._residents))


def processor_time(process: int) -> float:
    """Return what a process and all below it have used of the processors so far [s]."""
    ticks = 0
    for one in process_tree(process):
        with contextlib.suppress(OSError):  # it has ended
            user, system = Path(f"/proc/{one}/stat").read_text().rpartition(")")[2].split()[11:13]
            ticks += int(user) + int(system)
    return ticks / os.sysconf("SC_CLK_TCK")


def has_stepped(trace: Path) -> bool:
    """Tell whether a trace has the row that follows the first simulated step."""
    try:
        return trace.read_bytes().count(b"\n") >= ROWS_AFTER_ONE_STEP
    except FileNotFoundError:
        return False


def measure(command: Sequence[str], folder: Path) -> Footprint:
    """Run a command that writes trace.csv into a new folder, and watch it.

    Raises:
        SystemExit: The command has failed, or ended without a step.
    """
    started = time.perf_counter()
    with subprocess.Popen([*command, "--out", str(folder)], stdout=subprocess.DEVNULL) as process:
        while not has_stepped(folder / "trace.csv"):
            if process.poll() is not None:
                raise SystemExit(f"{' '.join(command)} ended with {process.returncode} before its first step")
            time.sleep(STEP_CHECK_PERIOD)
        first_step, processor = time.perf_counter() - started, processor_time(process.pid)
        memory = MemoryWatch(process.pid)
        while process.poll() is None:
            memory.sample()
            time.sleep(MEMORY_PERIOD)
    if process.returncode != 0:
        raise SystemExit(f"{' '.join(command)} ended with {process.returncode}")
    return memory.footprint(first_step, processor)


def seconds_of(arguments: Sequence[str]) -> float:
    """Return how long a command of `han-bullet` takes from start to end [s]."""
    started = time.perf_counter()
    subprocess.run([PROGRAM, *arguments], stdout=subprocess.DEVNULL, check=True)
    return time.perf_counter() - started


def run_row(name: str, footprints: Sequence[Footprint]) -> tuple[object, ...]:
    """Return a line of the table of runs: medians over the rounds, but for the slowest first step."""
    columns = np.array([dataclasses.astuple(one) for one in footprints])
    first_step, processor, shared, resident, processes = np.median(columns, axis=0).tolist()
    times = (f"{seconds:.2f}" for seconds in (first_step, columns[:, 0].max(), processor))
    return name, *times, round(shared), round(resident), round(processes)


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--world", default="real2")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--workers", type=int, default=2, help="camera processes")
    options = parser.parse_args()
    load = os.getloadavg()[0]
    command = [str(PROGRAM), "run", options.world, "--workers", str(options.workers)]
    footprints: dict[str, list[Footprint]] = {name: [] for name in RUNS}
    with tempfile.TemporaryDirectory() as scratch:
        measure(command, Path(scratch, "caches"))
        for number in range(options.rounds):
            for name, arguments in RUNS.items():
                footprints[name].append(measure([*command, *arguments], Path(scratch, f"{name} {number}")))
    others = [[seconds_of(arguments) for _ in range(options.rounds)] for arguments in OTHERS]
    print(f"### Start and memory of `han-bullet run {options.world}`\n")
    how = f"{options.workers} worker processes, {options.rounds} rounds; medians"
    print(f"{provenance()}; load {load:.1f} before; {how}\n")
    header = ("run", "first step after [s]", "slowest [s]", "processor time by then [s]", "peak memory (PSS) [MiB]")
    rows = [run_row(name, found) for name, found in footprints.items()]
    print(markdown_table((*header, "sum of the processes' peaks (RSS) [MiB]", "processes"), rows) + "\n")
    lines = [
        (f"`han-bullet {' '.join(arguments)}`", f"{np.median(taken):.2f}", f"{max(taken):.2f}")
        for arguments, taken in zip(OTHERS, others, strict=True)
    ]
    print(markdown_table(("command", "median [s]", "slowest [s]"), lines))


if __name__ == "__main__":
    main()
