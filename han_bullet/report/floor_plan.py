"""The building as a drawing below the ways of robot and people."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon, Rectangle

from han_bullet.geometry import SolidBox
from han_bullet.report.charts import GREY, VERMILION
from han_bullet.topdown import CAMERA_WEDGE, camera_wedge, extent, footprint, plan_colours
from han_bullet.world_schema import CeilingCamera, World

GOAL = VERMILION


def draw_floor_plan(axes: Axes, world: World, *, cameras: bool = True, names: bool = True) -> None:
    """Draw walls, furniture, devices, ceiling cameras with their width of view, and the goal.

    Args:
        axes: Get the limits of the building and equal scales.
        world: What is drawn.
        cameras: Whether cameras are.
        names: Whether names stand beside cameras and furniture.
    """
    for area in world.floor:
        corner, size = (area.x[0], area.y[0]), (area.x[1] - area.x[0], area.y[1] - area.y[0])
        axes.add_patch(Rectangle(corner, *size, color="#fbfbf8", zorder=0, linewidth=0))
    for box in world.all_boxes():
        fill, rim = map(_share, plan_colours(box, world))
        axes.add_patch(Polygon(footprint(box), facecolor=fill, edgecolor=rim, linewidth=0.5, zorder=1))
        if names and box.kind != "wall":
            _write_name(axes, box)
    if cameras:
        for camera in world.cameras:
            if isinstance(camera, CeilingCamera):
                _draw_camera(axes, camera, names)
    _draw_goal(axes, world)
    low, high = extent(world)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")


def _write_name(axes: Axes, box: SolidBox) -> None:
    """Write the name of a piece of furniture or a device at its upper left corner."""
    corners = footprint(box)
    corner = (corners[:, 0].min(), corners[:, 1].max())
    axes.annotate(
        box.name, corner, (0, 2), textcoords="offset points", va="bottom", fontsize=6.5, color=GREY, zorder=1.5
    )


def _share(colour: tuple[int, int, int]) -> tuple[float, float, float]:
    red, green, blue = colour
    return red / 255.0, green / 255.0, blue / 255.0


def _draw_camera(axes: Axes, camera: CeilingCamera, named: bool) -> None:
    wedge = camera_wedge(camera, 1.4 * CAMERA_WEDGE)
    axes.add_patch(Polygon(wedge, facecolor="none", edgecolor=GREY, linewidth=0.8, zorder=1.5))
    axes.plot(*wedge[0], "o", color=GREY, markersize=3.0, zorder=1.5)
    if named:
        x, y = wedge.mean(axis=0)
        low, high = wedge[:, 1].min(), wedge[:, 1].max()
        spot = (x, low - 0.08) if high - low < 1.2 else (x, y)
        axes.text(*spot, camera.name, ha="center", va="top", fontsize=6.5, color=GREY, zorder=1.5)


def _draw_goal(axes: Axes, world: World) -> None:
    """Draw a ring as large as the robot."""
    place, radius = world.task.place, world.robot.radius
    axes.add_patch(Circle(place, radius, facecolor="none", edgecolor=GOAL, linestyle="--", linewidth=1.0, zorder=2))
    axes.plot(*place, "+", color=GOAL, markersize=5.0, zorder=2)
