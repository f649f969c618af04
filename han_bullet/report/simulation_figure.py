"""The paper's simulations as moments: costmap, planned path, way so far and people [Mateus2019]."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.patches import Circle, Patch
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from han_bullet.costmap.grid import SOCIAL_MAX, Costmap
from han_bullet.costmap.interaction import InteractionLayer
from han_bullet.costmap.layers import layer_parameters
from han_bullet.episode import Hook, Tick
from han_bullet.geometry import Array, Pose2D
from han_bullet.messages import Posture
from han_bullet.metrics.passing import LEVEL_WITHIN
from han_bullet.metrics.tally import PERSON_RADIUS
from han_bullet.report.charts import BLACK, COSTS, ROBOT, SKY
from han_bullet.report.floor_plan import draw_floor_plan
from han_bullet.runner import RunOptions, run_world
from han_bullet.topdown import extent
from han_bullet.world_file import load_world
from han_bullet.world_schema import World

AFTER = 0.6  # [s] after something changed, when the new plan is there and the robot on its way
ABOVE_BODY = 0.75  # [m] from a person to their name, beyond the disc that is closed to the robot
CORRIDOR = 1.75  # [m] either side of the corridor's middle, walls included
TITLE = 0.2  # [inch] above the upper row, whose titles the layout leaves out where axes keep equal scales
WIDTH, WIDE = 11.0, 2.5  # [inch]; from this ratio of width to height on, moments stand in two rows


class _Film(Hook):
    """Keep every tick; a truth run without pictures is small."""

    def __init__(self) -> None:
        self.ticks: list[Tick] = []

    def record(self, tick: Tick) -> None:
        self.ticks.append(tick)


def draw_simulation(world_name: str) -> Figure:
    """Run a world with true perception and draw four moments of it: start, change, passing, end."""
    world = load_world(world_name)
    film = _Film()
    with tempfile.TemporaryDirectory() as folder:
        run_world(world_name, RunOptions(perception="truth", video=False), Path(folder), hooks=[film])
    chosen = moments(film.ticks)
    limits = _limits(world, film.ticks)
    wide = np.ptp(limits[0]) > WIDE * np.ptp(limits[1])
    rows, columns = (2, 2) if wide else (1, 4)
    height = rows * (0.9 * WIDTH / columns * np.ptp(limits[1]) / np.ptp(limits[0]) + 0.35) + 0.3 + TITLE
    figure = Figure(figsize=(WIDTH, height), layout=ConstrainedLayoutEngine(rect=(0.0, 0.0, 1.0, 1.0 - TITLE / height)))
    charts = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes, letter, tick in zip(charts.ravel(), "abcd", (film.ticks[index] for index in chosen), strict=True):
        image = _draw_moment(axes, world, tick, film.ticks)
        axes.set(xlim=limits[0], ylim=limits[1])
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_title(f"({letter}) {tick.truth.time:.1f} s{_devices(tick, film.ticks[-1])}")
    for axes in charts[-1]:
        axes.set_xlabel("x [m]")
    for axes in charts[:, 0]:
        axes.set_ylabel("y [m]")
    handles = charts[0, 0].get_legend_handles_labels()[0] + _watched(film.ticks[-1])
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    figure.colorbar(image, ax=list(charts.ravel()), label="cost g; black: bodies", pad=0.01, aspect=20 * rows)
    return figure


def moments(ticks: Sequence[Tick]) -> list[int]:
    """Return which ticks to show: the first way, a while after a device or else a posture changed, passing, the end."""
    shift = round(AFTER / (ticks[1].truth.time - ticks[0].truth.time))
    passing = _passing(ticks)
    changed = next(
        (index for index in (_first_change(ticks, _devices_on), _first_change(ticks, _postures)) if index), 0
    )
    return [min(shift, passing), min(changed + shift, passing), passing, len(ticks) - 1]


def _first_change(ticks: Sequence[Tick], state: Callable[[Tick], object]) -> int:
    """Return the first tick whose state is not that of the first one; 0 where there is none."""
    first = state(ticks[0])
    return next((index for index, tick in enumerate(ticks) if state(tick) != first), 0)


def _devices_on(tick: Tick) -> object:
    return tick.truth.devices_on


def _postures(tick: Tick) -> object:
    return tuple(person.posture for person in tick.truth.people)


def _passing(ticks: Sequence[Tick]) -> int:
    """Return the first tick in which the robot is level with a walker whom it comes from behind; else the middle."""
    behind: set[str] = set()
    for index, tick in enumerate(ticks):
        robot = tick.truth.pose_robot_in_world
        for person in tick.truth.people:
            forward, _ = person.pose_in_world.to_body(robot.position)
            near = robot.distance_to(person.pose_in_world.position) <= LEVEL_WITHIN
            if person.posture is not Posture.WALKING or not near:
                continue
            if forward < 0.0:
                behind.add(person.name)
            elif person.name in behind:
                return index
    return len(ticks) // 2


def _devices(tick: Tick, last: Tick) -> str:
    """Say of devices that go on during the run whether they are on."""
    states = zip(tick.truth.devices_on, last.truth.devices_on, strict=True)
    return "".join(f", {name} {'on' if on else 'off'}" for (name, on), (_, ends_on) in states if ends_on)


def _watched(last: Tick) -> list[Patch]:
    """Explain the discs between viewers and devices that are on in the end, in the colour of their cost."""
    names = [name for name, on in last.truth.devices_on if on]
    gamma = layer_parameters(InteractionLayer)["gamma"]
    words = f"disc: between viewer and {' or '.join(names)} while it is on"
    return [Patch(color=colormaps[COSTS](gamma), label=words)] if names else []


def _draw_moment(axes: Axes, world: World, tick: Tick, ticks: Sequence[Tick]) -> AxesImage:
    draw_floor_plan(axes, world, cameras=False, names=False)
    image = _draw_costs(axes, tick.decision.costmap)
    robot = tick.truth.pose_robot_in_world
    way = np.array([t.truth.pose_robot_in_world.position for t in ticks if t.truth.time <= tick.truth.time])
    axes.plot(*way.T, color=BLACK, linewidth=1.2, zorder=5, label="way so far")
    if tick.decision.path is not None:
        axes.plot(*tick.decision.path.points_in_world.T, color=ROBOT, linewidth=1.8, zorder=5, label="planned path")
    for person in tick.truth.people:
        _draw_body(axes, person.pose_in_world, PERSON_RADIUS, "white")
        x, y = person.pose_in_world.position
        label = axes.text(x, y + ABOVE_BODY, person.name, ha="center", fontsize=7.5, color=BLACK, zorder=5.5)
        label.set_path_effects([withStroke(linewidth=2.0, foreground="white")])
    _draw_body(axes, robot, world.robot.radius, SKY)
    return image


def _draw_costs(axes: Axes, costmap: Costmap) -> AxesImage:
    """Draw what people and devices alone cost."""
    social = np.where(costmap.cost > costmap.building, costmap.cost, 0) / SOCIAL_MAX
    height, width = np.array(costmap.shape) * costmap.resolution
    left, bottom = costmap.origin_in_world
    return axes.imshow(
        np.where(social > 0.0, np.minimum(social, 1.0), np.nan),
        cmap=COSTS,
        vmin=0.0,
        vmax=1.0,
        origin="lower",
        extent=(left, left + width, bottom, bottom + height),
        zorder=0.5,
        interpolation="nearest",
    )


def _draw_body(axes: Axes, pose: Pose2D, radius: float, colour: str) -> None:
    axes.add_patch(Circle((pose.x, pose.y), radius, facecolor=colour, edgecolor=BLACK, linewidth=1.0, zorder=6))
    nose = pose.to_world(np.array([[0.3 * radius, 0.0], [radius, 0.0]]))
    axes.plot(*nose.T, color=BLACK, linewidth=1.2, zorder=7)


def _limits(world: World, ticks: Sequence[Tick]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return from where to where along x and y something happens [m]."""
    low, high = extent(world)
    points: list[Array] = [tick.truth.pose_robot_in_world.position for tick in ticks]
    points += [person.pose_in_world.position for tick in (ticks[0], ticks[-1]) for person in tick.truth.people]
    x, y = np.array(points).T
    lower, upper = (low[1], high[1]) if y.max() > CORRIDOR or y.min() < -CORRIDOR else (-CORRIDOR, CORRIDOR)
    return (max(low[0], x.min() - 1.2), min(high[0], x.max() + 1.2)), (float(lower), float(upper))
