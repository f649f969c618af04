"""Memory of processes, as Linux tells it; what only /proc knows is 0 elsewhere."""

from __future__ import annotations

import os
import resource
from collections.abc import Iterator
from pathlib import Path


def peak_memory() -> int:
    """Return the sum of the peaks of this process and of all below it that are still running [MiB].

    What processes share is counted in each, so this is an upper bound.
    """
    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    _, *others = process_tree(os.getpid())
    return round((own + sum(map(peak_resident, others))) / 1024)


def process_tree(process: int) -> Iterator[int]:
    """Return a process and all below it."""
    yield process
    try:
        children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    except OSError:  # it has ended
        return
    for child in children:
        yield from process_tree(int(child))


def peak_resident(process: int) -> int:
    """Return the most memory that a process has had in use, shared or not [KiB]; 0 if it has ended."""
    return _entry(f"/proc/{process}/status", "VmHWM:")


def proportional_share(process: int) -> int:
    """Return what a process uses now, each page divided by the number of its users [KiB]; 0 if it has ended.

    It takes milliseconds: the kernel walks all pages.
    """
    return _entry(f"/proc/{process}/smaps_rollup", "Pss:")


def _entry(file: str, name: str) -> int:
    try:
        lines = Path(file).read_text().splitlines()
    except OSError:
        return 0
    return next((int(line.split()[1]) for line in lines if line.startswith(name)), 0)
