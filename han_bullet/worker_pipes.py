"""Worker processes and the pipes to them: whoever has died, or met an error of ours, is told by an exception."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import ForkServerContext
from typing import Any

from han_bullet.errors import HanError, WorkerDiedError
from han_bullet.fork_server import without_main_module

STOP_WITHIN = 5.0  # [s] before a worker that does not react to the end is terminated


@dataclass(frozen=True, eq=False)
class Worker:
    """A process, and our end of the pipe to it."""

    process: Any
    connection: Connection

    @classmethod
    def started(cls, context: ForkServerContext, name: str, serve: Callable[..., None], *arguments: object) -> Worker:
        """Start a process whose body is `serve`; it takes its end of the pipe and the arguments."""
        ours, theirs = context.Pipe()
        process = context.Process(target=serve, args=(theirs, *arguments), name=name, daemon=True)
        with without_main_module():
            process.start()
        theirs.close()
        return cls(process, ours)

    def send(self, message: object) -> None:
        """Hand a message to the worker.

        Raises:
            WorkerDiedError: It has ended.
        """
        try:
            self.connection.send(message)
        except (BrokenPipeError, ConnectionResetError) as error:
            raise self._death() from error

    def receive(self) -> Any:
        """Take one answer of the worker.

        Raises:
            HanError: The worker met it.
            WorkerDiedError: It has ended.
        """
        try:
            answer = self.connection.recv()
        except (EOFError, ConnectionResetError) as error:
            raise self._death() from error
        if isinstance(answer, HanError):
            raise answer
        return answer

    def stop(self) -> None:
        """Let the worker end, or end it."""
        self.connection.close()
        self.process.join(STOP_WITHIN)
        if self.process.is_alive():
            self.process.terminate()
            self.process.join()

    def _death(self) -> WorkerDiedError:
        process = self.process
        process.join(1.0)
        return WorkerDiedError(f"{process.name} (process {process.pid}) ended with exit code {process.exitcode}")


def answered(workers: Iterable[Worker], timeout: float | None = None) -> list[Worker]:
    """Return those workers, in their order, that have answered; wait for the first one, at most so long [s]."""
    workers = list(workers)
    ready = wait([worker.connection for worker in workers], timeout)
    return [worker for worker in workers if worker.connection in ready]


@contextlib.contextmanager
def serving(connection: Connection) -> Iterator[None]:
    """Serve a main process until it closes the pipe or has gone; an error of ours is handed to it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the keyboard stops the main process, which then closes the pipe
    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError):
        try:
            yield
        except HanError as error:
            connection.send(error)
