"""What each layer adds to the costmap, noted without changing it."""

import math

import numpy as np
from ticks import track

from han_bullet.assembly import task_of
from han_bullet.costmap.grid import UNKNOWN, Costmap
from han_bullet.costmap.layers import standard_layers
from han_bullet.geometry import Pose2D
from han_bullet.messages import LaserScan, Scene
from han_bullet.ros.layer_grids import WatchedLayer
from han_bullet.world_file import load_world

WORLD = load_world("real3")
FREE_SPACE = Costmap.covering([(area.x, area.y) for area in WORLD.floor], 0.05)
ROBOT = Pose2D(2.0, 0.0, 0.0)


def scene(number: int) -> Scene:
    """The robot before a box that is not on the map, a walker and somebody who stands."""
    angles = np.radians(np.arange(-30, 31))
    scan = LaserScan(
        0.1 * number, 1.2 / np.cos(angles), math.radians(-30), math.radians(1), 0.05, 8.0, Pose2D(0.0, 0.0, 0.0)
    )
    people = (
        track(0, 6.0 - 0.1 * number, 0.3, velocity=(-1.0, 0.0), heading=math.pi, posture="walking"),
        track(1, 4.5, -0.5, heading=1.0),
    )
    return Scene(0.1 * number, people, (), WORLD.seats(), task_of(WORLD), ROBOT, scan)


def costmaps(*, watched: bool, ticks: int = 6) -> tuple[list[Costmap], list[WatchedLayer]]:
    layers = standard_layers(WORLD.solid_boxes(), robot_radius=0.3)
    watches = [WatchedLayer(layer) for layer in layers]
    maps = []
    for number in range(ticks):
        costmap = FREE_SPACE.copy()
        for layer, watch in zip(layers, watches, strict=True):
            watch.wanted = number % 2 == 1
            (watch if watched else layer).apply(costmap, scene(number))
        maps.append(costmap)
    return maps, watches


def test_watching_changes_no_cell_at_any_tick() -> None:
    for plain, watched in zip(costmaps(watched=False)[0], costmaps(watched=True)[0], strict=True):
        np.testing.assert_array_equal(watched.cost, plain.cost)
        np.testing.assert_array_equal(watched.building, plain.building)


def test_what_all_layers_add_is_the_costmap() -> None:
    maps, watches = costmaps(watched=True)
    added = {watch.name: watch.added for watch in watches}
    together = np.maximum.reduce([grid for grid in added.values() if grid is not None])
    np.testing.assert_array_equal(together, maps[-1].cost)
    for name in ("static", "obstacle", "inflation", "body", "personal_walking", "personal_still", "oncoming"):
        grid = added[name]
        assert grid is not None and ((grid > 0) & (grid < UNKNOWN)).any(), name


def test_where_there_is_no_floor_every_layer_says_unknown() -> None:
    assert (FREE_SPACE.cost == UNKNOWN).any()
    for watch in costmaps(watched=True)[1]:
        assert watch.added is not None
        np.testing.assert_array_equal(watch.added == UNKNOWN, FREE_SPACE.cost == UNKNOWN)


def test_what_nobody_wants_is_not_noted() -> None:
    assert all(watch.added is None for watch in costmaps(watched=True, ticks=5)[1])
