"""The paper's first simulation: the person ahead of the robot starts to walk slowly and is overtaken on the left.

Run it with `python -m experiments.sim1`; the results land in runs/sim1/.
"""

from pathlib import Path

from experiments.overtaking import overtake
from han_bullet.runner import RunOptions, RunResult


def main(options: RunOptions = RunOptions(), folder: Path = Path("runs/sim1")) -> RunResult:  # noqa: B008 (frozen)
    """Run the experiment once and say how it went."""
    return overtake("sim1", options, folder)


if __name__ == "__main__":
    main()
