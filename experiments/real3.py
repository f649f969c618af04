"""The paper's third experiment: past a person on a couch, before it while the television is off, behind it while on.

Run it with `python -m experiments.real3`; the results land in runs/real3/ and runs/real3_off/.
"""

from pathlib import Path

from experiments.telling import run_and_tell
from han_bullet.runner import RunOptions, RunResult

FIGURES = ("transit_time_on.tv", "transit_time_off.tv", "replan_delay.tv", "behind_seated.viewer")


def main(options: RunOptions = RunOptions(), folder: Path = Path("runs/real3")) -> RunResult:  # noqa: B008 (frozen)
    """Run the experiment once with a television that goes on, and say how it went."""
    return run_and_tell("real3", options, folder, *FIGURES)


def with_television_off(
    options: RunOptions = RunOptions(),  # noqa: B008 (frozen)
    folder: Path = Path("runs/real3_off"),
) -> RunResult:
    """Run it once with a television that stays off, and say how it went."""
    return run_and_tell("real3_off", options, folder, *FIGURES)


if __name__ == "__main__":
    with_television_off()
    main()
