"""Optimal A* on a costmap [Hart1968]."""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.costmap.grid import INSCRIBED, LETHAL, SOCIAL_MAX, Costmap, Costs
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array
from han_bullet.messages import Path

# What a metre through blocked cells costs a robot that starts in them: several times the dearest free metre at a
# weight of 20, so that it leaves by the shortest way and never through the person.
ESCAPE_COST = 100.0

Indices = NDArray[np.int32]


class AStar:
    """Find cheapest ways on a grid of 8 neighbours; the Euclidean distance is the heuristic.

    An edge costs length * (1 + weight * mean cost of its cells / 252). Cells from INSCRIBED on are blocked, and no
    diagonal passes the corner of a blocked cell. A robot whose own cell is blocked may leave: from a blocked cell a
    neighbouring blocked cell may be entered if people alone block it (or, when the building's INSCRIBED band holds the
    start, that band), at ESCAPE_COST per metre. Nothing leads from a free cell into a blocked one, nor ever into a
    wall or off the floor.
    """

    def __init__(self, *, weight: float = 10.0) -> None:
        """Take how much a full social cost lengthens a metre; >= 0, or the heuristic would overestimate."""
        if not 0.0 <= weight < math.inf:
            raise BadInputError(f"planner weight is {weight!r}; it must be a number >= 0")
        self.weight = float(weight)
        self._memory = _Memory.of_size(0)

    def search(self, costmap: Costmap, start_in_world: Array, goal_in_world: Array) -> Path | None:
        """Return the cheapest way between the cells of two points, (2,) [m]; None where there is none.

        A goal that is blocked or off the map, and a start in a wall or off the map, have no way.
        """
        ends = costmap.world_to_cell(np.stack([start_in_world, goal_in_world]))
        if not costmap.has_cell(ends).all():
            return None
        rows, columns = costmap.shape
        if self._memory.place.size != rows * columns:
            self._memory = _Memory.of_size(rows * columns)
        grid = _Grid(
            costmap.cost.ravel(), costmap.building.ravel(), rows, columns, float(costmap.resolution), self.weight
        )
        start, goal = (int(row) * columns + int(column) for row, column in ends)
        expanded = _search(grid, self._memory, start, goal)
        if expanded < 0:
            return None
        cells = np.array(_trace(self._memory.parent, goal))
        points = costmap.cell_to_world(np.stack(np.divmod(cells, columns), axis=-1))
        return Path(points, float(self._memory.reached[goal]), expanded)


def astar(costmap: Costmap, start_in_world: Array, goal_in_world: Array, *, weight: float = 10.0) -> Path | None:
    """Search once; see `AStar`, which keeps its working memory for the next time."""
    return AStar(weight=weight).search(costmap, start_in_world, goal_in_world)


class _Grid(NamedTuple):
    """What the search looks at: the map, row by row, and what passing it costs."""

    cost: Costs
    building: Costs
    rows: int
    columns: int
    resolution: float
    weight: float


class _Memory(NamedTuple):
    """Working memory of a search, kept between calls; per cell: cost so far, estimate, parent, heap, place in it."""

    reached: Array
    estimate: Array
    parent: Indices
    heap: Indices
    place: Indices

    @classmethod
    def of_size(cls, size: int) -> _Memory:
        reached, estimate = np.empty((2, size), np.float64)
        parent, heap, place = np.empty((3, size), np.int32)
        return cls(reached, estimate, parent, heap, place)


@numba.njit(cache=True)
def _search(grid: _Grid, memory: _Memory, start: int, goal: int) -> int:
    """Fill `reached` and `parent` up to the goal; return the number of cells expanded, or -1 without a way."""
    if grid.building[start] >= LETHAL or grid.cost[goal] >= INSCRIBED:
        return -1
    # What a robot that starts in blocked cells may pass: the building's INSCRIBED band only if it stands in it.
    limit = LETHAL if grid.building[start] >= INSCRIBED else INSCRIBED
    memory.reached[:] = np.inf
    memory.place[:] = -1
    memory.reached[start], memory.estimate[start], memory.parent[start] = 0.0, 0.0, -1
    memory.heap[0], memory.place[start] = start, 0
    count, expanded = 1, 0
    while count > 0:
        cell = memory.heap[0]
        count = _pop(memory, count)
        expanded += 1
        if cell == goal:
            return expanded
        count = _expand(grid, memory, cell, goal, limit, count)
    return -1


@numba.njit(cache=True)
def _expand(grid: _Grid, memory: _Memory, cell: int, goal: int, limit: int, count: int) -> int:
    """Offer a cell's neighbours the way through it; return the new length of the heap."""
    row, column = cell // grid.columns, cell % grid.columns
    for r in range(max(row - 1, 0), min(row + 2, grid.rows)):
        for c in range(max(column - 1, 0), min(column + 2, grid.columns)):
            near = r * grid.columns + c
            if near == cell or not _may_step(grid, cell, near, limit):
                continue
            length = grid.resolution * (math.sqrt(2.0) if r != row and c != column else 1.0)
            via = memory.reached[cell] + length * _price(grid.cost[cell], grid.cost[near], grid.weight)
            if via >= memory.reached[near]:
                continue
            beeline = grid.resolution * math.hypot(r - goal // grid.columns, c - goal % grid.columns)
            memory.reached[near], memory.estimate[near], memory.parent[near] = via, via + beeline, cell
            if memory.place[near] < 0:
                memory.heap[count], memory.place[near] = near, count
                count += 1
            _sift_up(memory, memory.place[near])
    return count


@numba.njit(cache=True)
def _may_step(grid: _Grid, cell: int, near: int, limit: int) -> bool:
    """Tell whether a step leads only into, and past the corners of, cells that may be entered from the first one."""
    if not _may_enter(grid, cell, near, limit):
        return False
    row, column = cell // grid.columns, cell % grid.columns
    near_row, near_column = near // grid.columns, near % grid.columns
    return _may_enter(grid, cell, row * grid.columns + near_column, limit) and _may_enter(
        grid, cell, near_row * grid.columns + column, limit
    )


@numba.njit(cache=True)
def _may_enter(grid: _Grid, cell: int, near: int, limit: int) -> bool:
    return near == cell or grid.cost[near] < INSCRIBED or (grid.cost[cell] >= INSCRIBED and grid.building[near] < limit)


@numba.njit(cache=True)
def _price(first: int, second: int, weight: float) -> float:
    """Return the cost of a metre between two cells."""
    if first >= INSCRIBED or second >= INSCRIBED:
        return ESCAPE_COST
    return 1.0 + weight * 0.5 * (float(first) + float(second)) / SOCIAL_MAX


@numba.njit(cache=True)
def _pop(memory: _Memory, count: int) -> int:
    """Take the first cell off the heap of `count` cells; return the new count."""
    heap, place = memory.heap, memory.place
    place[heap[0]] = -1
    count -= 1
    if count > 0:
        heap[0] = heap[count]
        place[heap[0]] = 0
        _sift_down(memory, count)
    return count


@numba.njit(cache=True)
def _sift_up(memory: _Memory, at: int) -> None:
    heap, place, estimate = memory.heap, memory.place, memory.estimate
    cell = heap[at]
    while at > 0:
        above = (at - 1) // 2
        if estimate[heap[above]] <= estimate[cell]:
            break
        heap[at] = heap[above]
        place[heap[at]] = at
        at = above
    heap[at], place[cell] = cell, at


@numba.njit(cache=True)
def _sift_down(memory: _Memory, count: int) -> None:
    heap, place, estimate = memory.heap, memory.place, memory.estimate
    cell, at = heap[0], 0
    while True:
        below = 2 * at + 1
        if below >= count:
            break
        if below + 1 < count and estimate[heap[below + 1]] < estimate[heap[below]]:
            below += 1
        if estimate[heap[below]] >= estimate[cell]:
            break
        heap[at] = heap[below]
        place[heap[at]] = at
        at = below
    heap[at], place[cell] = cell, at


def _trace(parent: Indices, goal: int) -> list[int]:
    """Return the cells from the start to the goal."""
    cells = [goal]
    while parent[cells[-1]] >= 0:
        cells.append(int(parent[cells[-1]]))
    return cells[::-1]
