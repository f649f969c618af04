"""The space behind people who sit (g3)."""

from __future__ import annotations

import math

from han_bullet.costmap.grid import Costmap
from han_bullet.costmap.layer import Layer, check_amplitude, seat_of
from han_bullet.costmap.shapes import raise_asym_gauss
from han_bullet.errors import check_positive
from han_bullet.messages import Posture, Scene, TrackedPerson


class VisibilityLayer(Layer):
    """g3 = asymGauss(heading - pi; 1.2, 0.8, 0.006): passing unseen behind a seated person is uncomfortable."""

    name = "visibility"

    def __init__(self, *, behind: float = 1.2, side: float = 0.8, front: float = 0.006, amplitude: float = 1.0) -> None:
        """Configure the standard deviations [m] behind, beside and before the person, and a factor in [0, 1]."""
        check_positive(f"layer {self.name}", behind=behind, side=side, front=front)
        check_amplitude(self.name, amplitude)
        self.behind = behind
        self.side = side
        self.front = front
        self.amplitude = amplitude

    def apply(self, costmap: Costmap, scene: Scene) -> None:
        """Raise the space behind seated people; without any known facing there is no behind."""
        for person in scene.people:
            facing = _facing(person, scene)
            if person.posture is Posture.SEATED and facing is not None:
                shape = (self.behind, self.side, self.front, self.amplitude)
                raise_asym_gauss(costmap, person.position_in_world, facing - math.pi, *shape)


def _facing(person: TrackedPerson, scene: Scene) -> float | None:
    if person.heading is not None:
        return person.heading
    seat = seat_of(person, scene)
    return None if seat is None else seat.facing
