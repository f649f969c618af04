"""How long the marginals of a cluster take by its size, and a whole scan of twenty people in 5 x 5 m.

Usage: python -m benchmarks.joint_events [--sizes 2 4 8 10 12 14 16 20] [--rounds 5] [--seconds 20] [--seeds 3]

In the clusters every track may have every measurement, which no camera has seen: the worst that a number of people can
be. One that needs more than MOST_SUMS partial sums loses its least likely pairs. The people in the room are those of
`benchmarks.tracker`, at ten scans a second; the first recording only warms up.
"""

import argparse
import math
import time
from collections.abc import Sequence
from unittest.mock import patch

import numpy as np

from benchmarks.crowd import record
from benchmarks.provenance import provenance
from benchmarks.tracker import CROWD, SMALL_ROOM, ours
from han_bullet.assembly import ASSOCIATIONS
from han_bullet.commands.parsing import positive
from han_bullet.markdown import markdown_table
from han_bullet.tracking import joint_events
from han_bullet.tracking.joint_events import MOST_SUMS, pair_probabilities, plan
from han_bullet.tracking.kalman import ConstantVelocity

SIZES = (2, 4, 8, 10, 12, 14, 16, 20)


def cluster_rows(sizes: Sequence[int], rounds: int) -> list[tuple[object, ...]]:
    """Return a line for each size of a cluster: events, partial sums, whether it is exact, and the median time."""
    lines: list[tuple[object, ...]] = []
    for size in sizes:
        log_ratios = np.random.default_rng(size).normal(0.0, 3.0, (size, size))
        pair_probabilities(log_ratios)  # compiles, at first
        taken = [seconds_of(log_ratios) for _ in range(rounds)]
        events = sum(math.comb(size, k) ** 2 * math.factorial(k) for k in range(size + 1))
        sums = plan(np.ones((size, size), bool)).sums
        exact = "yes" if sums <= MOST_SUMS else "thinned"
        lines.append((f"{size} x {size}", f"{events:.1e}", sums, exact, f"{1e3 * np.median(taken):.2f}"))
    return lines


def seconds_of(log_ratios: np.ndarray) -> float:
    """Return the time of one cluster [s]."""
    started = time.perf_counter()
    pair_probabilities(log_ratios)
    return time.perf_counter() - started


def room_rows(seconds: int, seeds: int, people: int = CROWD) -> list[tuple[object, ...]]:
    """Return a line for each association: scans, median and 95 % of their time, and the most partial sums at once."""
    recordings = [record(people, SMALL_ROOM, seconds, seed) for seed in (0, *range(seeds))]
    lines: list[tuple[object, ...]] = []
    for name in ASSOCIATIONS:
        taken, most = [], [0]

        def noted(possible: np.ndarray, most: list[int] = most) -> joint_events.Sweep:
            sweep = plan(possible)
            most.append(sweep.sums)
            return sweep

        with patch.object(joint_events, "plan", noted):
            for number, recording in enumerate(recordings):
                step = ours(name, ConstantVelocity())(recording)
                for scan in range(len(recording.measurements)):
                    started = time.perf_counter()
                    step(scan)
                    if number:
                        taken.append(time.perf_counter() - started)
        median, late = 1e3 * np.percentile(taken, (50, 95))
        lines.append((name, len(taken), f"{median:.2f}", f"{late:.2f}", max(most) or "-"))
    return lines


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--sizes", type=positive, nargs="+", default=SIZES, help="of the clusters")
    parser.add_argument("--rounds", type=positive, default=5, help="of each cluster")
    parser.add_argument("--seconds", type=positive, default=20, help="of each recording")
    parser.add_argument("--seeds", type=positive, default=3, help="recordings")
    options = parser.parse_args()
    print("### Joint events: large clusters, and twenty people in a small room\n")
    print(f"{provenance()}; median of {options.rounds}; exact up to {MOST_SUMS} partial sums\n")
    header = ("all may have all", "events", "partial sums", "exact", "median [ms]")
    print(markdown_table(header, cluster_rows(options.sizes, options.rounds)))
    print(
        f"\n{CROWD} people in {SMALL_ROOM:g} x {SMALL_ROOM:g} m, {options.seeds} recordings of {options.seconds} s:\n"
    )
    header = ("association", "scans", "median [ms per scan]", "95 % [ms per scan]", "most partial sums of a cluster")
    print(markdown_table(header, room_rows(options.seconds, options.seeds)))


if __name__ == "__main__":
    main()
