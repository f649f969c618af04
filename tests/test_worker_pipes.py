"""Workers: what they meet is told, and one that does not end is ended."""

import signal
import time
from multiprocessing.connection import Connection

import pytest

from han_bullet import worker_pipes
from han_bullet.errors import BadInputError, WorkerDiedError
from han_bullet.fork_server import worker_context
from han_bullet.worker_pipes import Worker, answered, serving


def double(connection: Connection, most: int) -> None:
    """Answer numbers with their double."""
    with serving(connection):
        while True:
            number = connection.recv()
            if number > most:
                raise BadInputError(f"number is {number}; at most {most} would be right")
            connection.send(2 * number)


def sleep(connection: Connection) -> None:
    with serving(connection):
        connection.send("asleep")
        time.sleep(600.0)


def test_an_error_of_ours_that_a_worker_meets_is_raised_where_its_answer_is_taken_and_then_it_has_ended() -> None:
    worker = Worker.started(worker_context(), "doubler", double, 5)
    worker.send(4)
    assert worker.receive() == 8
    worker.send(6)
    with pytest.raises(BadInputError, match="number is 6; at most 5"):
        worker.receive()
    with pytest.raises(WorkerDiedError, match=r"doubler \(process \d+\) ended with exit code 0"):
        worker.receive()
    worker.stop()


def test_only_workers_that_have_answered_are_told_in_the_order_in_which_they_were_asked_about() -> None:
    workers = [Worker.started(worker_context(), f"doubler-{number}", double, 5) for number in range(3)]
    try:
        for worker in (workers[2], workers[0]):
            worker.send(1)
            assert worker.connection.poll(60.0)
        assert answered(workers) == [workers[0], workers[2]]
        assert answered([workers[1]], timeout=0.0) == []
    finally:
        for worker in workers:
            worker.stop()
    assert [worker.process.exitcode for worker in workers] == [0, 0, 0]


def test_a_worker_that_does_not_react_to_the_end_is_terminated(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker_pipes, "STOP_WITHIN", 0.05)
    worker = Worker.started(worker_context(), "sleeper", sleep)
    assert worker.receive() == "asleep"
    worker.stop()
    assert worker.process.exitcode == -signal.SIGTERM
