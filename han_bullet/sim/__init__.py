"""Everything that touches PyBullet: building, robot, people, cameras, devices."""

import os


def _import_pybullet_quietly() -> None:
    """Import PyBullet without the line about its build that its C code writes to stderr, once per process."""
    stderr, nothing = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nothing, 2)
        import pybullet  # noqa: F401
    finally:
        os.dup2(stderr, 2)
        os.close(stderr)
        os.close(nothing)


_import_pybullet_quietly()
