"""The paper's first simulation: the person ahead of the robot starts to walk slowly and is overtaken on the left.

Run it with `python -m experiments.sim1`; the results land in runs/sim1/.
"""

from pathlib import Path

from experiments.telling import run_and_tell
from han_bullet.runner import RunOptions, RunResult


def main(options: RunOptions = RunOptions(), folder: Path = Path("runs/sim1")) -> RunResult:  # noqa: B008 (frozen)
    """Run the experiment once and say how it went."""
    return run_and_tell("sim1", options, folder, "overtaking_side.walker", "minimum_distance.walker")


if __name__ == "__main__":
    main()
