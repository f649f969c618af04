"""The costs around people as surfaces and as maps, from the layers that the robot uses [Mateus2019]."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D

from han_bullet.costmap.grid import SOCIAL_MAX, Costmap
from han_bullet.costmap.layer import Layer
from han_bullet.costmap.overtake import OvertakeLayer
from han_bullet.costmap.personal_still import PersonalStillLayer
from han_bullet.costmap.personal_walking import PersonalWalkingLayer
from han_bullet.costmap.visibility import VisibilityLayer
from han_bullet.geometry import Array
from han_bullet.messages import HandOver, Posture, Scene, TrackedPerson
from han_bullet.report.charts import BLACK, COSTS

REACH = 3.0  # [m] around the person that is drawn
RESOLUTION = 0.05  # [m], as the robot's costmap
CONTOURS = (0.1, 0.25, 0.5, 0.75)
CONTOUR_COLOURS = (BLACK, BLACK, "white", "white")  # dark on pale, pale on dark
WALKING_SPEED = 1.0  # [m/s], as in the paper's figure
UP = 0.5 * math.pi  # [rad]: which way everybody faces


@dataclass(frozen=True)
class Case:
    """A person with the layers that count for them.

    Attributes:
        title: Of the panel.
        posture: Of the person.
        layers: Applied in this order.
        hands_over: Whether an object is handed over.
    """

    title: str
    posture: Posture
    layers: Sequence[Layer]
    hands_over: bool = False

    def scene(self) -> Scene:
        """Return a scene with this person in its middle."""
        speed = WALKING_SPEED if self.posture is Posture.WALKING else 0.0
        velocity = speed * np.array([math.cos(UP), math.sin(UP)])
        person = TrackedPerson(0, 0.0, np.zeros(2), velocity, 1e-6 * np.eye(4), self.posture, UP)
        task = HandOver(np.zeros(2), person=0, heading=UP) if self.hands_over else None
        return Scene(0.0, (person,), task=task)


def cases() -> list[Case]:
    """Return what the paper's figure shows, and a person who stands."""
    return [
        Case("standing ($g_2$)", Posture.STANDING, [PersonalStillLayer()]),
        Case("hand-over", Posture.STANDING, [PersonalStillLayer()], hands_over=True),
        Case("seated ($g_6$)", Posture.SEATED, [PersonalStillLayer(), VisibilityLayer()]),
        Case("walking ($g_1$)", Posture.WALKING, [PersonalWalkingLayer()]),
        Case("walking, overtaken ($g_7$)", Posture.WALKING, [PersonalWalkingLayer(), OvertakeLayer()]),
    ]


def costs_around(case: Case) -> tuple[Array, Array, Array]:
    """Return the costs of a case: x and y of the cells' centres [m], and g in [0, 1], each shape (rows, columns)."""
    costmap = Costmap.covering([((-REACH, REACH), (-REACH, REACH))], RESOLUTION)
    for layer in case.layers:
        layer.apply(costmap, case.scene())
    rows, columns = np.indices(costmap.shape)
    centres = costmap.cell_to_world(np.stack([rows, columns], axis=-1))
    return centres[..., 0], centres[..., 1], costmap.cost / SOCIAL_MAX


def draw_costs() -> Figure:
    """Draw every case as a surface above and as a map with contours below."""
    found = cases()
    figure = Figure(figsize=(11.0, 4.5), layout="constrained")
    grid = figure.add_gridspec(2, len(found), height_ratios=(1.15, 1.0))
    maps = []
    for index, case in enumerate(found):
        x, y, g = costs_around(case)
        surface = figure.add_subplot(grid[0, index], projection="3d")
        _draw_surface(surface, x, y, g)
        surface.set_title(f"({'abcde'[index]}) {case.title}", loc="center", pad=0.0)
        axes = figure.add_subplot(grid[1, index])
        image = _draw_map(axes, x, y, g)
        axes.set(xlabel="x [m]", ylabel="y [m]" if index == 0 else "")
        maps.append(axes)
    figure.colorbar(image, ax=maps, label="cost g", pad=0.01, aspect=20)
    return figure


def _draw_surface(axes: Axes3D, x: Array, y: Array, g: Array) -> None:
    axes.plot_surface(x, y, g, cmap=COSTS, vmin=0.0, vmax=1.0, rcount=80, ccount=80, rasterized=True, linewidth=0)
    axes.set(zlim=(0.0, 1.0), xticks=(-2, 0, 2), yticks=(-2, 0, 2), zticks=(0, 0.5, 1))
    axes.set_xlabel("x [m]", labelpad=-9.0, fontsize=7)
    axes.set_ylabel("y [m]", labelpad=-9.0, fontsize=7)
    axes.tick_params(labelsize=7, pad=-3)
    axes.view_init(elev=38.0, azim=-30.0)
    axes.set_box_aspect((1.0, 1.0, 0.55), zoom=1.08)


def _draw_map(axes: Axes, x: Array, y: Array, g: Array) -> QuadMesh:
    image = axes.pcolormesh(x, y, g, cmap=COSTS, vmin=0.0, vmax=1.0, rasterized=True, shading="nearest")
    lines = axes.contour(x, y, g, levels=CONTOURS, colors=CONTOUR_COLOURS, linewidths=0.8)
    axes.clabel(lines, fmt="%g", fontsize=6.5)
    tip = (0.45 * math.cos(UP), 0.45 * math.sin(UP))
    arrow = {"arrowstyle": "-|>", "color": "white", "linewidth": 1.2, "shrinkA": 0.0, "shrinkB": 0.0}
    axes.annotate("", tip, (0.0, 0.0), arrowprops=arrow)
    axes.plot(0.0, 0.0, "o", color="white", markeredgecolor=BLACK, markersize=4)
    axes.set(aspect="equal", xticks=(-2, 0, 2), yticks=(-2, 0, 2))
    return image
