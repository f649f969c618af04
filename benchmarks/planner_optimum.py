"""What the cheapest way costs, by SciPy's Dijkstra on an explicit graph, and what any way costs by our rules."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from benchmarks.planner_peers import Cells, prices
from han_bullet.costmap.grid import Costmap
from han_bullet.geometry import Array

STEPS = ((0, 1), (1, 0), (1, 1), (1, -1))  # rows and columns of a step; the graph has their reverses, too


def explicit_graph(costmap: Costmap, weight: float) -> csr_array:
    """Return the costs of all steps between free cells [m]; no diagonal passes the corner of a blocked cell."""
    price = np.pad(prices(costmap, weight, blocked=np.inf), 1, constant_values=np.inf)
    number = np.arange(price.size).reshape(price.shape)
    tails, heads, lengths = [], [], []
    here = (slice(1, -1), slice(1, -1))
    for rows, columns in STEPS:
        there, across, along = (_shifted(*step) for step in ((rows, columns), (rows, 0), (0, columns)))
        free = np.isfinite(price[here] + price[there] + price[across] + price[along])
        tails.append(number[here][free])
        heads.append(number[there][free])
        mean = 0.5 * (price[here][free] + price[there][free])
        lengths.append(costmap.resolution * np.hypot(rows, columns) * mean)
    ends, other_ends, length = np.concatenate(tails), np.concatenate(heads), np.concatenate(lengths)
    both = (np.concatenate([length, length]), (np.concatenate([ends, other_ends]), np.concatenate([other_ends, ends])))
    return csr_array(both, shape=(price.size, price.size))


def _shifted(rows: int, columns: int) -> tuple[slice, slice]:
    """Return where the cells of a padded map are whose neighbours they are by a step."""
    return slice(1 + rows, -1 + rows or None), slice(1 + columns, -1 + columns or None)


def optimum(graph: csr_array, costmap: Costmap, start_in_world: Array, goal_in_world: Array) -> float:
    """Return the cost of the cheapest way [m], inf where there is none."""
    rows, columns = (costmap.world_to_cell(np.array([start_in_world, goal_in_world])) + 1).T
    start, goal = rows * (costmap.shape[1] + 2) + columns
    return float(dijkstra(graph, indices=start)[goal])


def score(costmap: Costmap, cells: Cells, weight: float) -> tuple[float, bool]:
    """Return what a way of neighbouring cells costs [m], and whether it cuts the corner of a blocked one."""
    price = prices(costmap, weight, blocked=np.inf)
    (rows, columns), (next_rows, next_columns) = cells[:-1].T, cells[1:].T
    length = costmap.resolution * np.hypot(next_rows - rows, next_columns - columns)
    mean = 0.5 * (price[rows, columns] + price[next_rows, next_columns])
    passed: NDArray[np.float64] = np.maximum(price[rows, next_columns], price[next_rows, columns])
    return float(length @ mean), bool(np.isinf(passed).any())
