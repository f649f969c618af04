"""The server that worker processes are forked from: what they find there, and whom Ctrl-C reaches."""

import importlib.util
import os
import signal
import subprocess
import sys
from multiprocessing.connection import Connection
from pathlib import Path

from han_bullet.fork_server import IMPORTED, worker_context


def tell(connection: Connection) -> None:
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, [])
    connection.send((os.getppid(), sorted(set(IMPORTED) & set(sys.modules)), signal.SIGINT in blocked))


def told_by_a_worker() -> tuple[int, list[str], bool]:
    context = worker_context()
    ours, theirs = context.Pipe()
    worker = context.Process(target=tell, args=(theirs,))
    worker.start()
    told: tuple[int, list[str], bool] = ours.recv()
    worker.join()
    return told


def test_everything_that_is_imported_early_exists() -> None:
    assert all(importlib.util.find_spec(name) for name in IMPORTED)  # the server passes over what does not


def test_workers_come_from_one_server_that_has_imported_for_them() -> None:
    (server, imported, _), (again, _, _) = told_by_a_worker(), told_by_a_worker()
    assert imported == sorted(IMPORTED)
    assert server == again != os.getpid()


def test_the_keyboard_stops_the_main_process_alone() -> None:
    _, _, blocked = told_by_a_worker()
    assert blocked
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def test_a_script_that_starts_workers_runs_once_also_where_it_does_not_ask_for_its_name(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "from multiprocessing.connection import Connection\n"
        "from han_bullet.fork_server import without_main_module, worker_context\n"
        "context = worker_context(())\n"
        "ours, theirs = context.Pipe()\n"
        "with without_main_module():\n"
        "    context.Process(target=Connection.send, args=(theirs, 'from the worker')).start()\n"
        "print(ours.recv(), 'to', __name__)\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=60)
    assert (done.stdout, done.stderr) == ("from the worker to __main__\n", "")
