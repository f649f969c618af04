"""Walls and furniture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from han_bullet.costmap.grid import FREE, LETHAL, Costmap, Costs
from han_bullet.costmap.layer import Layer
from han_bullet.errors import check_positive
from han_bullet.geometry import SolidBox
from han_bullet.messages import Scene


class StaticLayer(Layer):
    """Make every cell LETHAL whose square a solid box touches, if the robot cannot drive under the box."""

    name = "static"

    def __init__(self, boxes: Sequence[SolidBox], *, robot_height: float = 1.2) -> None:
        """Take the building.

        Args:
            boxes: Walls, furniture, devices.
            robot_height: A box whose lower side is above it is no obstacle [m]; the camera is at 1.2.
        """
        check_positive(f"layer {self.name}", robot_height=robot_height)
        self.boxes = tuple(box for box in boxes if box.centre_in_world[2] - 0.5 * box.size[2] < robot_height)
        self._drawn: Costs | None = None
        self._drawn_on: tuple[float, ...] = ()

    def apply(self, costmap: Costmap, scene: Scene) -> None:
        """Raise the cells of the boxes, drawn once per grid."""
        grid = (*costmap.shape, *costmap.origin_in_world, costmap.resolution)
        if self._drawn is None or grid != self._drawn_on:
            self._drawn, self._drawn_on = self._draw(costmap), grid
        costmap.raise_building_to(self._drawn)

    def _draw(self, costmap: Costmap) -> Costs:
        drawn = np.full(costmap.shape, FREE, np.uint8)
        for box in self.boxes:
            window, x, y = costmap.centres_in_window(box.centre_in_world[:2], float(np.hypot(*box.size[:2])))
            drawn[window][box.touches_cells(x, y, costmap.resolution)] = LETHAL
        return drawn
