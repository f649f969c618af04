"""Values that the paper leaves open and we chose, by name, so that a sweep can tell how much hangs on each.

Only those that act beyond detector and tracker: what these assume is not in the loop with true perception.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from han_bullet.costmap.layers import STANDARD, layer_parameters
from han_bullet.errors import BadInputError
from han_bullet.world_schema import World

JOINT = re.compile(r"\+(?!\d)")  # between the words of a variant; that of a factor like 1e+06 is none
ASTAR_WEIGHT = "costmap.astar_weight"
# Parameters of layers as LAYER.PARAMETER, with the largest value that means something.
ASSUMPTIONS: dict[str, float] = {
    "personal_still.deviation": math.inf,
    "personal_still.opening_angle": 2.0 * math.pi,
    "personal_still.opening_from": math.inf,
    "interaction.gamma": 1.0,
    "oncoming.horizon": math.inf,
    "oncoming.side": math.inf,
    ASTAR_WEIGHT: math.inf,
}


@dataclass(frozen=True)
class Scaled:
    """An assumption that a run makes otherwise.

    Attributes:
        name: One of `ASSUMPTIONS`.
        factor: Of the world's own value, > 0.
    """

    name: str
    factor: float

    def __post_init__(self) -> None:
        """Check both."""
        if self.name not in ASSUMPTIONS:
            raise BadInputError(f"{self.name!r} is no assumption; there are {', '.join(ASSUMPTIONS)}")
        if not (math.isfinite(self.factor) and self.factor > 0.0):
            raise BadInputError(f"{self.name} is scaled by {self.factor}; a finite factor above 0 would be right")

    def __str__(self) -> str:
        """Return `NAME*FACTOR`."""
        return f"{self.name}*{self.factor:g}"

    def apply(self, world: World) -> World:
        """Return a world whose value is the factor times that of the given one, or the largest possible."""
        if self.name == ASTAR_WEIGHT:
            weight = world.costmap.astar_weight * self.factor
            return world.model_copy(update={"costmap": world.costmap.model_copy(update={"astar_weight": weight})})
        layer, parameter = self.name.split(".")
        (defaults,) = (layer_parameters(one) for one in STANDARD if one.name == layer)
        own = world.layers.get(layer, {})
        value = min(own.get(parameter, defaults[parameter]) * self.factor, ASSUMPTIONS[self.name])
        return world.model_copy(update={"layers": {**world.layers, layer: {**own, parameter: value}}})
