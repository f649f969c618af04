"""One run of a sweep where a worker process carries it out: a world file goes in, the run's files come out.

Nothing but what is passed in and returned is shared with whoever asks, so a worker may be on another machine.
"""

from __future__ import annotations

import tempfile
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


def carry_out(name: str, content: bytes, options: RunOptions) -> Outcome:
    """Run a world to its end.

    Args:
        name: Of the world.
        content: Of its YAML file.
        options: How to run it.
    """
    with tempfile.TemporaryDirectory(prefix="han-bullet-") as place:
        world, folder = Path(place, f"{name}.yaml"), Path(place, "run")
        world.write_bytes(content)
        error = None
        try:
            run_world(world, options, folder)
        except HanError as wrong:
            error = str(wrong).replace(f"{place}/", "")
        return Outcome({file.name: file.read_bytes() for file in sorted(folder.glob("*"))}, error)
