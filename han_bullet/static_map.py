"""A world without its people: as a costmap with all furniture that stays, and as the map that the robot has."""

from __future__ import annotations

from han_bullet.costmap.grid import Costmap
from han_bullet.costmap.layers import standard_layers
from han_bullet.localization.occupancy_grid import OccupancyGrid
from han_bullet.messages import Scene
from han_bullet.wall_faces import with_doors
from han_bullet.world_schema import Laser, World


def static_costmap(world: World) -> Costmap:
    """Return the map with walls, furniture and inflation only."""
    costmap = Costmap.covering(world.floor_intervals(), world.costmap.resolution)
    for layer in standard_layers(
        world.lasting_boxes(),
        robot_radius=world.robot.radius,
        inflation_radius=world.costmap.inflation_radius,
        cost_scaling_factor=world.costmap.cost_scaling_factor,
        parameters=world.layers,
    ):
        if layer.name in {"static", "inflation"}:
            layer.apply(costmap, Scene(0.0))
    return costmap


def building_map(world: World) -> OccupancyGrid:
    """Return the robot's map: what its scanner, or one at the usual height, sees of the building it knows."""
    laser = world.robot.laser or Laser()
    boxes = with_doors(world.solid_boxes(), world.floor)
    return OccupancyGrid.of_building(world.floor_intervals(), boxes, scan_height=laser.height)
