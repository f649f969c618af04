"""A costmap as a stream: the whole grid where somebody needs it, else the window that has changed."""

from __future__ import annotations

import math

from han_bullet.costmap.grid import Costmap
from han_bullet.ros.occupancy import Cells, changed_window, grid_message, occupancy, update_message
from han_bullet.ros.topics import COSTMAP, COSTMAP_UPDATES, Outgoing

WHOLE_EVERY = 5.0  # [s]: a link that drops messages may lose a window; so long a subscriber then shows old cells


class CostmapStream:
    """What those who listen to a costmap know of it, and what to tell them next.

    Like costmap_2d's publisher, it sends the whole grid to whom is new and when the grid's size or place changes, and
    windows else; besides, the whole grid every `WHOLE_EVERY` seconds, since a window can get lost, and instead of a
    window where nobody listens to windows.
    """

    def __init__(self) -> None:
        self._known: Cells | None = None
        self._place: tuple[float, ...] = ()
        self._whole_at = -math.inf  # [s]

    def forget(self) -> None:
        """Take it that somebody knows nothing yet: the next message is a whole grid."""
        self._known = None

    def next(self, costmap: Costmap, time: float, *, windows: bool) -> Outgoing | None:
        """Return a whole grid or a window, on its topic; None where nothing has changed.

        Args:
            costmap: Of this moment.
            time: [s].
            windows: Whether somebody listens to windows.
        """
        cells = occupancy(costmap.cost)
        place = (*costmap.shape, *costmap.origin_in_world.tolist(), costmap.resolution)
        known, self._known = self._known, cells
        window = None
        if known is not None and place == self._place and 0.0 <= time - self._whole_at < WHOLE_EVERY:
            window = changed_window(known, cells)
            if window is None:
                return None
        if window is not None and windows:
            return Outgoing(COSTMAP_UPDATES, update_message(cells, window, time))
        self._place, self._whole_at = place, time
        return Outgoing(COSTMAP, grid_message(cells, costmap.origin_in_world, costmap.resolution, time))
