"""What the two overtaking experiments, real2 and sim1, have in common: run one and say how it went."""

from pathlib import Path

from han_bullet.runner import RunOptions, RunResult, run_world


def overtake(world: str, options: RunOptions, folder: Path) -> RunResult:
    """Run a world with a person called walker and print a line on the overtaking."""
    result = run_world(world, options, folder)
    values = {metric.name: metric.value for metric in result.metrics}
    print(
        f"{world}, seed {options.seed}: {values['outcome']} after {values['time_to_goal']} s; "
        f"overtook on the {values['overtaking_side.walker']}, "
        f"{values['minimum_distance.walker']} m between centres at the closest"
    )
    return result
