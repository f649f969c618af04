"""Write files in one go: a reader, or an interruption, never meets half of one."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def write_at_once(path: Path, content: bytes) -> None:
    """Write a file by renaming a finished one, so that an interruption leaves the old file or the new, never half."""
    temporary = path.with_name(f"{path.name}.tmp")  # in the same folder: renaming across disks would be copying
    try:
        temporary.write_bytes(content)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_json(path: Path, document: dict[str, Any]) -> None:
    """Write a JSON file in one go; a number that is not finite raises ValueError."""
    write_at_once(path, (json.dumps(document, indent=2, allow_nan=False) + "\n").encode())
