"""The paper's fourth experiment: the robot comes to a standing person from the front and stops for a hand-over.

Run it with `python -m experiments.real4`; the results land in runs/real4/.
"""

from pathlib import Path

from experiments.telling import run_and_tell
from han_bullet.runner import RunOptions, RunResult


def main(options: RunOptions = RunOptions(), folder: Path = Path("runs/real4")) -> RunResult:  # noqa: B008 (frozen)
    """Run the experiment once and say how it went."""
    return run_and_tell("real4", options, folder, "hand_over_distance", "hand_over_bearing", "hand_over_facing")


if __name__ == "__main__":
    main()
