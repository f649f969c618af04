"""Costmaps to plan on: walls and pillars, inflated, and people, by the project's own layers."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label

from han_bullet.costmap.grid import INSCRIBED, LETHAL, Costmap
from han_bullet.costmap.layers import standard_layers
from han_bullet.geometry import Array, SolidBox
from han_bullet.messages import Posture, Scene, TrackedPerson

RESOLUTION = 0.05  # [m]
ROBOT_RADIUS = 0.28  # [m]
SHARE_OF_WALLS = {"light": 0.02, "heavy": 0.12}  # cells that obstacles cover, before inflation
AREA_PER_PERSON = {"light": 100.0, "heavy": 25.0}  # [m^2]


@dataclass(frozen=True)
class Problem:
    """A map and the ends of ways on it.

    Attributes:
        size: Cells along a side.
        clutter: "light" or "heavy".
        costmap: All layers applied.
        ends: Start and goal of each search, shape (n, 2, 2) [m]; first from corner to corner, then at random.
    """

    size: int
    clutter: str
    costmap: Costmap
    ends: Array


def problem(size: int, clutter: str, pairs: int, seed: int = 0) -> Problem:
    """Return a map of some clutter with its ways from corner to corner and between random places."""
    generator = np.random.default_rng([seed, size, len(clutter)])
    side = size * RESOLUTION
    costmap = Costmap.covering([((0.0, side), (0.0, side))], RESOLUTION)
    boxes = _obstacles(costmap, SHARE_OF_WALLS[clutter], generator)
    people = _people(side, max(round(side**2 / AREA_PER_PERSON[clutter]), 2), generator)
    for layer in standard_layers(boxes, robot_radius=ROBOT_RADIUS):
        layer.apply(costmap, Scene(0.0, people))
    places = _connected_places(costmap)
    corners = [places[np.hypot(*(places - corner).T).argmin()] for corner in ((0.0, 0.0), (side, side))]
    drawn = places[generator.integers(0, len(places), (pairs, 2))]
    return Problem(size, clutter, costmap, np.concatenate([[corners], drawn]))


def _obstacles(costmap: Costmap, share: float, generator: np.random.Generator) -> list[SolidBox]:
    """Return boxes, and draw pillars, until both have covered their half of a share of the map's cells."""
    side, area, boxes = len(costmap.cost) * costmap.resolution, 0.0, list[SolidBox]()
    while area < 0.5 * share * side**2:
        length, width = generator.uniform(0.5, 3.0), generator.uniform(0.15, 0.6)
        centre = np.array([*generator.uniform(0.0, side, 2), 0.5])
        yaw = generator.uniform(0.0, np.pi)
        boxes.append(SolidBox(f"box{len(boxes)}", "object", centre, np.array([length, width, 1.0]), yaw))
        area += length * width
    while area < share * side**2:
        radius, centre = generator.uniform(0.15, 0.5), generator.uniform(0.0, side, 2)
        window, x, y = costmap.centres_in_window(centre, radius)
        costmap.building[window][np.hypot(x - centre[0], y - centre[1]) <= radius] = LETHAL
        area += np.pi * radius**2
    np.maximum(costmap.cost, costmap.building, out=costmap.cost)
    return boxes


def _people(side: float, count: int, generator: np.random.Generator) -> tuple[TrackedPerson, ...]:
    """Return people, standing and walking in turn."""
    people = []
    for index in range(count):
        heading = generator.uniform(-np.pi, np.pi)
        posture = Posture.WALKING if index % 2 else Posture.STANDING
        velocity = np.array([np.cos(heading), np.sin(heading)]) if posture is Posture.WALKING else np.zeros(2)
        place = generator.uniform(0.0, side, 2)
        people.append(TrackedPerson(index, 0.0, place, velocity, 1e-3 * np.eye(4), posture, heading))
    return tuple(people)


def _connected_places(costmap: Costmap) -> Array:
    """Return the centres, (n, 2) [m], of the largest part of the map in which a way leads from each to each.

    Parts are joined over edges of cells alone: a diagonal that passes no blocked corner has a way round it.
    """
    parts, _ = label(costmap.cost < INSCRIBED)
    largest = np.bincount(parts[parts > 0]).argmax()
    return costmap.cell_to_world(np.argwhere(parts == largest))
