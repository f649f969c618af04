"""A progress bar for a run, with the real-time factor."""

from __future__ import annotations

import time

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from han_bullet.episode import Hook, Tick

REFRESH_PERIOD = 0.25  # [s] of wall clock
GETTING_READY = "getting ready; the first run after an installation compiles, for a minute"


class ProgressBar(Hook):
    """Show simulated time, status and real-time factor while a run goes on, and that it gets ready before.

    Args:
        name: Of the world.
        duration: When the run ends at the latest [s].
        console: Where to draw.
    """

    def __init__(self, name: str, duration: float, console: Console) -> None:
        self._bar = Progress(
            TextColumn("[bold]{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[status]}"),
            TimeElapsedColumn(),
            console=console,
            transient=True,
        )
        self._task = self._bar.add_task(escape(name), total=duration, status=GETTING_READY)
        self._started: float | None = None
        self._drawn = 0.0
        self._bar.start()

    def record(self, tick: Tick) -> None:
        """Move the bar on, a few times a second."""
        now = time.perf_counter()
        if self._started is None:
            self._started = now
        if now - self._drawn < REFRESH_PERIOD:
            return
        self._drawn = now
        simulated = tick.observation.time
        factor = simulated / max(now - self._started, 1e-9)
        status = f"{simulated:5.1f} s simulated, {factor:.2f} x real time, {tick.decision.status.value}"
        self._bar.update(self._task, completed=simulated, status=status)

    def close(self) -> None:
        """Take the bar away; may be called again."""
        self._bar.stop()
