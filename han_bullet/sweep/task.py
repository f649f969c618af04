"""One run of a sweep where a worker process carries it out: world files go in, the run's files come out.

Nothing but what is passed in and returned is shared with whoever asks, so a worker may be on another machine.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from han_bullet.errors import HanError
from han_bullet.runner import RunOptions, run_world


@dataclass(frozen=True)
class Outcome:
    """What a run left.

    Attributes:
        files: Contents by file name; those of a run with an error may be few or none.
        error: What kept it from its end; None where nothing did.
    """

    files: dict[str, bytes]
    error: str | None = None


def carry_out(world: Sequence[tuple[str, bytes]], options: RunOptions) -> Outcome:
    """Run a world to its end.

    Args:
        world: Name and content of its file, then of every other one that it needs beside it.
        options: How to run it.
    """
    with tempfile.TemporaryDirectory(prefix="han-bullet-") as place:
        for name, content in world:
            Path(place, name).write_bytes(content)
        folder, error = Path(place, "run"), None
        try:
            run_world(Path(place, world[0][0]), options, folder)
        except HanError as wrong:
            error = str(wrong).replace(f"{place}/", "")
        return Outcome({file.name: file.read_bytes() for file in sorted(folder.glob("*"))}, error)
