"""The charts of one run: the ways on the map, and what changed over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from han_bullet.geometry import Array
from han_bullet.metrics.distances import ZONES
from han_bullet.metrics.tally import PERSON_RADIUS
from han_bullet.report.charts import BLACK, GREY, PALE, ROBOT, SPEEDS, grid, person_colour, styled, svg, write_beside
from han_bullet.report.floor_plan import draw_floor_plan
from han_bullet.report.run_files import Run
from han_bullet.run_tables import PersonWay, Trace
from han_bullet.world_schema import Robot, World

MARK_EVERY = 5.0  # [s] along the ways
WIDTH = 11.0  # [inch]; text of 9 points stays readable where the page shows it narrower
ZONE_TINTS = {"intimate": "#f6ded2", "personal": "#faeee4", "social": "#fbf8ee"}
FARTHEST_SHOWN = 5.0  # [m]
DEFAULT_ROBOT_RADIUS: float = Robot.model_fields["radius"].default  # [m] of the robot, where the world is not known


def draw_ways(run: Run) -> bytes:
    """Draw the ways of robot, people and tracks over the map."""
    with styled():
        figure = Figure(figsize=(WIDTH, 4.3), layout="constrained")
        axes = figure.add_subplot()
        axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
        if run.world is not None:
            draw_floor_plan(axes, run.world)
        _draw_tracks(axes, run)
        for index, person in enumerate(run.trace.people):
            _draw_person(axes, run.trace.time, person, person_colour(index))
        line = _draw_robot(axes, run.trace)
        figure.colorbar(line, ax=axes, label="robot's speed [m/s]", pad=0.01, aspect=30, shrink=0.8)
        figure.legend(handles=_legend(run), loc="outside lower center", ncols=5)
        return svg(figure)


def _draw_robot(axes: Axes, trace: Trace) -> LineCollection:
    places = trace.poses[:, :2]
    pieces = np.stack([places[:-1], places[1:]], axis=1)
    line = LineCollection(list(pieces), cmap=SPEEDS, array=trace.speed[1:], linewidths=2.6, zorder=5, capstyle="round")
    line.set_clim(0.0, max(float(trace.speed.max()), 0.1))
    axes.add_collection(line, autolim=True)
    axes.plot(*places[0], "s", color=ROBOT, markersize=6, zorder=6)
    axes.plot(*places[-1], "o", color=ROBOT, markersize=6, zorder=6)
    for time, place in _marks(trace.time, places):
        axes.plot(*place, "o", color="white", markeredgecolor=BLACK, markersize=4, markeredgewidth=0.8, zorder=6)
        write_beside(axes, f"{time:g} s", place, (0.0, 6.0))
    return line


def _marks(time: Array, places: Array) -> list[tuple[float, Array]]:
    """Return the moments at which ways are marked, and where one was then."""
    moments = np.arange(MARK_EVERY, time[-1] + 1e-6, MARK_EVERY)
    return [(float(moment), places[int(np.abs(time - moment).argmin())]) for moment in moments]


def _draw_person(axes: Axes, time: Array, person: PersonWay, colour: str) -> None:
    places = person.places
    write_beside(axes, person.name, places[0], (0.0, -12.0), colour)
    axes.plot(*places.T, color=colour, linewidth=2.0, zorder=4)
    if np.ptp(places, axis=0).max() > 0.5:
        for _, place in _marks(time, places):
            axes.plot(*place, "o", color=colour, markersize=3, zorder=4)
    axes.plot(*places[0], "s", color=colour, markersize=6, zorder=4, markeredgecolor="white", markeredgewidth=0.6)
    axes.plot(*places[-1], "o", color=colour, markersize=6, zorder=4, markeredgecolor="white", markeredgewidth=0.6)


def _draw_tracks(axes: Axes, run: Run) -> None:
    """Draw what the stack believed, one thin line per track id."""
    ways: dict[int, list[tuple[float, float]]] = {}
    for _, tracks in sorted(run.tracks.items()):
        for track in tracks:
            ways.setdefault(track.id, []).append(track.state[:2])
    for way in ways.values():
        axes.plot(*np.array(way).T, color=GREY, linewidth=0.8, zorder=4.5, linestyle=(0, (3, 1.5)))


def _legend(run: Run) -> list[Line2D]:
    start = Line2D([], [], color=BLACK, marker="s", linestyle="", label="start")
    end = Line2D([], [], color=BLACK, marker="o", linestyle="", label=f"end; small circles every {MARK_EVERY:g} s")
    tracks = Line2D([], [], color=GREY, linewidth=0.8, linestyle="--", label="tracks: what the stack believed")
    people = [
        Line2D([], [], color=person_colour(index), linewidth=2.0, label=f"{person.name} (true way)")
        for index, person in enumerate(run.trace.people)
    ]
    return [start, end, tracks, *people]


def draw_encounters(run: Run) -> bytes:
    """Draw the distance to each person and the robot's speed over time, with the moments at which devices went on."""
    trace = run.trace
    radius = DEFAULT_ROBOT_RADIUS if run.world is None else run.world.robot.radius
    with styled():
        figure = Figure(figsize=(WIDTH, 5.2), layout="constrained")
        distance, speed = figure.subplots(2, 1, sharex=True, height_ratios=(2.2, 1.0))
        distance.set_xlim(trace.time[0], max(trace.time[-1], 1.0))
        _draw_zones(distance, radius)
        _draw_expected(distance, run)
        for index, (person, row) in enumerate(zip(trace.people, trace.distances(), strict=True)):
            nearest = int(row.argmin())
            distance.plot(trace.time, row, color=person_colour(index), label=person.name)
            distance.plot(trace.time[nearest], row[nearest], "v", color=person_colour(index), markersize=5)
            place = (trace.time[nearest], row[nearest])
            write_beside(distance, f"{row[nearest]:.2f}", place, (-2.0, 5.0), person_colour(index), "right")
        distance.set(ylabel="distance between centres [m]", ylim=(0.0, FARTHEST_SHOWN))
        if trace.people:
            distance.legend(loc="upper right", ncols=4)
        speed.plot(trace.time, trace.speed, color=ROBOT)
        speed.set(xlabel="time [s]", ylabel="speed [m/s]", ylim=(0.0, None))
        grid(speed)
        _draw_moments((distance, speed), run.devices_on)
        return svg(figure)


def _draw_zones(axes: Axes, robot_radius: float) -> None:
    """Draw Hall's zones, which are between surfaces, over distances between centres."""
    below = touch = robot_radius + PERSON_RADIUS
    for name, tint in ZONE_TINTS.items():
        top = touch + ZONES[name]
        axes.axhspan(below, top, color=tint, linewidth=0, zorder=0)
        below = top
        axes.text(0.003, top - 0.03, name, transform=axes.get_yaxis_transform(), va="top", fontsize=7, color=GREY)
    axes.axhline(touch, color=BLACK, linewidth=0.8)
    write_beside(axes, "bodies touch", (0.07 * axes.get_xlim()[1], touch), (0.0, -8.0), align="left")


def expected_distance(world: World, person: str) -> float | None:
    """Return the least distance to a person [m] that a world expects; None where it expects none."""
    about = ("minimum_distance", f"minimum_distance.{person}")
    return max((e.at_least for e in world.expectations if e.metric in about and e.at_least is not None), default=None)


def _draw_expected(axes: Axes, run: Run) -> None:
    """Draw the least distances that the world expects, with those to whom they are to be kept."""
    kept: dict[float, list[str]] = {}
    for person in run.trace.people:
        least = None if run.world is None else expected_distance(run.world, person.name)
        if least is not None:
            kept.setdefault(least, []).append(person.name)
    for least, names in kept.items():
        axes.axhline(least, xmin=0.06, color=BLACK, linewidth=0.8, linestyle="--")  # beside the name of a zone
        words = f"{least:g} m expected from {', '.join(names)}"
        write_beside(axes, words, (0.07 * axes.get_xlim()[1], least), (0.0, 2.0), align="left")


def _draw_moments(charts: Sequence[Axes], moments: Mapping[str, float]) -> None:
    for axes in charts:
        for time in moments.values():
            axes.axvline(time, color=GREY, linewidth=0.9, linestyle=":")
    for name, time in moments.items():
        transform = charts[0].get_xaxis_transform()
        charts[0].text(time, 1.0, f" {name} on", transform=transform, va="bottom", fontsize=8, color=GREY)


def draw_perception(run: Run, errors: Mapping[str, Array]) -> bytes:
    """Draw when each person had a track, and how far that was from them.

    Args:
        run: The run.
        errors: Per person, shape (n,) [m]; NaN where nobody was matched.
    """
    time, names = run.trace.time, list(errors)
    with styled():
        figure = Figure(figsize=(WIDTH, 2.6 + 0.3 * len(names)), layout="constrained")
        known, error = figure.subplots(2, 1, sharex=True, height_ratios=(0.35 * len(names), 1.5))
        for index, name in enumerate(names):
            colour, row = person_colour(index), errors[name]
            known.plot(time, np.full(len(time), index), color=PALE, linewidth=7, solid_capstyle="butt")
            known.plot(
                time, np.where(np.isfinite(row), index, np.nan), color=colour, linewidth=7, solid_capstyle="butt"
            )
            error.plot(time, row, color=colour, label=name)
        shares = [f"{name}  {np.isfinite(errors[name]).mean():.0%}" for name in names]
        known.set(yticks=range(len(names)), yticklabels=shares, ylim=(len(names) - 0.4, -0.6))
        known.set_title("has a track (share of the whole run); pale: not", color=GREY)
        known.spines[["left", "bottom"]].set_visible(False)
        known.tick_params(length=0)
        error.set(xlabel="time [s]", ylabel="error of place [m]", ylim=(0.0, None), xlim=(time[0], max(time[-1], 1.0)))
        grid(error)
        return svg(figure)
