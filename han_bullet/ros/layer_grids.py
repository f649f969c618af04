"""What each costmap layer adds to those before it, noted while it works, so that none is applied twice.

To apply a layer to an empty map instead would show it alone, but a layer may have a memory, such as of the scans it has
seen, which a second call would change, and the run with it.
"""

from __future__ import annotations

import numpy as np

from han_bullet.costmap.grid import FREE, UNKNOWN, Costmap, Costs
from han_bullet.costmap.layer import Layer
from han_bullet.messages import Scene


class WatchedLayer(Layer):
    """A layer that does what another does, and notes what that adds while somebody wants to know.

    The cellwise maximum of what all layers add is the costmap.

    Attributes:
        name: The other's.
        wanted: Whether to note it.
        added: At the last time, shape (rows, columns), uint8: the cost of each cell that the layer raised beyond the
            layers before it, FREE elsewhere, UNKNOWN where there is no floor; None where it was not wanted.
    """

    def __init__(self, layer: Layer) -> None:
        self.name = layer.name  # type: ignore[misc]  # a watched layer has the name of what it watches
        self.wanted = False
        self.added: Costs | None = None
        self._layer = layer

    def apply(self, costmap: Costmap, scene: Scene) -> None:
        """Let the layer raise the map's costs, and note where it does."""
        before = costmap.cost.copy() if self.wanted else None
        self._layer.apply(costmap, scene)
        self.added = None
        if before is not None:
            changed = (costmap.cost != before) | (costmap.cost == UNKNOWN)
            self.added = np.where(changed, costmap.cost, np.uint8(FREE))
