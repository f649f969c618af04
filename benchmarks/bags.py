"""How large an exported run is, and how long that takes: as a bag with LZ4 or uncompressed, and as MCAP with zstd.

Without compression the bag is the same but for its chunks, which are left as they are. Time is that of the processor:
replaying the run, making its messages, writing them; with images also driving the simulator again and drawing.

Usage: python -m benchmarks.bags [--run runs/real2] [--rounds 3]
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest.mock import patch

from benchmarks.provenance import provenance
from han_bullet.explain.recorded_run import RecordedRun, read_run
from han_bullet.markdown import markdown_table
from han_bullet.ros.export import Exported, export
from han_bullet.runner import RunOptions, run_world

HEADER = ("file", "images", "messages", "size [MB]", "size / none", "export, least [s]", "run [s]")


def as_it_is(run: RecordedRun, path: Path, *, images: bool) -> Exported:
    """Export a bag without compression; only its size and time are of use."""
    with patch("han_bullet.ros.bag._compressed", lambda chunk: chunk):
        return export(run, path, images=images)


WAYS: dict[str, Callable[..., Exported]] = {
    "bag, none": as_it_is,
    "bag, LZ4": export,
    "MCAP, zstd": lambda run, path, images: export(run, path, mcap=True, images=images),
}


def measured(run: RecordedRun, folder: Path, *, images: bool, rounds: int) -> list[list[str]]:
    """Return a row per way of writing, each taken in turn."""
    taken: dict[str, list[float]] = {name: [] for name in WAYS}
    exported: dict[str, Exported] = {}
    for _ in range(rounds):
        for name, way in WAYS.items():
            began = time.process_time()
            exported[name] = way(run, folder / "run", images=images)
            taken[name].append(time.process_time() - began)
    plain = exported["bag, none"].size
    return [
        [
            name,
            "with" if images else "without",
            str(sum(one.counts.values())),
            f"{one.size / 1e6:.1f}",
            f"{one.size / plain:.2f}",
            f"{min(taken[name]):.2f}",
            f"{one.duration:.1f}",
        ]
        for name, one in exported.items()
    ]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", type=Path, help="folder of a run with cameras (default: real2, run first)")
    parser.add_argument("--rounds", type=int, default=3, help="exports of each kind without images (default 3)")
    options = parser.parse_args()
    with TemporaryDirectory() as temporary:
        folder = options.run or Path(temporary) / "real2"
        if options.run is None:
            run_world("real2", RunOptions(video=False), folder)
        run = read_run(folder)
        export(run, Path(temporary) / "run")  # compiles what is not compiled yet
        rows = measured(run, Path(temporary), images=False, rounds=options.rounds)
        rows += measured(run, Path(temporary), images=True, rounds=1)
    print(f"### {run.world.name} exported\n\n{provenance()}\n")
    print(markdown_table(HEADER, rows))


if __name__ == "__main__":
    main()
