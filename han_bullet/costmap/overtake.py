"""The side on which a walking person is not overtaken (g5)."""

from __future__ import annotations

import math

from han_bullet.costmap.grid import Costmap
from han_bullet.costmap.layer import Layer, check_amplitude, walking_direction
from han_bullet.costmap.shapes import raise_asym_gauss
from han_bullet.errors import BadInputError, check_positive
from han_bullet.messages import Posture, Scene


class OvertakeLayer(Layer):
    """g5 = asymGauss(heading - pi/2; 1.5, 0.3, 0.0075): the person's right is closed, so the robot passes on the left.

    Where one passes on the right, the lobe lies on the person's left.
    """

    name = "overtake"

    def __init__(
        self,
        *,
        pass_side: str = "left",
        reach: float = 1.5,
        along: float = 0.3,
        open_side: float = 0.0075,
        amplitude: float = 1.0,
    ) -> None:
        """Configure the lobe.

        Args:
            pass_side: On which side of a person the robot passes, "left" or "right".
            reach: Standard deviation away from the person on the closed side [m].
            along: Standard deviation along the walk [m].
            open_side: Standard deviation on the open side [m].
            amplitude: What the lobe is multiplied with, in [0, 1].
        """
        if pass_side not in ("left", "right"):
            raise BadInputError(f"layer overtake: pass_side is {pass_side!r}; it must be 'left' or 'right'")
        check_positive(f"layer {self.name}", reach=reach, along=along, open_side=open_side)
        check_amplitude(self.name, amplitude)
        self.pass_side = pass_side
        self.reach = reach
        self.along = along
        self.open_side = open_side
        self.amplitude = amplitude

    def apply(self, costmap: Costmap, scene: Scene) -> None:
        """Raise the closed side of walking people."""
        turn = -0.5 * math.pi if self.pass_side == "left" else 0.5 * math.pi
        shape = (self.reach, self.along, self.open_side, self.amplitude)
        for person in scene.people:
            if person.posture is Posture.WALKING:
                raise_asym_gauss(costmap, person.position_in_world, walking_direction(person) + turn, *shape)
