"""The charts of a sweep: all seeds' ways on one map, how near the robot came, and small maps of what failed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from han_bullet.metrics.tally import PERSON_RADIUS
from han_bullet.report.charts import BLACK, GREY, PALE, ROBOT, VERMILION, person_colour, styled, svg
from han_bullet.report.compared import Figure as Compared
from han_bullet.report.compared import minimum_distances
from han_bullet.report.floor_plan import draw_floor_plan
from han_bullet.report.run_charts import PASSING
from han_bullet.report.run_files import Trace
from han_bullet.report.sweep_files import Sweep, SweepRow
from han_bullet.world_schema import World

EVERY = 4  # ticks of 0.05 s between the points of a drawn way
SPREAD = 0.28  # of a strip's points, either way


def draw_all_ways(world: World | None, runs: Sequence[tuple[SweepRow, Trace]]) -> bytes:
    """Draw the ways of all seeds, thin, over the map; runs that failed in another colour, dashed."""
    with styled():
        figure = Figure(figsize=(6.2, 2.5), layout="constrained")
        axes = figure.add_subplot()
        _draw_map(axes, world)
        for row, trace in runs:
            for index, person in enumerate(trace.people):
                axes.plot(*person.places[::EVERY].T, color=person_colour(index + 1), linewidth=0.6, alpha=0.6, zorder=3)
                axes.plot(*person.places[0], ".", color=person_colour(index + 1), markersize=3, alpha=0.7, zorder=3)
            style = {"color": ROBOT, "alpha": 0.6} if row.passed else {"color": VERMILION, "linestyle": (0, (4, 1.5))}
            axes.plot(*trace.poses[::EVERY, :2].T, linewidth=0.8, zorder=4 if row.passed else 5, **style)
        axes.set(xlabel="x [m]", ylabel="y [m]")
        return svg(figure)


def draw_small_map(world: World | None, trace: Trace) -> bytes:
    """Draw the ways of one run, small."""
    with styled():
        figure = Figure(figsize=(3.6, 1.25), layout="constrained")
        axes = figure.add_subplot()
        _draw_map(axes, world, names=False)
        for index, person in enumerate(trace.people):
            axes.plot(*person.places[::EVERY].T, color=person_colour(index + 1), linewidth=1.0, zorder=3)
            axes.plot(*person.places[-1], "o", color=person_colour(index + 1), markersize=3, zorder=3)
        axes.plot(*trace.poses[::EVERY, :2].T, color=ROBOT, linewidth=1.4, zorder=4)
        axes.plot(*trace.poses[-1, :2], "o", color=ROBOT, markersize=4, zorder=4)
        axes.set(xticks=[], yticks=[])
        axes.spines[:].set_visible(False)
        return svg(figure)


def _draw_map(axes: Axes, world: World | None, names: bool = True) -> None:
    axes.set_aspect("equal")
    if world is not None:
        draw_floor_plan(axes, world, cameras=False, names=names)


def draw_minimum_distances(sweep: Sweep, world: str, robot_radius: float) -> bytes | None:
    """Draw a strip per variant and person: how near the robot came in each run; None without people.

    Args:
        sweep: Where the runs are.
        world: Name of the world.
        robot_radius: Of its robot [m], for the line at which bodies touch.
    """
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
            touch = axes.axvline(robot_radius + PERSON_RADIUS, color=BLACK, linewidth=0.8, zorder=1)
            passing = axes.axvline(PASSING, color=BLACK, linewidth=0.8, linestyle="--", zorder=1)
            axes.set(title=person, xlabel="minimum distance between centres [m]", xlim=(0.0, None))
            axes.grid(axis="x", color=PALE, linewidth=0.5)
            axes.tick_params(axis="y", length=0)
        charts[0].set(yticks=range(len(variants)), yticklabels=variants, ylim=(len(variants) - 0.5, -0.5))
        touch.set_label("bodies touch")
        passing.set_label("0.75 m, to be kept in passing")
        handles = [
            Line2D([], [], color=ROBOT, marker="o", linestyle="", markersize=4, label="met all expectations"),
            Line2D([], [], color=VERMILION, marker="x", linestyle="", markersize=5, label="did not"),
            Line2D([], [], color=GREY, marker="|", linestyle="", markersize=12, markeredgewidth=2, label="median"),
            *(touch, passing),
        ]
        figure.legend(handles=handles, loc="outside upper left", ncols=5)
        return svg(figure)


def _draw_strip(axes: Axes, place: int, rows: Sequence[SweepRow], distance: Compared, rng: np.random.Generator) -> None:
    values = [(distance.value(row), row.passed) for row in rows]
    known = [(value, passed) for value, passed in values if value is not None]
    if not known:
        return
    for value, passed in known:
        height = place + SPREAD * rng.uniform(-1.0, 1.0)
        if passed:
            axes.plot(value, height, "o", color=ROBOT, markersize=4, alpha=0.7, markeredgewidth=0)
        else:
            axes.plot(value, height, "x", color=VERMILION, markersize=5)
    median = float(np.median([value for value, _ in known]))
    axes.plot(median, place, "|", color=GREY, markersize=16, markeredgewidth=2)
