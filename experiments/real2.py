"""The paper's second experiment: a standing person walks off as the robot moves and is overtaken on the left.

Run it with `python -m experiments.real2`; the results land in runs/real2/.
"""

from pathlib import Path

from experiments.telling import run_and_tell
from han_bullet.runner import RunOptions, RunResult


def main(options: RunOptions = RunOptions(), folder: Path = Path("runs/real2")) -> RunResult:  # noqa: B008 (frozen)
    """Run the experiment once and say how it went."""
    return run_and_tell("real2", options, folder, "overtaking_side.walker", "minimum_distance.walker")


if __name__ == "__main__":
    main()
