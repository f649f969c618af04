"""Write files in one go: a reader, or an interruption, never meets half of one."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any


@contextlib.contextmanager
def appearing_whole(path: Path) -> Iterator[Path]:
    """Give the path of a file to write, which takes the place of another when it is finished.

    An interruption leaves the old file or the new, never half.

    Raises:
        OSError: It cannot be written; named, also where the disk is full.
    """
    temporary = path.with_name(f"{path.name}.tmp")  # in the same folder: renaming across disks would be copying
    try:
        yield temporary
        temporary.replace(path)
    except OSError as error:
        if error.errno is not None and error.filename in (None, str(temporary)):
            error.filename = str(path)
        raise
    finally:
        temporary.unlink(missing_ok=True)


def write_at_once(path: Path, content: bytes) -> None:
    """Write a file in one go."""
    with appearing_whole(path) as temporary:
        temporary.write_bytes(content)


def write_json(path: Path, document: dict[str, Any]) -> None:
    """Write a JSON file in one go; a number that is not finite raises ValueError."""
    write_at_once(path, (json.dumps(document, indent=2, allow_nan=False) + "\n").encode())
