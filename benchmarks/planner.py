"""Our A* beside others on large costmaps, and how long it takes while a person crosses the robot's way.

Usage: python -m benchmarks.planner [--sizes 200 400 1000] [--rounds 15] [--pairs 3] [--weight 10] [--worlds real2 sim1]

Maps have square cells of 5 cm, walls, pillars and people, inflated and made dear by the project's own layers. Ways lead
from corner to corner, and between places drawn at random; the planners take turns. All ways are scored with our price
of a step, length * (1 + weight * mean cost / 252), and compared with the cheapest way on an explicit graph, by SciPy's
Dijkstra. If one of ours is not optimal to a millionth, this ends with exit code 1.

What the others do not honour, and what they are spared:

- pyastar2d: a diagonal step costs it no more than a straight one, and only the second cell of a step counts, in single
  precision; it cuts the corners of blocked cells. Its prices are made before the clock runs.
- MCP_Geometric: has our price of a step and no heuristic; it cuts the corners of blocked cells. Its prices and its copy
  of them are made before the clock runs.
- Ours takes the costs anew for each search, as they are on the costmap, and makes the points in the world; both count.

A way that cuts corners is marked: it may be cheaper than the cheapest one that does not, and no robot can drive it.
"""

import argparse
import math
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from benchmarks.planner_maps import SHARE_OF_WALLS, Problem, problem
from benchmarks.planner_optimum import explicit_graph, optimum, score
from benchmarks.planner_peers import Peer, all_peers
from benchmarks.provenance import provenance
from benchmarks.replanning import replanning_row
from han_bullet.commands.parsing import positive
from han_bullet.errors import BadInputError, HanError
from han_bullet.geometry import Array
from han_bullet.markdown import markdown_table

COLUMNS = (
    "grid",
    "clutter",
    "ways",
    "planner",
    "median [ms]",
    "minimum [ms]",
    "cost / optimum",
    "cells expanded",
    "time / ours, median",
    "of minima",
)
REPLANNING_COLUMNS = (
    "world",
    "cycles",
    "costmap, median [ms]",
    "costmap, 95 % [ms]",
    "planning, median [ms]",
    "planning, 95 % [ms]",
    "cells expanded, median",
    "cells expanded, 95 %",
)


class NotOptimal(HanError):
    """A way of ours costs more or less than the cheapest one."""


@dataclass
class Outcome:
    """What a planner came to on some ways of one map.

    Attributes:
        times: Mean time per way in each round [s].
        costs: Of each way, by our price of a step [m].
        cuts_corners: Whether a way passes the corner of a blocked cell diagonally.
        expanded: Mean number of cells per way, where the planner tells.
    """

    times: list[float] = field(default_factory=list)
    costs: list[float] = field(default_factory=list)
    cuts_corners: bool = False
    expanded: list[int] = field(default_factory=list)


def compare(task: Problem, peers: Sequence[Peer], ends: Array, rounds: int, weight: float) -> list[Outcome]:
    """Let the planners take turns on ways between ends, (n, 2, 2) [m]; a round before is scored and not timed."""
    outcomes = [Outcome() for _ in peers]
    searches = [[peer.search(start, goal) for start, goal in ends] for peer in peers]
    for peer, searched, outcome in zip(peers, searches, outcomes, strict=True):
        for search in searched:
            cost, cuts = score(task.costmap, peer.cells(search()), weight)
            outcome.costs.append(cost)
            outcome.cuts_corners |= cuts
            outcome.expanded += [] if peer.expanded is None else [peer.expanded]
    for _ in range(rounds):
        for searched, outcome in zip(searches, outcomes, strict=True):
            started = time.perf_counter()
            for search in searched:
                search()
            outcome.times.append((time.perf_counter() - started) / len(ends))
    return outcomes


def check_optimal(task: Problem, ours: Outcome, best: Sequence[float]) -> None:
    """Raise NotOptimal for the first way of ours that is not the cheapest to a millionth."""
    for number, (cost, least) in enumerate(zip(ours.costs, best, strict=True)):
        assert math.isfinite(least)
        if ours.cuts_corners or not math.isclose(cost, least, rel_tol=1e-6):
            raise NotOptimal(
                f"grid {task.size}, {task.clutter} clutter, way {number}: ours costs {cost!r} m, the optimum {least!r}"
            )


def rows(task: Problem, rounds: int, weight: float) -> list[tuple[object, ...]]:
    """Return the lines of a map: from corner to corner, then the mean of the ways drawn at random."""
    peers, graph = all_peers(task.costmap, weight), explicit_graph(task.costmap, weight)
    lines: list[tuple[object, ...]] = []
    for name, ends in (("corner to corner", task.ends[:1]), (f"{len(task.ends) - 1} at random", task.ends[1:])):
        if not len(ends):
            continue
        best = [optimum(graph, task.costmap, start, goal) for start, goal in ends]
        outcomes = compare(task, peers, ends, rounds, weight)
        check_optimal(task, outcomes[0], best)
        for peer, outcome in zip(peers, outcomes, strict=True):
            ratio = f"{sum(outcome.costs) / sum(best):.4f}" + (" (cuts corners)" if outcome.cuts_corners else "")
            times, slower = 1e3 * np.array(outcome.times), np.array(outcome.times) / outcomes[0].times
            expanded = round(float(np.mean(outcome.expanded))) if outcome.expanded else "-"
            of_minima = min(outcome.times) / min(outcomes[0].times)
            compared = (f"{np.median(slower):.2f}", f"{of_minima:.2f}")
            figures = (float(np.median(times)), float(times.min()), ratio, expanded, *compared)
            lines.append((f"{task.size} x {task.size}", task.clutter, name, peer.name, *figures))
    return lines


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(
        description=(__doc__ or "").splitlines()[0], formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    parser.add_argument("--sizes", nargs="+", type=positive, default=[200, 400, 1000], help="cells along a side")
    parser.add_argument("--rounds", type=positive, default=15)
    parser.add_argument("--pairs", type=positive, default=3, help="ways drawn at random per map")
    parser.add_argument("--weight", type=float, default=10.0)
    parser.add_argument("--worlds", nargs="*", default=["real2", "sim1"], help="of the second table")
    options = parser.parse_args()
    try:
        lines = [
            line
            for size in options.sizes
            for clutter in SHARE_OF_WALLS
            for line in rows(problem(size, clutter, options.pairs), options.rounds, options.weight)
        ]
        cycles = [replanning_row(world) for world in options.worlds]
    except NotOptimal as error:
        sys.exit(f"not optimal: {error}")
    except BadInputError as error:
        print(f"benchmarks.planner: {error}", file=sys.stderr)
        sys.exit(2)
    print(f"### A* on large costmaps, weight {options.weight:g}\n\n{provenance()}; {options.rounds} rounds\n")
    print(f"{(__doc__ or '').split('exit code 1.', 1)[1].strip()}\n")
    print(markdown_table(COLUMNS, lines))
    if cycles:
        print("\n### Replanning while a person crosses the robot's way; true people\n")
        print("Cycles: searches that found a way, each the median of three equal runs. Costmap: all layers. Planning:")
        print("the search, and the choice between the old way and the new one.\n")
        print(markdown_table(REPLANNING_COLUMNS, cycles))


if __name__ == "__main__":
    main()
