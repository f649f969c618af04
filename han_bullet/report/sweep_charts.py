"""The charts of a sweep: all seeds' ways on one map, how near the robot came, and small maps of what failed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from han_bullet.metrics.tally import PERSON_RADIUS
from han_bullet.report.charts import BLACK, GREY, PALE, PEOPLE, ROBOT, VERMILION, styled, svg
from han_bullet.report.compared import Figure as Compared
from han_bullet.report.compared import minimum_distances
from han_bullet.report.run_charts import DEFAULT_ROBOT_RADIUS, expected_distance
from han_bullet.report.sweep_files import Sweep, SweepRow
from han_bullet.report.way_maps import Stroke, draw_way_map
from han_bullet.run_tables import Trace
from han_bullet.world_schema import World

EVERY = 4  # ticks of 0.05 s between the points of a drawn way
SPREAD = 0.28  # of a strip's points, either way
TOUCH: dict[str, Any] = {"color": BLACK, "linewidth": 0.8, "zorder": 1}
EXPECTED: dict[str, Any] = {**TOUCH, "linestyle": "--"}


def draw_all_ways(world: World | None, runs: Sequence[tuple[SweepRow, Trace]]) -> bytes:
    """Draw the ways of all seeds, thin, over the map; runs that failed in another colour, dashed."""
    people = [
        Stroke(person.places[::EVERY], _person_colour(index), 3.0, 6.0, 0.6)
        for _, trace in runs
        for index, person in enumerate(trace.people)
    ]
    robots = [
        _robot(row.passed, trace, 4.0, 0.0, 0.6 if row.passed else 1.0)
        for row, trace in sorted(runs, key=lambda run: not run[0].passed)
    ]
    return draw_way_map(world, [*people, *robots])


def draw_small_map(world: World | None, row: SweepRow, trace: Trace) -> bytes:
    """Draw the ways of one run, small, with dots where they end."""
    people = [
        Stroke(person.places[::EVERY], _person_colour(index), 9.0, -16.0) for index, person in enumerate(trace.people)
    ]
    return draw_way_map(world, [*people, _robot(row.passed, trace, 12.0, -20.0)], lettered=False)


def _robot(passed: bool, trace: Trace, width: float, dot: float, opacity: float = 1.0) -> Stroke:
    """Return the robot's way, of a width and with a dot as `Stroke` has them [cm]."""
    colour = ROBOT if passed else VERMILION
    return Stroke(trace.poses[::EVERY, :2], colour, width, dot, opacity, dashed=not passed)


def _person_colour(index: int) -> str:
    """Return the colour of a person, by their place in the world file; none has that of what failed."""
    colours = [colour for colour in PEOPLE if colour != VERMILION]
    return colours[index % len(colours)]


def draw_minimum_distances(sweep: Sweep, world: str, known: World | None) -> bytes | None:
    """Draw a strip per variant and person: how near the robot came in each run; None without people.

    Args:
        sweep: Where the runs are.
        world: Name of the world.
        known: The world itself where a run has left it, for where bodies touch and what is expected.
    """
    robot_radius = DEFAULT_ROBOT_RADIUS if known is None else known.robot.radius
    variants = [variant for variant in sweep.variants if sweep.of(world, variant)]
    figures = minimum_distances(row for row in sweep.rows if row.world == world)
    if not figures:
        return None
    with styled():
        figure = Figure(figsize=(11.0, 1.1 + 0.36 * len(variants)), layout="constrained")
        charts = figure.subplots(1, len(figures), sharey=True, squeeze=False)[0]
        rng = np.random.default_rng(0)  # of the scatter across a strip, which means nothing
        for axes, (person, distance) in zip(charts, figures.items(), strict=True):
            for index, variant in enumerate(variants):
                _draw_strip(axes, index, sweep.of(world, variant), distance, rng)
            axes.axvline(robot_radius + PERSON_RADIUS, **TOUCH)
            least = None if known is None else expected_distance(known, person)
            if least is not None:
                axes.axvline(least, **EXPECTED)
            title = person if least is None else f"{person}: at least {least:g} m expected"
            axes.set(title=title, xlabel="minimum distance between centres [m]", xlim=(0.0, None))
            axes.grid(axis="x", color=PALE, linewidth=0.5)
            axes.tick_params(axis="y", length=0)
        charts[0].set(yticks=range(len(variants)), yticklabels=variants, ylim=(len(variants) - 0.5, -0.5))
        handles = [
            Line2D([], [], color=ROBOT, marker="o", linestyle="", markersize=4, label="met all expectations"),
            Line2D([], [], color=VERMILION, marker="x", linestyle="", markersize=5, label="did not"),
            Line2D([], [], color=GREY, marker="|", linestyle="", markersize=12, markeredgewidth=2, label="median"),
            Line2D([], [], label="bodies touch", **TOUCH),
            Line2D([], [], label="least that the world expects", **EXPECTED),
        ]
        figure.legend(handles=handles, loc="outside upper left", ncols=5)
        return svg(figure)


def _draw_strip(axes: Axes, place: int, rows: Sequence[SweepRow], distance: Compared, rng: np.random.Generator) -> None:
    values = [(distance.value(row), row.passed) for row in rows]
    known = [(value, passed) for value, passed in values if value is not None]
    if not known:
        return
    marks = np.array([(value, place + SPREAD * rng.uniform(-1.0, 1.0)) for value, _ in known])
    met = np.array([passed for _, passed in known])
    axes.plot(*marks[met].T, "o", color=ROBOT, markersize=4, alpha=0.7, markeredgewidth=0)
    axes.plot(*marks[~met].T, "x", color=VERMILION, markersize=5)
    median = float(np.median([value for value, _ in known]))
    axes.plot(median, place, "|", color=GREY, markersize=16, markeredgewidth=2)
