"""How a main process talks to its workers: whoever has died, or met an error of ours, is told by an exception."""

from __future__ import annotations

from multiprocessing.connection import Connection
from typing import Any

from han_bullet.errors import HanError, WorkerDiedError


def send(process: Any, connection: Connection, message: object) -> None:
    """Hand a message to a worker.

    Raises:
        WorkerDiedError: It has ended.
    """
    try:
        connection.send(message)
    except (BrokenPipeError, ConnectionResetError) as error:
        raise _death(process) from error


def receive(process: Any, connection: Connection) -> Any:
    """Take one answer of a worker.

    Raises:
        HanError: The worker met it.
        WorkerDiedError: It has ended.
    """
    try:
        answer = connection.recv()
    except (EOFError, ConnectionResetError) as error:
        raise _death(process) from error
    if isinstance(answer, HanError):
        raise answer
    return answer


def _death(process: Any) -> WorkerDiedError:
    process.join(1.0)
    return WorkerDiedError(f"{process.name} (process {process.pid}) ended with exit code {process.exitcode}")
