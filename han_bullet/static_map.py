"""A world without its people: walls, all furniture that stays, on the robot's map or not, and the inflation around."""

from __future__ import annotations

from han_bullet.costmap.grid import Costmap
from han_bullet.costmap.layers import standard_layers
from han_bullet.messages import Scene
from han_bullet.world_schema import World


def static_costmap(world: World) -> Costmap:
    """Return the map with walls, furniture and inflation only."""
    costmap = Costmap.covering([(area.x, area.y) for area in world.floor], world.costmap.resolution)
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
