"""The paper's first experiment: three standing people, passed in slalom outside their personal space.

Run it with `python -m experiments.real1`; the results land in runs/real1/.
"""

from pathlib import Path

from experiments.telling import run_and_tell
from han_bullet.runner import RunOptions, RunResult


def main(options: RunOptions = RunOptions(), folder: Path = Path("runs/real1")) -> RunResult:  # noqa: B008 (frozen)
    """Run the experiment once and say how it went."""
    return run_and_tell(
        "real1",
        options,
        folder,
        "passing_side.first",
        "minimum_distance.first",
        "passing_side.second",
        "minimum_distance.second",
        "passing_side.third",
        "minimum_distance.third",
    )


if __name__ == "__main__":
    main()
