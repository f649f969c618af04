"""Where the runs of a sweep are carried out: processes of this machine, or of a dask cluster that is there already."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import tempfile
from collections.abc import Iterator

import dask
from distributed import Client, LocalCluster
from distributed.comm.addressing import get_address_host_port

from han_bullet.errors import BadInputError, quoted
from han_bullet.fork_server import worker_context

ANSWER_WITHIN = 10.0  # [s] for a scheduler
WORKERS_WITHIN = 60.0  # [s] for its first worker
SETTINGS = {
    "distributed.worker.multiprocessing-method": "forkserver",  # ours, which imports once for all and ignores Ctrl-C
    "distributed.worker.profile.enabled": False,
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
    "distributed.scheduler.worker-saturation": 1.0,  # a worker that dies is then blamed on the one run it had
}


@contextlib.contextmanager
def local_workers(count: int) -> Iterator[Client]:
    """Lend processes of this machine, each with one thread and used for one run after the other.

    Only this machine can reach them, and there is no dashboard. One that dies is replaced.
    """
    worker_context()  # its server imports while dask starts
    with contextlib.ExitStack() as closing:
        closing.enter_context(dask.config.set(SETTINGS))
        closing.enter_context(_quiet())
        scratch = closing.enter_context(tempfile.TemporaryDirectory(prefix="han-bullet-"))
        cluster = closing.enter_context(
            LocalCluster(
                n_workers=count,
                threads_per_worker=1,
                processes=True,
                host="127.0.0.1",
                dashboard_address="127.0.0.1:0",  # no address would be port 8787, and a warning where that is taken
                scheduler_kwargs={"dashboard": False},
                memory_limit=0,  # dask would end a worker whose run needs much
                silence_logs=logging.CRITICAL,
                local_directory=scratch,
            )
        )
        yield closing.enter_context(Client(cluster, set_as_default=False))


@contextlib.contextmanager
def remote_workers(scheduler: str) -> Iterator[Client]:
    """Lend the workers of a cluster.

    Args:
        scheduler: Its address, for example tcp://10.0.0.1:8786.

    Raises:
        BadInputError: It is no address, nothing answers there, or no worker comes.
    """
    try:  # a client that never got an address would complain once more as it is thrown away
        get_address_host_port(scheduler, strict=True)
    except ValueError as error:
        raise BadInputError(
            f"scheduler {scheduler!r} is no address; one like tcp://10.0.0.1:8786 would be right"
        ) from error
    with contextlib.ExitStack() as closing:
        closing.enter_context(_quiet())
        try:
            client = closing.enter_context(Client(scheduler, timeout=ANSWER_WITHIN, set_as_default=False))
        except (OSError, ValueError) as error:
            raise BadInputError(f"no dask scheduler answers at {scheduler!r}: {quoted(error)}") from error
        try:
            client.wait_for_workers(1, timeout=WORKERS_WITHIN)
        except asyncio.TimeoutError as error:  # in Python 3.10 not yet the built-in one
            raise BadInputError(
                f"the dask scheduler at {scheduler!r} has no worker; start one with dask worker"
            ) from error
        yield client


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Keep dask's own tale of what happens to workers away from the terminal: a sweep tells what matters."""
    names = ("distributed", "distributed.client", "distributed.gc", "tornado", "tornado.application", "asyncio")
    before = {name: logging.getLogger(name).level for name in names}
    for name in names:
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for name, level in before.items():
            logging.getLogger(name).setLevel(level)
