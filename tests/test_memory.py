"""Memory of a process and of those below it, on real processes."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from han_bullet.memory import peak_memory, peak_resident, process_tree, proportional_share

MEBIBYTES = 64
HOLD = f"held = b'x' * ({MEBIBYTES} << 20); print(flush=True); input()"
HOLD_BELOW = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {HOLD!r}])"


@contextmanager
def running(code: str) -> Iterator[int]:
    """A process, or one below it, that holds memory until the block ends."""
    process = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert process.stdout and process.stdout.readline() == b"\n"
    try:
        yield process.pid
    finally:
        process.communicate(b"\n")


def test_a_process_has_what_it_holds() -> None:
    with running(HOLD) as process:
        assert MEBIBYTES << 10 <= proportional_share(process) <= peak_resident(process)
        assert peak_resident(process) < (MEBIBYTES + 40) << 10


def test_the_tree_reaches_processes_that_children_have_started() -> None:
    with running(HOLD_BELOW) as process:
        tree = list(process_tree(process))
        assert tree[0] == process and len(tree) == 2
        assert set(tree) < set(process_tree(os.getpid()))


def test_the_peak_counts_all_processes_below() -> None:
    alone = peak_memory()
    with running(HOLD_BELOW):
        assert MEBIBYTES <= peak_memory() - alone < MEBIBYTES + 80


def test_a_process_that_has_ended_has_no_memory_and_nothing_below_it() -> None:
    with running(HOLD) as process:
        pass
    assert (peak_resident(process), proportional_share(process)) == (0, 0)
    assert list(process_tree(process)) == [process]
