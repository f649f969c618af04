"""Optimal A* [Hart1968] on a costmap, with buckets for a queue [Dial1969] and the octile distance for a heuristic."""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.costmap.grid import INSCRIBED, LETHAL, SOCIAL_MAX, UNKNOWN, Costmap, Costs
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array
from han_bullet.messages import Path

# What a metre through blocked cells costs a robot that starts in them: several times the dearest free metre at a
# weight of 20, so that it leaves by the shortest way and never through the person.
ESCAPE_COST = 100.0
# The number of buckets grows with the dearest step: two megabytes of them at this weight.
LARGEST_WEIGHT = 10_000.0

# Kernels measure in cells: a straight step is 1 long, and a cost is its metres divided by the resolution.
DIAGONAL = math.sqrt(2.0)
# A bucket holds the cells whose estimates lie in this much of cost [cells]; within it the order is free, so a cell is
# expanded again where a cheaper way to it turns up late. Smaller buckets make that rare and are more often empty.
BUCKET = 1.0 / 16.0
# What is cheaper by less is not cheaper [cells]: it is the same steps, added in another order. A step costs 1 or more,
# so that the ways found are within this part of the optimum.
ROUNDING = 1e-10

# The eight steps to a neighbour: the straight ones first, each diagonal between its own two: 4 + k is k and k + 1.
ROW_STEPS = np.array([-1, 0, 1, 0, -1, 1, 1, -1])
COLUMN_STEPS = np.array([0, 1, 0, -1, 1, 1, -1, -1])
BEFORE, AFTER = 0, 1  # columns of the links

Indices = NDArray[np.int32]


class AStar:
    """Find cheapest ways on a grid of 8 neighbours.

    An edge costs length * (1 + weight * mean cost of its cells / 252). Cells from INSCRIBED on are blocked, and no
    diagonal passes the corner of a blocked cell. A robot whose own cell is blocked may leave: from a blocked cell a
    neighbouring blocked cell may be entered if people alone block it (or, when the building's INSCRIBED band holds the
    start, that band), at ESCAPE_COST per metre. Nothing leads from a free cell into a blocked one, nor ever into a
    wall or off the floor.

    The octile distance, the length of the shortest way of steps on an empty grid, never overestimates and is
    consistent: no metre costs less than 1. It is never less than the Euclidean distance.
    """

    def __init__(self, *, weight: float = 10.0) -> None:
        """Take how much a full social cost lengthens a metre: >= 0, or the heuristic would overestimate."""
        if not 0.0 <= weight <= LARGEST_WEIGHT:
            raise BadInputError(f"planner weight is {weight!r}; it must be a number from 0 to {LARGEST_WEIGHT:.0f}")
        self.weight = float(weight)
        self._memory = _Memory.of_shape(0, 0, self.weight)

    def search(self, costmap: Costmap, start_in_world: Array, goal_in_world: Array) -> Path | None:
        """Return the cheapest way between the cells of two points, (2,) [m]; None where there is none.

        A goal that is blocked or off the map, and a start in a wall or off the map, have no way.
        """
        ends = costmap.world_to_cell(np.array([start_in_world, goal_in_world]))
        start, goal = map(tuple, ends.tolist())
        rows, columns = costmap.shape
        if not all(0 <= row < rows and 0 <= column < columns for row, column in (start, goal)):
            return None
        if costmap.building[start] >= LETHAL or costmap.cost[goal] >= INSCRIBED:
            return None
        memory = self._memory
        if (memory.cost.size, memory.width) != ((rows + 2) * (columns + 2), columns + 2):
            memory = self._memory = _Memory.of_shape(rows, columns, self.weight)
        memory.cost.reshape(rows + 2, columns + 2)[1:-1, 1:-1] = _passable(costmap, start)
        cells, cost, expanded = _search(memory, *start, *goal)
        return Path(costmap.cell_to_world(cells), cost * costmap.resolution, expanded) if len(cells) else None


def astar(costmap: Costmap, start_in_world: Array, goal_in_world: Array, *, weight: float = 10.0) -> Path | None:
    """Search once; see `AStar`, which keeps its working memory for the next time."""
    return AStar(weight=weight).search(costmap, start_in_world, goal_in_world)


def _passable(costmap: Costmap, start: tuple[int, ...]) -> Costs:
    """Return the costs with INSCRIBED for what a robot that starts in blocked cells may leave through, and no other."""
    if costmap.cost[start] < INSCRIBED:
        return costmap.cost
    limit = LETHAL if costmap.building[start] >= INSCRIBED else INSCRIBED
    blocked = np.where(costmap.building < limit, np.uint8(INSCRIBED), np.uint8(LETHAL))
    return np.where(costmap.cost < INSCRIBED, costmap.cost, blocked)


class _Memory(NamedTuple):
    """Working memory of searches on maps of one shape; cells are numbered row by row, with a border of one cell.

    Attributes:
        width: Columns, with the border.
        cost: The map, its border UNKNOWN so that no step needs to look whether it leaves the map.
        half_price: By whether the cell that a step leaves is blocked and by the cost of a cell: the cell's part of the
            price of a straight step; inf where it may not be entered.
        reached: Cost of the cheapest way found to each cell, inf between searches.
        step: Which of the eight steps led to the cell.
        links: Cell or bucket before and after in a bucket's ring, -1 for a cell in none; the buckets' own follow the
            cells'.
        found: Cells that have been reached, to forget them afterwards without going through the whole map.
    """

    width: int
    cost: Costs
    half_price: Array
    reached: Array
    step: NDArray[np.uint8]
    links: Indices
    found: Indices

    @classmethod
    def of_shape(cls, rows: int, columns: int, weight: float) -> _Memory:
        cost = np.full((rows + 2) * (columns + 2), UNKNOWN, np.uint8)
        half_price = np.full((2, 256), np.inf)
        half_price[0, :INSCRIBED] = 0.5 * (1.0 + weight * np.arange(INSCRIBED) / SOCIAL_MAX)
        half_price[1, :LETHAL] = 0.5 * ESCAPE_COST
        # No step raises an estimate by more than its cost and its length: two estimates in the queue at once that share
        # a bucket share its range, too.
        dearest = DIAGONAL * (max(1.0 + weight, ESCAPE_COST) + 1.0)
        buckets = 2 ** math.ceil(math.log2(dearest / BUCKET + 2.0))
        links = np.full((cost.size + buckets, 2), -1, np.int32)
        links[cost.size :] = np.arange(cost.size, len(links))[:, None]  # empty
        reached, step, found = np.full(cost.size, np.inf), np.empty(cost.size, np.uint8), np.empty(cost.size, np.int32)
        return cls(columns + 2, cost, half_price, reached, step, links, found)


@numba.njit(cache=True)
def _search(
    memory: _Memory, start_row: int, start_column: int, goal_row: int, goal_column: int
) -> tuple[NDArray[np.int64], float, int]:
    """Return the way's cells (row, column), none without a way; its cost [cells]; how many cells were taken out.

    All in one function: one that expands a cell, called for each, takes about twice as long, for numba counts the
    references to the memory's arrays each time.
    """
    width, cost, half_price, reached, step, links, found = memory
    first_bucket = cost.size
    last_bucket = len(links) - first_bucket - 1  # a power of two less one: a mask
    start, goal = (start_row + 1) * width + start_column + 1, (goal_row + 1) * width + goal_column + 1
    least = _octile(start_row - goal_row, start_column - goal_column)
    reached[start], found[0], count = 0.0, start, 1
    _link(links, start, first_bucket)
    level = highest = expanded = 0
    while level <= highest:
        cell = links[first_bucket + (level & last_bucket), AFTER]
        if cell >= first_bucket:  # the bucket itself: it is empty
            level += 1
            continue
        _unlink(links, cell)
        expanded += 1
        row, column = cell // width - 1 - goal_row, cell % width - 1 - goal_column  # seen from the goal
        if reached[cell] + _octile(row, column) >= reached[goal] - ROUNDING:
            continue
        here, way_here, blocked = cost[cell], reached[cell], int(cost[cell] >= INSCRIBED)
        sides = 0  # a bit for each straight step that may be taken; the first one's again as the fifth
        for k in range(8):
            near = cell + ROW_STEPS[k] * width + COLUMN_STEPS[k]
            price = half_price[blocked, here] + half_price[blocked, cost[near]]
            if k < 4:
                if price == np.inf:
                    continue
                sides |= 0b10001 if k == 0 else 1 << k
            else:
                if (sides >> (k - 4)) & 0b11 != 0b11:
                    continue
                price *= DIAGONAL
            way = way_here + price
            if way >= reached[near] - ROUNDING:
                continue
            estimate = way + _octile(row + ROW_STEPS[k], column + COLUMN_STEPS[k])
            if estimate >= reached[goal] - ROUNDING:
                continue
            if reached[near] == np.inf:
                found[count] = near
                count += 1
            elif links[near, AFTER] >= 0:
                _unlink(links, near)
            reached[near], step[near] = way, k
            # Rounding may let an estimate fall below that of the cell it comes from; never into a bucket that is done.
            near_level = max(int((estimate - least) / BUCKET), level)
            if near == goal:
                highest = near_level  # what lies above is no longer of interest
            else:
                highest = max(highest, near_level)
                _link(links, near, first_bucket + (near_level & last_bucket))
    way_cost = reached[goal]
    cells = _trace(step, width, start, goal) if way_cost < np.inf else np.empty((0, 2), np.int64)
    for cell in found[:count]:
        reached[cell] = np.inf
        if links[cell, AFTER] >= 0:
            _unlink(links, cell)
    return cells, way_cost, expanded


@numba.njit(cache=True)
def _octile(rows: int, columns: int) -> float:
    """Return the length of the shortest way of steps over so many rows and columns [cells]."""
    rows, columns = abs(rows), abs(columns)
    return max(rows, columns) + (DIAGONAL - 1.0) * min(rows, columns)


@numba.njit(cache=True)
def _link(links: Indices, cell: int, bucket: int) -> None:
    """Put a cell first into a bucket: last in, first out follows one of many equal ways to its end."""
    first = links[bucket, AFTER]
    links[cell, BEFORE], links[cell, AFTER] = bucket, first
    links[first, BEFORE] = links[bucket, AFTER] = cell


@numba.njit(cache=True)
def _unlink(links: Indices, cell: int) -> None:
    """Take a cell out of its bucket."""
    before, after = links[cell]
    links[before, AFTER], links[after, BEFORE] = after, before
    links[cell, AFTER] = -1


@numba.njit(cache=True)
def _trace(step: NDArray[np.uint8], width: int, start: int, goal: int) -> NDArray[np.int64]:
    """Return the cells (row, column) of the map without its border, from the start to the goal."""
    cell, count = goal, 1
    while cell != start:
        cell -= ROW_STEPS[step[cell]] * width + COLUMN_STEPS[step[cell]]
        count += 1
    cells = np.empty((count, 2), np.int64)
    cell = goal
    for i in range(count - 1, 0, -1):
        cells[i] = cell // width - 1, cell % width - 1
        cell -= ROW_STEPS[step[cell]] * width + COLUMN_STEPS[step[cell]]
    cells[0] = start // width - 1, start % width - 1
    return cells
