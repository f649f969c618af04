"""Run every benchmark and keep what they print in RESULTS.md; options of one: python -m benchmarks.NAME --help."""

import argparse
import ast
import subprocess
import sys
from datetime import date
from pathlib import Path

from benchmarks.results import write_measured

FOLDER = Path(__file__).parent
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
    ("ros_messages",),
    ("tracker",),
    ("joint_events",),
    ("ceiling_frames",),
    ("localization",),
    ("sweep_speed",),
    ("bags",),
)


def main() -> int:
    """Write benchmarks/RESULTS.md; return 1 if a benchmark failed, whose place there then says so."""
    summary = (__doc__ or "").strip()
    argparse.ArgumentParser(
        prog="python -m benchmarks",
        description=summary,
        epilog=listing(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    ).parse_args()
    parts = [f"# Results\n\nWritten by `make bench` on {date.today()}. Compare ratios within a run; machines differ."]
    failed = False
    for name, *arguments in BENCHMARKS:
        command = [sys.executable, "-m", f"benchmarks.{name}", *arguments]
        print(" ".join(command[1:]), flush=True)
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
        failed |= done.returncode != 0
        parts.append("\n".join(line for line in done.stdout.splitlines() if not line.startswith("<!--")))
        if done.returncode:  # the others have taken hours
            parts.append(f"`benchmarks.{name}` ended with exit code {done.returncode}.")
    # Only now: a changed file would mark the commit that the later ones print.
    write_measured("\n\n".join(parts))
    return int(failed)


def listing() -> str:
    """Return every benchmark with its first line: those that are run here, in order, and those that are not."""
    together = [" ".join(words) for words in BENCHMARKS]
    lines = [f"  {words:42} {_first_line(words.split()[0])}" for words in together]
    named = {words[0] for words in BENCHMARKS}
    alone = [path.stem for path in sorted(FOLDER.glob("*.py")) if _is_program(path) and path.stem not in named]
    others = [f"  {name:42} {_first_line(name)}" for name in alone]
    return "\n".join(["run, in this order:", *lines, "", "not run, only by their name:", *others])


def _is_program(path: Path) -> bool:
    return path != Path(__file__) and '__name__ == "__main__"' in path.read_text(encoding="utf-8")


def _first_line(name: str) -> str:
    """Return what a benchmark says of itself, without importing it."""
    return (ast.get_docstring(ast.parse((FOLDER / f"{name}.py").read_text(encoding="utf-8"))) or "").splitlines()[0]


if __name__ == "__main__":
    sys.exit(main())
