"""The paper's second simulation: a hand-over across the room, round a couch once the television is on, past a walker.

Run it with `python -m experiments.sim2`; the results land in runs/sim2/.
"""

from pathlib import Path

from experiments.telling import run_and_tell
from han_bullet.runner import RunOptions, RunResult


def main(options: RunOptions = RunOptions(), folder: Path = Path("runs/sim2")) -> RunResult:  # noqa: B008 (frozen)
    """Run the experiment once and say how it went."""
    return run_and_tell(
        "sim2",
        options,
        folder,
        "transit_time_on.tv",
        "behind_seated.viewer",
        "overtaking_side.walker",
        "hand_over_distance",
        "hand_over_bearing",
    )


if __name__ == "__main__":
    main()
