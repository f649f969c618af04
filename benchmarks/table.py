"""Markdown tables and the line that says where a figure comes from."""

import os
import platform
import subprocess
from collections.abc import Iterable, Sequence
from pathlib import Path

from han_bullet.markdown import markdown_table
from han_bullet.provenance import processor


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a Markdown table; floats show three digits."""
    shown = [[f"{cell:.3g}" if isinstance(cell, float) else str(cell) for cell in row] for row in rows]
    return markdown_table(header, shown)


def provenance() -> str:
    """Return commit and machine in a line."""
    folder = Path(__file__).parent
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty"]
    commit = subprocess.run(command, capture_output=True, text=True).stdout.strip() or "unknown"
    return f"commit {commit}; {os.cpu_count()} x {processor()}; Python {platform.python_version()}"
