"""Run every benchmark and keep what they print in RESULTS.md."""

import subprocess
import sys
from datetime import date

from benchmarks.results import write_measured

BENCHMARKS = (
    ("detector",),
    ("network_forward",),
    ("stage_timing",),
    ("footprint",),
    ("exhaustive_cnn",),
    ("rendered_people",),
    ("foot_points",),
    ("legs",),
    ("planner",),
    ("costmap",),
    ("path_follows_cost",),
    ("tracker",),
    ("joint_events",),
    ("ceiling_frames",),
    ("sweep_speed",),
    ("scenarios", "--seeds", "10"),
    ("scenarios", "--seeds", "10", "--perception", "truth"),
)


def main() -> None:
    """Write benchmarks/RESULTS.md."""
    parts = [f"# Results\n\nWritten by `make bench` on {date.today()}. Compare ratios within a run; machines differ."]
    for name, *arguments in BENCHMARKS:
        command = [sys.executable, "-m", f"benchmarks.{name}", *arguments]
        print(" ".join(command[1:]), flush=True)
        printed = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
        parts.append("\n".join(line for line in printed.splitlines() if not line.startswith("<!--")))
    # Only now: a changed file would mark the commit that the later ones print.
    write_measured("\n\n".join(parts))


if __name__ == "__main__":
    main()
