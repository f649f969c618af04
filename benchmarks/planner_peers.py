"""Planners to compare with ours: the same question, the way as cells (row, column)."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from han_bullet.costmap.grid import INSCRIBED, SOCIAL_MAX, Costmap
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array
from han_bullet.planning.astar import AStar

Cells = NDArray[np.int64]


class Peer(ABC):
    """A planner that has a map before the clock runs.

    Attributes:
        name: In the table.
        expanded: Cells taken from the queue in the last search, where the planner tells.
    """

    name: ClassVar[str]
    expanded: int | None = None

    @abstractmethod
    def search(self, start_in_world: Array, goal_in_world: Array) -> Callable[[], Any]:
        """Return what is timed; its result is for `cells`."""

    @abstractmethod
    def cells(self, found: Any) -> Cells:
        """Return the way, (n, 2)."""


class Ours(Peer):
    """`AStar.search`, from two points in the world to a Path."""

    name = "ours"

    def __init__(self, costmap: Costmap, weight: float) -> None:
        self.costmap = costmap
        self.astar = AStar(weight=weight)

    def search(self, start_in_world: Array, goal_in_world: Array) -> Callable[[], Any]:
        """Take the map into the working memory, search, make the Path."""
        return lambda: self.astar.search(self.costmap, start_in_world, goal_in_world)

    def cells(self, found: Any) -> Cells:
        """Return the cells of the path's points."""
        assert found is not None
        self.expanded = found.expanded
        return self.costmap.world_to_cell(found.points_in_world)


class Pyastar(Peer):
    """pyastar2d: A* in C++. A step costs its second cell's price, a diagonal no more than a straight one."""

    name = "pyastar2d"

    def __init__(self, costmap: Costmap, weight: float) -> None:
        import pyastar2d

        self.costmap = costmap
        self.find = pyastar2d.astar_path
        self.prices = prices(costmap, weight, blocked=np.inf).astype(np.float32)

    def search(self, start_in_world: Array, goal_in_world: Array) -> Callable[[], Any]:
        """Search; the price of each cell is at hand."""
        start, goal = map(tuple, self.costmap.world_to_cell(np.array([start_in_world, goal_in_world])).tolist())
        return lambda: self.find(self.prices, start, goal, allow_diagonal=True)

    def cells(self, found: Any) -> Cells:
        """Return them as they come."""
        return np.asarray(found, np.int64)


class Geometric(Peer):
    """scikit-image's MCP_Geometric: Dijkstra in Cython with our price of a step, stopped at the goal."""

    name = "MCP_Geometric"

    def __init__(self, costmap: Costmap, weight: float) -> None:
        from skimage.graph import MCP_Geometric

        self.costmap = costmap
        self.mcp = MCP_Geometric(prices(costmap, weight, blocked=-1.0), fully_connected=True)

    def search(self, start_in_world: Array, goal_in_world: Array) -> Callable[[], Any]:
        """Search and trace back; the object with the price of each cell is at hand."""
        start, goal = self.costmap.world_to_cell(np.array([start_in_world, goal_in_world])).tolist()

        def find() -> Any:
            self.mcp.find_costs([start], [goal])
            return self.mcp.traceback(goal)

        return find

    def cells(self, found: Any) -> Cells:
        """Return the list of pairs as an array."""
        return np.array(found, np.int64)


def prices(costmap: Costmap, weight: float, *, blocked: float) -> Array:
    """Return what a step in each cell costs, (rows, columns), with a value of one's own for blocked cells."""
    return np.where(costmap.cost < INSCRIBED, 1.0 + weight * costmap.cost.astype(float) / SOCIAL_MAX, blocked)


def all_peers(costmap: Costmap, weight: float) -> list[Peer]:
    """Return the planners in the order of their turns.

    Raises:
        BadInputError: One of them is not installed.
    """
    try:
        return [kind(costmap, weight) for kind in (Ours, Pyastar, Geometric)]
    except ImportError as error:
        raise BadInputError(f"{error.name} is not installed; pip install --editable '.[bench]' brings it") from error
