"""Where worker processes come from: a server process that imports once what they all need, and forks them.

Torch, numba and what they draw in take one and a half seconds to import, and a process that has done so holds 330 MB.
With a server, the workers share both, and one that is started early imports while the main process does other things.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import signal
import sys
from collections.abc import Iterator, Sequence
from multiprocessing import forkserver, resource_tracker
from multiprocessing.context import ForkServerContext
from types import ModuleType

# Importing these starts no thread that a fork would lose, and opens nothing. Numba imports its arraymath, and with it
# SciPy's linear algebra, at the first call of a compiled function.
IMPORTED = ("han_bullet.camera_workers", "han_bullet.detection.cnn", "numba.np.arraymath")


def worker_context(imported: Sequence[str] = IMPORTED) -> ForkServerContext:
    """Return the context whose processes the server forks.

    The server starts with the first call, so call it early; it ends with the calling process.

    Args:
        imported: Modules that the server imports, by the first call.
    """
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(list(imported))
    resource_tracker.ensure_running()  # which would unblock the signal again
    # What is blocked here stays so in the server: Ctrl-C is for the main process, which then ends the others.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    return context


@contextlib.contextmanager
def without_main_module() -> Iterator[None]:
    """Let processes that start meanwhile not import the program's main module, of which our workers need nothing.

    It would be imported by each, and a script that runs a world would do so once more unless it asks for its name.
    """
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main
