"""Meetings that the paper does not have: head-on, crossing, beside a doorway, and two people abreast.

Run them with `python -m experiments.encounters`; the results land in runs/, a folder per world.
"""

from pathlib import Path

from experiments.telling import run_and_tell
from han_bullet.runner import RunOptions, RunResult

FIGURES = {
    "head_on": ("minimum_distance.walker", "passing_side.walker", "stalled_time"),
    "crossing": ("minimum_distance.walker", "stalled_time"),
    "doorway": ("minimum_distance.bystander", "stalled_time"),
    "two_abreast": ("minimum_distance.one", "minimum_distance.other", "stalled_time"),
}


def main(world: str, options: RunOptions = RunOptions(), folder: Path | None = None) -> RunResult:  # noqa: B008 (frozen)
    """Run one of the meetings and say how it went."""
    return run_and_tell(world, options, folder or Path("runs") / world, *FIGURES[world])


if __name__ == "__main__":
    for name in FIGURES:
        main(name)
