"""How far the way gives way to each social layer as the layer's amplitude grows from 0 to 1.

Usage: python -m benchmarks.path_follows_cost [--out runs/path_follows_cost.png]

One scene per layer, with nothing else on the map but walls, furniture and bodies, which block and cost nothing beside.
The planner takes the way with the least length + weight * amplitude * exposure, exposure being the integral of the
layer's cost at amplitude 1 along the way. For such a sum it is a law that with a growing amplitude the length never
falls and the exposure never rises, but for the rounding of costs to whole numbers of 252.
"""

import argparse
import io
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path as File

import numpy as np

from benchmarks.provenance import provenance
from han_bullet.atomic_file import write_at_once
from han_bullet.costmap.body import BodyLayer
from han_bullet.costmap.grid import SOCIAL_MAX, Costmap
from han_bullet.costmap.inflation import InflationLayer
from han_bullet.costmap.interaction import InteractionLayer
from han_bullet.costmap.layer import Layer
from han_bullet.costmap.oncoming import OncomingLayer
from han_bullet.costmap.overtake import OvertakeLayer
from han_bullet.costmap.personal_still import PersonalStillLayer
from han_bullet.costmap.personal_walking import PersonalWalkingLayer
from han_bullet.costmap.static import StaticLayer
from han_bullet.costmap.visibility import VisibilityLayer
from han_bullet.geometry import Array, Pose2D, SolidBox
from han_bullet.markdown import markdown_table
from han_bullet.messages import Device, GoTo, Path, Posture, Scene, Seat, TrackedPerson
from han_bullet.planning.astar import AStar

AMPLITUDES = (0.0, 0.25, 0.5, 0.75, 1.0)
WEIGHT = 10.0
RADIUS = 0.3  # of the robot [m]
RESOLUTION = 0.05  # [m]
ROOM = ((0.0, 7.0), (0.0, 7.0))  # [m], as the living room
CORRIDOR = ((0.0, 10.0), (-1.5, 1.5))
COUCH = Seat("couch", np.array([3.5, 3.1]), -0.5 * math.pi, 0.8, 1.9, "tv")
COUCH_BOX = SolidBox("couch", "object", np.array([3.5, 3.1, 0.4]), np.array([0.8, 1.9, 0.8]), -0.5 * math.pi)
TELEVISION = Device("tv", np.array([3.5, 0.1]), on=True)


@dataclass(frozen=True)
class Case:
    """A scene for one layer.

    Attributes:
        layer: Takes an amplitude.
        floor: x and y interval [m].
        boxes: Furniture.
        person: Who the layer is about.
        start, goal: Of the robot, (x, y) [m].
    """

    layer: Callable[..., Layer]
    floor: tuple[tuple[float, float], tuple[float, float]]
    boxes: tuple[SolidBox, ...]
    person: TrackedPerson
    start: tuple[float, float]
    goal: tuple[float, float]

    @property
    def scene(self) -> Scene:
        """Return what the layers look at."""
        task = GoTo(Pose2D(*self.goal, 0.0))
        return Scene(0.0, (self.person,), (TELEVISION,), (COUCH,), task, Pose2D(*self.start, 0.0))


def _person(posture: Posture, at: tuple[float, float], speed: float = 0.0, heading: float = 0.0) -> TrackedPerson:
    velocity = speed * np.array([math.cos(heading), math.sin(heading)])
    seat = "couch" if posture is Posture.SEATED else None
    return TrackedPerson(0, 0.0, np.array(at), velocity, 1e-6 * np.eye(4), posture, heading, seat)


_WALKER, _SEATED = _person(Posture.WALKING, (5.0, -0.3), 0.4), _person(Posture.SEATED, (3.5, 3.1), 0.0, -0.5 * math.pi)
_CORRIDOR_WAY = ((1.0, -0.3), (9.0, -0.3))
CASES = {
    "personal_walking": Case(PersonalWalkingLayer, CORRIDOR, (), _WALKER, *_CORRIDOR_WAY),
    "personal_still": Case(PersonalStillLayer, CORRIDOR, (), _person(Posture.STANDING, (5.0, -0.3)), *_CORRIDOR_WAY),
    "visibility": Case(VisibilityLayer, ROOM, (COUCH_BOX,), _SEATED, (0.5, 4.3), (6.5, 4.3)),
    "interaction": Case(InteractionLayer, ROOM, (COUCH_BOX,), _SEATED, (0.5, 1.6), (6.5, 1.6)),
    # The way without the layer passes on the person's right.
    "overtake": Case(OvertakeLayer, CORRIDOR, (), _person(Posture.WALKING, (5.0, 0.0), 0.4), (1.0, -0.7), (9.0, -0.7)),
    "oncoming": Case(
        partial(OncomingLayer, robot_speed=1.0),
        CORRIDOR,
        (),
        _person(Posture.WALKING, (7.0, -0.8), 0.7, math.pi),
        (0.6, -0.8),
        (9.4, -0.8),
    ),
}


def blocked_map(case: Case) -> Costmap:
    """Return a map on which walls, furniture and the person's body block, and everything else costs nothing."""
    costmap = Costmap.covering([case.floor], RESOLUTION)
    hard = InflationLayer(robot_radius=RADIUS, inflation_radius=RADIUS)
    for layer in (StaticLayer(case.boxes), hard, BodyLayer(robot_radius=RADIUS)):
        layer.apply(costmap, case.scene)
    return costmap


def best_way(case: Case, amplitude: float) -> Path:
    """Return the cheapest way with the layer at an amplitude."""
    costmap = blocked_map(case)
    case.layer(amplitude=amplitude).apply(costmap, case.scene)
    way = AStar(weight=WEIGHT).search(costmap, np.array(case.start), np.array(case.goal))
    assert way is not None, "every case leaves a way open"
    return way


def length(points: Array) -> float:
    """Return the length of a way, shape (n, 2), [m]."""
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def exposure(points: Array, costs: Array) -> float:
    """Return the integral of costs in [0, 1] at a way's points, shape (n,), along it [m], as A* prices an edge."""
    return float((np.hypot(*np.diff(points, axis=0).T) * 0.5 * (costs[1:] + costs[:-1])).sum())


def exposure_to_layer(case: Case, points: Array) -> float:
    """Return a way's exposure to the layer at amplitude 1 [m]."""
    alone = Costmap.covering([case.floor], RESOLUTION)
    case.layer().apply(alone, case.scene)
    return exposure(points, alone.cost_at(points) / SOCIAL_MAX)


def row(name: str, ways: Sequence[Path]) -> list[object]:
    """Return a line: for each amplitude the detour against amplitude 0 and the exposure."""
    points = [way.points_in_world for way in ways]
    detours = [length(each) - length(points[0]) for each in points]
    return [name, *(f"{d:.2f} ({exposure_to_layer(CASES[name], p):.2f})" for d, p in zip(detours, points, strict=True))]


def draw(ways: dict[str, list[Path]], file: File) -> None:
    """Draw each layer's costs with its ways, one colour per amplitude."""
    from matplotlib import colormaps
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.0, 8.5), layout="constrained")
    for axes, (name, found) in zip(figure.subplots(2, 3).flat, ways.items(), strict=True):
        case = CASES[name]
        alone = Costmap.covering([case.floor], RESOLUTION)
        case.layer().apply(alone, case.scene)
        extent = (*case.floor[0], *case.floor[1])
        axes.imshow(alone.cost, origin="lower", extent=extent, cmap="Greys", vmax=400)
        axes.contour(blocked_map(case).cost > SOCIAL_MAX, [0.5], extent=extent, colors="0.6")
        for amplitude, way in zip(AMPLITUDES, found, strict=True):
            colour = colormaps["viridis"](0.9 * amplitude)
            axes.plot(*way.points_in_world.T, color=colour, label=f"{amplitude:g}", linewidth=2.0)
        axes.plot(*case.person.position_in_world, "o", color="tab:red")
        axes.set(title=name, xlabel="x [m]", ylabel="y [m]")
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, title="amplitude", loc="outside right center")
    figure.suptitle("Cheapest ways as a layer's amplitude grows, on its costs; grey lines: where the robot would touch")
    file.parent.mkdir(parents=True, exist_ok=True)
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=80)
    write_at_once(file, content.getvalue())


def main() -> None:
    """Print the table and draw the ways."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=File, default=File("runs/path_follows_cost.png"))
    options = parser.parse_args()
    ways = {name: [best_way(case, amplitude) for amplitude in AMPLITUDES] for name, case in CASES.items()}
    print("### The way follows the costs: detour [m] (exposure to the layer at amplitude 1 [m])\n")
    print(f"{provenance()}; weight {WEIGHT:g}, cells of {RESOLUTION:g} m\n")
    header = ("layer", *(f"amplitude {amplitude:g}" for amplitude in AMPLITUDES))
    print(markdown_table(header, [row(name, found) for name, found in ways.items()]))
    draw(ways, options.out)


if __name__ == "__main__":
    main()
