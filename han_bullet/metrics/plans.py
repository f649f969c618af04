"""How often the robot planned, and how much its plans changed."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from han_bullet.episode import Tick
from han_bullet.geometry import Array, arc_lengths, feet_on, points_at
from han_bullet.metrics.perceived import distances_between
from han_bullet.metrics.tally import Definition, Definitions, Tally, Value

SWITCH = 0.5  # [m]: a person's width; the ways to the left and to the right of somebody are 1.1 m apart
SPACING = 0.1  # [m] of the points that stand for a way

_CHANGE = (
    "Hausdorff distance of the ways of two searches in a row: the largest distance of a point of the one from the "
    f"other, points every {SPACING:g} m; over the extent that both have, from the robot on: the older begins where it "
    "is nearest to the robot, and of the longer one what is longer is not asked"
)


class PlanTally(Tally):
    """How often the robot planned, and how much its plans changed."""

    group = "motion"
    definitions: ClassVar[Definitions] = {
        "replans": Definition(
            "1",
            "number of ticks whose way comes of a new search, the first included, whether it took the new way or not",
        ),
        "path_change_mean": Definition("m", f"mean {_CHANGE}; none with fewer than two searches", "lower"),
        "path_switches": Definition(
            "1", f"number of searches after which that is more than {SWITCH:g} m: {_CHANGE}", "lower"
        ),
    }

    def __init__(self) -> None:
        self._replans = 0
        self._previous: Array | None = None
        self._changes: list[float] = []  # [m]

    def record(self, tick: Tick) -> None:
        """Take note of one tick; those without a search say nothing new."""
        path = tick.decision.path
        if path is None or path.expanded == 0:
            return
        self._replans += 1
        if self._previous is not None:
            self._changes.append(path_change(self._previous, path.points_in_world))
        self._previous = path.points_in_world

    def values(self) -> dict[str, Value]:
        """Return counts and the mean change."""
        return {
            "replans": self._replans,
            "path_change_mean": float(np.mean(self._changes)) if self._changes else None,
            "path_switches": sum(change > SWITCH for change in self._changes),
        }


def path_change(previous: Array, now: Array) -> float:
    """Return how far two ways, (n, 2) and (m, 2) [m], are apart [m]; see the definitions."""
    first, second = _resampled(_ahead(previous, now[0])), _resampled(now)
    shared = min(len(first), len(second))
    distances = distances_between(first, second)
    return float(max(distances[:shared].min(axis=1).max(), distances[:, :shared].min(axis=0).max()))


def _ahead(way: Array, robot: Array) -> Array:
    """Return a way, (n, 2) [m], from its point nearest to the robot on, so that equal ways get equal points."""
    if len(way) < 2:
        return way
    _, feet = feet_on(way, robot)
    nearest = int(np.hypot(*(feet - robot).T).argmin())
    return np.vstack([feet[nearest], way[nearest + 1 :]])


def _resampled(way: Array) -> Array:
    """Return points of a way, (n, 2) [m], every SPACING from its beginning on; what is left at the end is dropped."""
    arcs = arc_lengths(way)
    return points_at(SPACING * np.arange(math.floor(arcs[-1] / SPACING + 1e-9) + 1), way, arcs)
