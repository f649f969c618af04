"""When to plan, and when to keep the way that one is on."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numba
import numpy as np

from han_bullet.costmap.grid import INSCRIBED, SOCIAL_MAX, Costmap, Costs
from han_bullet.errors import BadInputError, check_positive
from han_bullet.geometry import Array
from han_bullet.messages import Path, Posture, TrackedPerson
from han_bullet.planning.astar import ESCAPE_COST, AStar

JOIN = 0.5  # a kept way is given up when the robot or the goal is farther from it [m]: it was made for another place
FOLLOW_GAP = 0.6  # between the robot's centre and the blocked cells around people that it follows [m]
# The largest g at which the robot comes to a stop for its task: 1.0 m from somebody who stands. To stop nearer it needs
# a hand-over's opening, where g is 0; passing by is short, and may be nearer.
ADMITTED = 0.2


class Planner:
    """Plan periodically and on demand; keep the old way while it is free and hardly dearer than the best one.

    Without that commitment the noise of the tracks flips the side of passing a person two or three times a run.
    """

    def __init__(
        self, *, weight: float = 10.0, replan_period: float = 0.25, switch_gain: float = 0.10, largest_body: float = 0.8
    ) -> None:
        """Configure the planner.

        Args:
            weight: How much a full social cost lengthens a metre.
            replan_period: [s], at most 0.5.
            switch_gain: A new way is taken when the old one is dearer than it by more than this part.
            largest_body: No person's disc on the costmap has a larger radius [m].
        """
        if not 0.0 < replan_period <= 0.5:
            raise BadInputError(f"planner replan_period is {replan_period!r} s; it must lie in (0, 0.5]")
        if not 0.0 <= switch_gain < math.inf:
            raise BadInputError(f"planner switch_gain is {switch_gain!r}; it must be a number >= 0")
        check_positive("planner", largest_body=largest_body)
        self.replan_period = replan_period
        self.switch_gain = switch_gain
        self.largest_body = largest_body
        self._astar = AStar(weight=weight)
        self._way: Array | None = None
        self._behind: Array | None = None
        self._planned_at = -math.inf

    def update(
        self,
        costmap: Costmap,
        start_in_world: Array,
        goal_in_world: Array,
        time: float,
        urgent: bool,
        people: Sequence[TrackedPerson] = (),
    ) -> Path | None:
        """Return the way from the robot to the goal, or None where there is no free one.

        Where only walking people block the way, the result leads up to FOLLOW_GAP behind them: they are followed.
        Where people make the goal dearer than ADMITTED, it leads up to the edge of what is dearer.

        Args:
            costmap: Of this moment.
            start_in_world: The robot, shape (2,) [m].
            goal_in_world: Shape (2,) [m].
            time: [s].
            urgent: Search now: something that matters has changed.
            people: Who may be followed, or waited for beside the goal.

        Returns:
            The way; its first point is the robot, the others are cell centres up to the goal's cell or to where it
            stops short of it.
        """
        opened = _with_goal_opened(costmap, goal_in_world, people, self.largest_body)
        kept = self._kept(opened, start_in_world, goal_in_world)
        due = time - self._planned_at >= self.replan_period - 1e-9
        if due or urgent or (self._way is not None and kept is None):
            self._planned_at = time
            kept = self._choose(opened, start_in_world, goal_in_world, kept)
            self._behind = None if kept else self._behind_people(costmap, opened, start_in_world, goal_in_world, people)
        self._way = None if kept is None else kept.points_in_world[1:]
        if kept is not None:
            return self._up_to_edge(costmap, kept)
        return None if self._behind is None else self._scored(costmap, start_in_world, self._behind)

    def forget(self) -> None:
        """Forget the way that it is on: the next update searches one."""
        self._way = self._behind = None
        self._planned_at = -math.inf

    def search(self, costmap: Costmap, start_in_world: Array, goal_in_world: Array) -> Path | None:
        """Return the cheapest way between two points, (2,) [m], or None, and keep to the way that it is on."""
        return self._astar.search(costmap, start_in_world, goal_in_world)

    def _choose(self, costmap: Costmap, start_in_world: Array, goal_in_world: Array, kept: Path | None) -> Path | None:
        """Search, and choose between the result and the kept way."""
        best = self._astar.search(costmap, start_in_world, goal_in_world)
        if best is None:
            return None
        best = self._scored(costmap, start_in_world, best.points_in_world, best.expanded)
        if kept is not None and kept.cost <= (1.0 + self.switch_gain) * best.cost:
            return Path(kept.points_in_world, kept.cost, best.expanded)
        return best

    def _scored(self, costmap: Costmap, start_in_world: Array, way: Array, expanded: int = 0) -> Path:
        """Return a way from the robot on, with its cost on this map."""
        points = _from_robot(start_in_world, way)
        cost, _ = survey(costmap, points, self._astar.weight)
        return Path(points, cost, expanded)

    def _behind_people(
        self,
        costmap: Costmap,
        opened: Costmap,
        start_in_world: Array,
        goal_in_world: Array,
        people: Sequence[TrackedPerson],
    ) -> Array | None:
        """Return the way, (n, 2) [m], that would be free without the walking people, up to a gap behind them."""
        walking = [person for person in people if person.posture is Posture.WALKING]
        if not walking or costmap.cost_at(start_in_world) >= INSCRIBED:
            return None
        through = self._astar.search(_passable(opened, walking, self.largest_body), start_in_world, goal_in_world)
        if through is None:
            return None
        blocked = costmap.cost_at(through.points_in_world) >= INSCRIBED
        end = int(np.argmax(blocked)) - round(FOLLOW_GAP / costmap.resolution)
        return through.points_in_world[: max(end, 1)]

    def _up_to_edge(self, costmap: Costmap, way: Path) -> Path:
        """Cut off the end of a way whose social cost exceeds ADMITTED without a gap up to the goal.

        The cell before it goes too: a robot stops to within a cell.
        """
        points = way.points_in_world
        dear = costmap.social_cost_at(points[1:]) > ADMITTED * SOCIAL_MAX
        if not dear[-1]:
            return way
        admitted = np.flatnonzero(~dear)
        points = points[: 1 + int(admitted[-1])] if len(admitted) else points[:1]
        return Path(points, survey(costmap, points, self._astar.weight)[0], way.expanded)

    def _kept(self, costmap: Costmap, start_in_world: Array, goal_in_world: Array) -> Path | None:
        """Return the old way cut to begin at the robot, scored on this costmap; None where it is blocked or lost."""
        if self._way is None or costmap.cost_at(start_in_world) >= INSCRIBED:  # who must get out takes the best way
            return None
        distance = np.hypot(*(self._way - start_in_world).T)
        nearest = int(distance.argmin())
        goal_cell = costmap.cell_to_world(costmap.world_to_cell(goal_in_world))
        to_goal = goal_cell - self._way[-1]
        if distance[nearest] > JOIN or math.hypot(*to_goal) > JOIN:
            return None
        ahead = self._way[nearest:]
        if not np.array_equal(goal_cell, ahead[-1]):
            ahead = np.vstack([ahead, goal_cell])
        points = _from_robot(start_in_world, ahead)
        cost, free = survey(costmap, points, self._astar.weight)
        return Path(points, cost) if free else None


def _with_goal_opened(
    costmap: Costmap, goal_in_world: Array, people: Sequence[TrackedPerson], radius: float
) -> Costmap:
    """Return a map on which no disc of somebody who stays blocks the goal, so that the way towards it can be found."""
    if costmap.cost_at(goal_in_world) < INSCRIBED:
        return costmap
    staying = [person for person in people if person.posture is not Posture.WALKING]
    return _passable(costmap, [p for p in staying if math.dist(p.position_in_world, goal_in_world) <= radius], radius)


def _passable(costmap: Costmap, people: Sequence[TrackedPerson], radius: float) -> Costmap:
    """Return a map on which discs up to a radius [m] of some people cost SOCIAL_MAX; the building still blocks."""
    passable = costmap.copy()
    for person in people:
        window, x, y = costmap.centres_in_window(person.position_in_world, radius)
        near = np.hypot(x - person.position_in_world[0], y - person.position_in_world[1]) <= radius
        own = near & (costmap.cost[window] >= INSCRIBED) & (costmap.building[window] < INSCRIBED)
        passable.cost[window][own] = SOCIAL_MAX
    return passable


def _from_robot(start_in_world: Array, way: Array) -> Array:
    """Join the robot to a way ahead of it: drop the points that lie behind the robot's projection on it."""
    first = 0
    while first + 1 < len(way) and (way[first + 1] - way[first]) @ (start_in_world - way[first]) > 0.0:
        first += 1
    return np.vstack([start_in_world, way[first:]])


def survey(costmap: Costmap, points: Array, weight: float) -> tuple[float, bool]:
    """Return what a polyline, shape (n, 2) [m], costs, and whether it enters no blocked cell.

    The cost is the integral of 1 + weight * cost / 252 along it, ESCAPE_COST per metre in blocked cells.
    """
    x, y = costmap.origin_in_world
    cost, free = _survey(costmap.cost, x, y, costmap.resolution, points, weight)
    return float(cost), bool(free)


@numba.njit(cache=True)
def _survey(
    cost: Costs, origin_x: float, origin_y: float, resolution: float, points: Array, weight: float
) -> tuple[float, bool]:
    rows, columns = cost.shape
    total, free = 0.0, True
    for k in range(len(points) - 1):
        (x, y), dx, dy = points[k], points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1]
        length = math.hypot(dx, dy)
        # Half a cell or shorter, each taken at its middle: an even number, so that a diagonal step of the search is
        # not sampled at the corner between its cells, and costs here what it costs there.
        pieces = 2 * max(math.ceil(length / resolution - 0.5), 1)
        for i in range(pieces):
            part = (i + 0.5) / pieces
            column = math.floor((x + part * dx - origin_x) / resolution)
            row = math.floor((y + part * dy - origin_y) / resolution)
            inside = 0 <= row < rows and 0 <= column < columns
            if inside and cost[row, column] < INSCRIBED:
                total += (1.0 + weight * cost[row, column] / SOCIAL_MAX) * length / pieces
            else:
                total += ESCAPE_COST * length / pieces
                free = False
    return total, free
