"""The line that says where a figure comes from."""

import os
import platform

from han_bullet.provenance import git_commit, processor


def provenance() -> str:
    """Return commit and machine in a line."""
    return f"commit {git_commit()}; {os.cpu_count()} x {processor()}; Python {platform.python_version()}"
