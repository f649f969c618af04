"""The card of weights that were just trained: data, command, seed, date, and what the training said."""

from __future__ import annotations

import shlex
import sys
import time
from datetime import date
from pathlib import Path
from types import TracebackType

from han_bullet.atomic_file import write_at_once
from han_bullet.provenance import git_commit, processor, versions

LINES_SHOWN = 40  # of the log, its last ones


class TrainingLog:
    """Lines with the time since the start, written as they come.

    Attributes:
        path: File.
        lines: All of them.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.lines: list[str] = []
        self._started = time.perf_counter()
        self._file = path.open("w", encoding="utf-8")

    def write(self, line: str) -> None:
        """Add a line."""
        self.lines.append(f"{self.seconds():7.1f} s  {line}")
        self._file.write(self.lines[-1] + "\n")
        self._file.flush()

    def seconds(self) -> float:
        """Return the time since the start [s]."""
        return time.perf_counter() - self._started

    def __enter__(self) -> TrainingLog:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._file.close()


def write_model_card(weights: Path, training: str, seed: int, data: Path, log: TrainingLog) -> Path:
    """Write `<weights>.md` and return its path.

    Args:
        weights: The file that the card is about.
        training: What was done, such as "train acf".
        seed: Of the training.
        data: Folder of the photographs.
        log: Of the training, complete.
    """
    command = shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]])
    libraries = ", ".join(f"{name} {version}" for name, version in versions().items())
    rows = {
        "file": f"`{weights.name}`, {weights.stat().st_size / 1000:.0f} kB",
        "command": f"`{command}`",
        "data": f"INRIA Person photographs in `{data.name}`; they are for research use and not included",
        "seed": str(seed),
        "date": date.today().isoformat(),
        "training time": f"{log.seconds():.0f} s on {processor()}",
        "commit": git_commit(),
        "versions": libraries,
    }
    table = "\n".join(f"| {name} | {value} |" for name, value in rows.items())
    shown = "\n".join(log.lines[-LINES_SHOWN:])
    text = (
        f"# {weights.stem}: made by `{training}`\n\n| | |\n|---|---|\n{table}\n\n"
        f"## Log\n\n```\n{shown}\n```\n\n## Figures\n\n"
        "Not measured yet: `han-bullet evaluate --data DIR` prints them.\n"
    )
    path = weights.with_suffix(".md")
    write_at_once(path, text.encode())
    return path
