"""How a sweep goes on, on the terminal: a progress bar, or, where nobody watches, a line now and then."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from han_bullet.sweep.running import Onlooker, of_other_commits

LINE_PERIOD = 10.0  # [s] of wall clock between lines


class SweepBar(Onlooker):
    """Show runs done of all, runs per minute, time left and unmet expectations so far.

    Args:
        console: Where to draw; what is no terminal gets lines.
    """

    def __init__(self, console: Console) -> None:
        self._console = console
        self._bar = Progress(
            TextColumn("[bold]sweep"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[pace]}"),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        self._runs = self._done = self._unmet = self._errors = 0
        self._began = self._told = time.perf_counter()

    def started(self, runs: int, kept: Sequence[dict[str, Any]]) -> None:
        """Say what is kept, and show the bar."""
        if kept:
            self._console.print(f"kept from before: {len(kept)} (--fresh does them again)", soft_wrap=True)
        others = of_other_commits(kept)
        if others:
            example = f"{others[0]['folder']} of {others[0]['git_commit']}"
            self._console.print(
                f"[yellow]of another commit[/]: {len(others)} of them, such as {escape(example)}", soft_wrap=True
            )
        self._runs, self._began = runs, time.perf_counter()
        self._task = self._bar.add_task("", total=runs, pace="starting")
        if runs:
            self._bar.start()

    def ended(self, row: dict[str, Any]) -> None:
        """Count a run."""
        self._done += 1
        self._errors += row["error"] is not None
        self._unmet += row["error"] is None and not row["passed"]
        self._bar.update(self._task, completed=self._done, pace=self._pace())
        now = time.perf_counter()
        if not self._console.is_terminal and (now - self._told > LINE_PERIOD or self._done == self._runs):
            self._told = now
            self._console.print(f"{self._done} of {self._runs} runs, {self._pace()}", soft_wrap=True)

    def close(self) -> None:
        """Take the bar away."""
        self._bar.stop()

    def _pace(self) -> str:
        per_minute = self._done / max(time.perf_counter() - self._began, 1e-9) * 60.0
        left = (self._runs - self._done) / per_minute
        told = f"{per_minute:.1f} a minute, {_duration(left)} left, expectations not met in {self._unmet}"
        return told + (f", not run: {self._errors}" if self._errors else "")


def _duration(minutes: float) -> str:
    hours, seconds = int(minutes // 60), round(minutes * 60.0)
    return f"{hours} h {int(minutes % 60)} min" if hours else f"{seconds // 60}:{seconds % 60:02d} min"
