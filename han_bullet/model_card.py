"""The card of weights that were just trained: data, command, seed, date, and what the training said."""

from __future__ import annotations

import shlex
import sys
import time
from datetime import date
from pathlib import Path
from types import TracebackType
from typing import TextIO

from han_bullet.atomic_file import write_at_once
from han_bullet.markdown import markdown_table
from han_bullet.provenance import git_commit, processor, versions

LINES_SHOWN = 40  # of the log, its last ones


class TrainingLog:
    """Lines with the time since the start, written as they come.

    The file is opened with the first line: a training that cannot start leaves an earlier one's log alone.

    Args:
        path: File.
        resumed: Whether it goes on from the lines that the file has.

    Attributes:
        lines: All of them.
    """

    def __init__(self, path: Path, resumed: bool = False) -> None:
        self.path, self.resumed = path, resumed
        self.lines: list[str] = []
        self._started = time.perf_counter()
        self._file: TextIO | None = None

    def write(self, line: str) -> None:
        """Add a line."""
        if self._file is None:
            if self.resumed and self.path.is_file():
                self.lines = self.path.read_text(encoding="utf-8").splitlines()
            self._file = self.path.open("a" if self.resumed else "w", encoding="utf-8")
        self.lines.append(f"{self.seconds():7.1f} s  {line}")
        self._file.write(self.lines[-1] + "\n")
        self._file.flush()

    def seconds(self) -> float:
        """Return the time since the start, or since it was resumed [s]."""
        return time.perf_counter() - self._started

    def __enter__(self) -> TrainingLog:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if self._file is not None:
            self._file.close()


def write_model_card(weights: Path, training: str, measuring: str, seed: int, data: Path, log: TrainingLog) -> Path:
    """Write `<weights>.md` and return its path.

    Args:
        weights: The file that the card is about.
        training: What was done, such as "train acf".
        measuring: The command that prints the figures of these weights.
        seed: Of the training.
        data: Folder of the photographs.
        log: Of the training, complete.
    """
    command = shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]])
    libraries = ", ".join(f"{name} {version}" for name, version in versions().items())
    since = " since it was resumed" if log.resumed else ""
    rows = {
        "file": f"`{weights.name}`, {weights.stat().st_size / 1000:.0f} kB",
        "command": f"`{command}`",
        "data": f"INRIA Person photographs in `{data.resolve().name}`; they are for research use and not included",
        "seed": str(seed),
        "date": date.today().isoformat(),
        "training time": f"{log.seconds():.0f} s{since} on {processor()}",
        "commit": git_commit(),
        "versions": libraries,
    }
    table = markdown_table(("", ""), [(name, text.replace("|", "\\|")) for name, text in rows.items()])
    shown = "\n".join(log.lines[-LINES_SHOWN:])
    last = f", the last {LINES_SHOWN} lines of {len(log.lines)}" if len(log.lines) > LINES_SHOWN else ""
    text = (
        f"# {weights.stem}: made by `{training}`\n\n{table}\n\n"
        f"## Log{last}\n\n```\n{shown}\n```\n\n## Figures\n\n"
        f"Not measured yet: `{measuring}` prints them.\n"
    )
    path = weights.with_suffix(".md")
    write_at_once(path, text.encode())
    return path
