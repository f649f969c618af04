"""What all experiments have in common: run a world and say how it went."""

from pathlib import Path

from han_bullet.runner import RunOptions, RunResult, run_world


def run_and_tell(world: str, options: RunOptions, folder: Path, *names: str) -> RunResult:
    """Run a world; print outcome, some metrics by name, and which expectations were not met."""
    result = run_world(world, options, folder)
    metrics = {metric.name: metric for metric in result.metrics}
    print(f"{world}, seed {options.seed}, {options.perception}: {metrics['outcome'].value}")
    for name in ("time_to_goal", *names):
        metric = metrics[name]
        print(f"  {name}: {metric.value} {metric.unit if metric.unit != '1' else ''}".rstrip())
    for check in result.checks:
        if not check.passed:
            print(f"  not met: {check.metric} is {check.value}, expected {check.expected}")
    return result
