"""How long a planning cycle takes in a shipped world where a person crosses the robot's way."""

import numpy as np
from numpy.typing import NDArray

from benchmarks.stopwatch import Stopwatch
from han_bullet.ablation import NoDetector, TrueLocalization, TruthTracker
from han_bullet.assembly import build_stack
from han_bullet.checks import check_world
from han_bullet.episode import Hook, Tick, run_episode
from han_bullet.geometry import Array
from han_bullet.sim.simulator import Simulator
from han_bullet.world_file import load_world
from han_bullet.world_schema import Person, Trigger, Walk, World

# Slowly across the corridor; the robot is there at the same time.
CROSSING_AT, SIDE, SPEED, DELAY = 8.0, 1.1, 0.3, 2.0  # [m], [m], [m/s], [s]
RUNS = 3


class Cycles(Hook):
    """Which ticks searched, and how many cells they expanded."""

    def __init__(self) -> None:
        self.expanded: list[int] = []

    def record(self, tick: Tick) -> None:
        """Note the tick; 0 where the way was only kept."""
        self.expanded.append(0 if tick.decision.path is None else tick.decision.path.expanded)


def crossed(world: World) -> World:
    """Return a world with one person, who crosses the corridor as the robot comes."""
    behaviour = Walk(waypoints=((CROSSING_AT, SIDE),), speed=SPEED, starts=Trigger(when="robot_moves", delay=DELAY))
    person = Person(name="walker", start=(CROSSING_AT, -SIDE, 0.5 * np.pi), behaviour=behaviour)
    return world.model_copy(update={"people": (person,), "expectations": ()})


def one_run(world: World) -> tuple[Array, Array, NDArray[np.int64]]:
    """Return by tick the time of all layers [s], that of the planner [s], and the cells expanded."""
    simulator = Simulator(world, renderer=None)
    stack = build_stack(
        world,
        localization=TrueLocalization(lambda: simulator.truth),
        detector=NoDetector(),
        tracker=TruthTracker(lambda: simulator.truth),
    )
    watch, cycles = Stopwatch(), Cycles()
    for layer in stack.layers:
        watch.watch(layer, "apply", layer.name)
    watch.watch(stack.planner, "update", "plan")
    run_episode(simulator, stack, duration=world.duration, hooks=[cycles])
    simulator.close()
    layers = np.sum([watch.times[layer.name] for layer in stack.layers], axis=0)
    return layers, np.array(watch.times["plan"]), np.array(cycles.expanded)


def replanning_row(name: str) -> tuple[object, ...]:
    """Return the line of a world: its searches, and median and 95th percentile of times [ms] and cells.

    Runs are equal tick by tick, so the median of three takes out what the machine did beside.
    """
    world = crossed(load_world(name))
    check_world(world, name)
    costmaps, plans, counts = zip(*(one_run(world) for _ in range(RUNS)), strict=True)
    assert all(np.array_equal(count, counts[0]) for count in counts)
    searched = np.flatnonzero(counts[0])[1:]  # the first loads compiled code
    times = [1e3 * np.median(runs, axis=0)[searched] for runs in (costmaps, plans)]
    figures = [f"{np.percentile(values, part):.3g}" for values in times for part in (50, 95)]
    cells = [round(float(np.percentile(counts[0][searched], part))) for part in (50, 95)]
    return (name, len(searched), *figures, *cells)
