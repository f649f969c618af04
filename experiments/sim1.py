"""The paper's first simulation: the person ahead of the robot starts to walk slowly and is overtaken on the left.

Run it with `python experiments/sim1.py`; the results land in runs/sim1/.
"""

from pathlib import Path

from han_bullet.runner import RunOptions, RunResult, run_world


def main(seed: int = 0, folder: Path = Path("runs/sim1"), **options: object) -> RunResult:
    """Run the experiment once and say how it went."""
    result = run_world("sim1", RunOptions(seed=seed, **options), folder)  # type: ignore[arg-type]
    metrics = {metric.name: metric.value for metric in result.metrics}
    print(
        f"{metrics['outcome']} after {metrics['time_to_goal']:.1f} s; "
        f"overtook on the {metrics['overtaking_side.walker']} "
        f"at {metrics['distance_when_level.walker']:.2f} m between centres"
    )
    return result


if __name__ == "__main__":
    main()
