"""The benchmark of the planner on maps small enough to be quick."""

import sys

import numpy as np
import pytest

from benchmarks.planner import NotOptimal, Outcome, check_optimal, compare
from benchmarks.planner import main as planner_main
from benchmarks.planner_maps import problem
from benchmarks.planner_optimum import explicit_graph, optimum, score
from benchmarks.planner_peers import Geometric, Ours, all_peers
from benchmarks.replanning import replanning_row
from han_bullet.costmap.grid import INSCRIBED, LETHAL, Costmap
from han_bullet.errors import BadInputError
from han_bullet.planning.astar import astar


@pytest.mark.parametrize("clutter", ["light", "heavy"])
def test_a_map_is_the_same_for_the_same_seed_and_its_ends_are_free_and_joined(clutter: str) -> None:
    task, again = problem(100, clutter, pairs=3), problem(100, clutter, pairs=3)
    assert np.array_equal(task.costmap.cost, again.costmap.cost) and np.array_equal(task.ends, again.ends)
    assert task.ends.shape == (4, 2, 2)
    assert (task.costmap.cost_at(task.ends) < INSCRIBED).all()
    assert np.hypot(*(task.ends[0, 1] - task.ends[0, 0])) > 3.5
    assert ((task.costmap.cost > 0) & (task.costmap.building == 0)).any(), "no cost of people"
    for start, goal in task.ends:
        assert astar(task.costmap, start, goal) is not None


def test_the_ways_of_ours_cost_the_optimum_and_no_planner_s_cost_less_unless_they_cut_corners() -> None:
    task = problem(100, "heavy", pairs=2)
    graph = explicit_graph(task.costmap, 10.0)
    best = [optimum(graph, task.costmap, start, goal) for start, goal in task.ends]
    peers = [Ours(task.costmap, 10.0), Geometric(task.costmap, 10.0)]
    ours, geometric = compare(task, peers, task.ends, rounds=2, weight=10.0)
    check_optimal(task, ours, best)
    assert ours.costs == pytest.approx(best, rel=1e-9) and not ours.cuts_corners
    assert len(ours.times) == len(geometric.times) == 2 and len(ours.expanded) == 3
    assert geometric.cuts_corners or geometric.costs == pytest.approx(best, rel=1e-9)


def test_a_way_that_is_not_the_cheapest_fails_the_benchmark() -> None:
    task = problem(40, "light", pairs=0)
    with pytest.raises(NotOptimal, match=r"ours costs 2\.1 m, the optimum 2\.0"):
        check_optimal(task, Outcome(costs=[2.1]), [2.0])
    with pytest.raises(NotOptimal, match=r"ours costs 1\.9 m"):
        check_optimal(task, Outcome(costs=[1.9]), [2.0])


def test_a_way_past_a_blocked_corner_is_marked_and_its_optimum_goes_round() -> None:
    costmap = Costmap.covering([((0.0, 0.1), (0.0, 0.1))], 0.05)
    costmap.cost[0, 1] = LETHAL
    assert score(costmap, np.array([[0, 0], [1, 1]]), 10.0) == (pytest.approx(0.05 * 2**0.5), True)
    assert score(costmap, np.array([[0, 0], [1, 0], [1, 1]]), 10.0) == (pytest.approx(0.1), False)
    assert optimum(explicit_graph(costmap, 10.0), costmap, np.array([0.02, 0.02]), np.array([0.08, 0.08])) == 0.1


def test_a_peer_that_is_not_installed_is_told_with_what_brings_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "pyastar2d", None)
    with pytest.raises(BadInputError, match=r"pyastar2d is not installed; .*\[bench\]"):
        all_peers(problem(40, "light", pairs=0).costmap, 10.0)
    monkeypatch.setattr(sys, "argv", ["planner", "--sizes", "40", "--worlds"])
    with pytest.raises(SystemExit) as ended:
        planner_main()
    assert ended.value.code == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_the_robot_replans_while_somebody_crosses_its_way() -> None:
    name, cycles, *figures = replanning_row("real2")
    assert name == "real2" and isinstance(cycles, int) and cycles > 40
    assert all(float(str(figure)) > 0.0 for figure in figures)
