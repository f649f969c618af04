"""A* against an independent Dijkstra, and what blocks it."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from han_bullet.costmap.grid import INSCRIBED, LETHAL, UNKNOWN, Costmap
from han_bullet.errors import BadInputError
from han_bullet.planning.astar import ESCAPE_COST, AStar, astar

RESOLUTION = 0.05
SIZE = 24  # cells


def grid(seed: int, blocked_part: float, escape: bool = False) -> Costmap:
    """A random map of smooth patches, walls and people's discs."""
    generator = np.random.default_rng(seed)
    costmap = Costmap.covering([((0.0, SIZE * RESOLUTION), (0.0, SIZE * RESOLUTION))], RESOLUTION)
    costmap.cost[:] = np.kron(generator.integers(0, 253, (SIZE // 4, SIZE // 4)), np.ones((4, 4)))
    draw = generator.random(costmap.shape)
    costmap.building[draw < blocked_part] = generator.choice([INSCRIBED, LETHAL, UNKNOWN])
    if escape:
        costmap.cost[:12, :12] = LETHAL
    np.maximum(costmap.cost, costmap.building, out=costmap.cost)
    return costmap


def dijkstra_cost(costmap: Costmap, start: int, goal: int, weight: float) -> float:
    """The same problem as a sparse graph, built with plain loops over pairs of cells."""
    cost, building = costmap.cost.astype(float).ravel(), costmap.building.ravel()
    rows, columns = costmap.shape
    if building[start] >= LETHAL or cost[goal] >= INSCRIBED:
        return math.inf
    worst_to_pass = INSCRIBED if building[start] == INSCRIBED else INSCRIBED - 1

    def enters(a: int, b: int) -> bool:
        return cost[b] <= 252 or (cost[a] > 252 and building[b] <= worst_to_pass)

    edges = []
    for a in range(rows * columns):
        row, column = divmod(a, columns)
        for dr, dc in [(0, 1), (1, 0), (1, 1), (1, -1), (0, -1), (-1, 0), (-1, -1), (-1, 1)]:
            if not (0 <= row + dr < rows and 0 <= column + dc < columns):
                continue
            b, side, above = (
                (row + dr) * columns + column + dc,
                row * columns + column + dc,
                (row + dr) * columns + column,
            )
            if not enters(a, b) or (dr and dc and not (enters(a, side) and enters(a, above))):
                continue
            metres = RESOLUTION * math.hypot(dr, dc)
            blocked = max(cost[a], cost[b]) > 252
            edges.append((a, b, metres * (ESCAPE_COST if blocked else 1 + weight * (cost[a] + cost[b]) / 2 / 252)))
    if not edges:
        return math.inf
    tails, heads, lengths = zip(*edges, strict=True)
    graph = csr_array((lengths, (tails, heads)), shape=(rows * columns, rows * columns))
    return float(dijkstra(graph, indices=start)[goal])


@given(
    seed=st.integers(0, 10_000),
    ends=st.tuples(*[st.integers(0, SIZE - 1)] * 4),
    weight=st.sampled_from([0.0, 1.0, 10.0, 20.0, 1000.0]),
    blocked_part=st.sampled_from([0.0, 0.15, 0.4]),
    escape=st.booleans(),
)
@settings(max_examples=60, deadline=None)
def test_the_cost_equals_that_of_dijkstra(
    seed: int, ends: tuple[int, int, int, int], weight: float, blocked_part: float, escape: bool
) -> None:
    costmap = grid(seed, blocked_part, escape)
    start, goal = np.array(ends[:2]), np.array(ends[2:])
    path = astar(costmap, costmap.cell_to_world(start), costmap.cell_to_world(goal), weight=weight)
    want = dijkstra_cost(costmap, int(start @ [SIZE, 1]), int(goal @ [SIZE, 1]), weight)
    assert (path is None) == math.isinf(want)
    if path is not None:
        assert path.cost == pytest.approx(want, rel=1e-12, abs=1e-9)
        steps = np.diff(costmap.world_to_cell(path.points_in_world), axis=0)
        assert (np.abs(steps).max(axis=1) == 1).all()
        assert np.array_equal(path.points_in_world[[0, -1]], costmap.cell_to_world(np.array([start, goal])))


def test_a_search_with_used_memory_gives_what_a_fresh_one_gives() -> None:
    search = AStar(weight=10.0)
    for seed in range(5):
        costmap = grid(seed, 0.1)
        costmap.cost[:, [0, -1]] = costmap.building[:, [0, -1]] = 0
        ends = costmap.cell_to_world(np.array([[1, 0], [20, 23]]))
        again, fresh = search.search(costmap, *ends), astar(costmap, *ends, weight=10.0)
        assert again is not None and fresh is not None
        assert np.array_equal(again.points_in_world, fresh.points_in_world)


def test_a_search_remembers_nothing_of_one_without_a_way_nor_of_a_map_of_another_shape() -> None:
    search, ends = AStar(), np.array([[0.2, 0.2], [1.0, 0.9]])
    wide = Costmap.covering([((0.0, 2.4), (0.0, 1.2))], RESOLUTION)
    tall = Costmap.covering([((0.0, 1.2), (0.0, 2.4))], RESOLUTION)
    closed = tall.copy()
    closed.cost[:, 12] = LETHAL
    assert wide.cost.size == tall.cost.size and wide.shape != tall.shape
    for costmap, there_is_a_way in [(wide, True), (tall, True), (closed, False), (tall, True), (closed, False)]:
        again, fresh = search.search(costmap, *ends), astar(costmap, *ends)
        assert (again is not None) == (fresh is not None) == there_is_a_way
        if again is not None and fresh is not None:
            assert np.array_equal(again.points_in_world, fresh.points_in_world)
            assert (again.cost, again.expanded) == (fresh.cost, fresh.expanded)


def test_on_an_empty_floor_hardly_more_cells_are_expanded_than_the_way_has() -> None:
    costmap = Costmap.covering([((0.0, 5.0), (0.0, 5.0))], RESOLUTION)
    path = astar(costmap, np.array([0.52, 0.52]), np.array([4.02, 2.02]))
    assert path is not None
    assert path.cost == pytest.approx(RESOLUTION * (40 + 30 * math.sqrt(2.0)))
    assert len(path.points_in_world) - 1 == 70 and 70 <= path.expanded <= 100


def test_a_start_that_is_the_goal_is_a_way_of_one_point_and_no_cost() -> None:
    path = astar(grid(0, 0.0), np.array([0.51, 0.52]), np.array([0.53, 0.54]))
    assert path is not None
    assert path.points_in_world == pytest.approx(np.array([[0.525, 0.525]]))
    assert path.cost == 0.0 and path.expanded == 1


@pytest.mark.parametrize("point", [(-0.1, 0.5), (0.5, 5.0), (1.3, 1.3)])
def test_there_is_no_way_from_or_to_a_place_off_the_map(point: tuple[float, float]) -> None:
    costmap = grid(0, 0.0)
    assert astar(costmap, np.array(point), np.array([0.5, 0.5])) is None
    assert astar(costmap, np.array([0.5, 0.5]), np.array(point)) is None


@pytest.mark.parametrize("value", [INSCRIBED, LETHAL, UNKNOWN])
def test_there_is_no_way_to_a_blocked_goal_nor_through_a_closed_wall(value: int) -> None:
    costmap = grid(0, 0.0)
    costmap.cost[:, 12] = value
    assert astar(costmap, np.array([0.2, 0.2]), np.array([0.625, 0.2])) is None
    assert astar(costmap, np.array([0.2, 0.2]), np.array([1.0, 0.2])) is None
    costmap.cost[5, 12] = 0
    assert astar(costmap, np.array([0.2, 0.2]), np.array([1.0, 0.2])) is not None


def test_a_diagonal_gap_between_two_blocked_cells_is_closed() -> None:
    costmap = Costmap.covering([((0.0, 0.1), (0.0, 0.1))], 0.05)
    costmap.cost[0, 1] = LETHAL
    costmap.cost[1, 0] = LETHAL
    assert astar(costmap, np.array([0.02, 0.02]), np.array([0.08, 0.08])) is None
    costmap.cost[1, 0] = 0
    path = astar(costmap, np.array([0.02, 0.02]), np.array([0.08, 0.08]))
    assert path is not None and len(path.points_in_world) == 3


def in_a_persons_disc() -> tuple[Costmap, np.ndarray]:
    """A 4 x 1 m corridor, a disc of 0.7 m round a person at (2, 0.5) that fills its width, a robot at (1.5, 0.5)."""
    costmap = Costmap.covering([((0.0, 4.0), (0.0, 1.0))], 0.05)
    window, x, y = costmap.centres_in_window(np.array([2.0, 0.5]), 0.7)
    costmap.raise_to(window, (LETHAL * (np.hypot(x - 2.0, y - 0.5) <= 0.7)).astype(np.uint8))
    assert costmap.cost_at(np.array([1.5, 0.5])) == LETHAL
    return costmap, np.array([1.5, 0.5])


def test_a_robot_in_a_persons_disc_leaves_it_backwards_and_not_through_the_person() -> None:
    costmap, start = in_a_persons_disc()
    path = astar(costmap, start, np.array([0.5, 0.5]))
    assert path is not None
    assert (path.points_in_world[:, 0] <= 1.53).all()
    assert path.cost == pytest.approx(0.75 + 0.25 * ESCAPE_COST, abs=0.1 * ESCAPE_COST)


def test_a_robot_in_a_persons_disc_does_not_leave_through_the_building() -> None:
    costmap, start = in_a_persons_disc()
    for value in (INSCRIBED, LETHAL, UNKNOWN):
        walled = costmap.copy()
        walled.building[:, 27] = value
        np.maximum(walled.cost, walled.building, out=walled.cost)
        assert astar(walled, start, np.array([0.5, 0.5])) is None
        walled.building[4, 27] = 0
        assert astar(walled, start, np.array([0.5, 0.5])) is not None


def test_a_robot_that_scrapes_along_a_wall_may_leave_the_inscribed_band_but_not_enter_the_wall() -> None:
    costmap = Costmap.covering([((0.0, 2.0), (0.0, 2.0))], 0.05)
    costmap.building[:4, :], costmap.building[4:10, :] = LETHAL, INSCRIBED
    np.maximum(costmap.cost, costmap.building, out=costmap.cost)
    path = astar(costmap, np.array([1.0, 0.4]), np.array([1.0, 1.5]))
    assert path is not None and path.points_in_world[:, 1].min() >= 0.4
    assert astar(costmap, np.array([1.0, 0.1]), np.array([1.0, 1.5])) is None


def test_the_detour_grows_with_the_amplitude_of_a_cost() -> None:
    clearances = []
    for amplitude in (0, 20, 60, 120, 250):
        costmap = Costmap.covering([((0.0, 6.0), (-1.5, 1.5))], 0.05)
        window, x, y = costmap.centres_in_window(np.array([3.0, -0.1]), 2.0)
        values = amplitude * np.exp(-((x - 3.0) ** 2 + (y + 0.1) ** 2) / (2 * 0.56**2))
        costmap.raise_to(window, values.astype(np.uint8))
        path = astar(costmap, np.array([0.5, 0.0]), np.array([5.5, 0.0]), weight=10.0)
        assert path is not None
        clearances.append(float(np.hypot(*(path.points_in_world - [3.0, -0.1]).T).min()))
    assert all(a <= b + 1e-9 for a, b in itertools.pairwise(clearances))
    assert clearances[-1] > clearances[0] + 0.8


@pytest.mark.parametrize("weight", [-0.1, math.nan, math.inf, 10_000.1])
def test_a_weight_that_would_break_the_heuristic_or_fill_the_memory_is_refused(weight: float) -> None:
    with pytest.raises(BadInputError, match="planner weight is"):
        AStar(weight=weight)
