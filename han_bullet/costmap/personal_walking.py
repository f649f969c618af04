"""Personal space of people who walk (g1)."""

from __future__ import annotations

from han_bullet.costmap.grid import Costmap
from han_bullet.costmap.layer import Layer, check_amplitude, walking_direction
from han_bullet.costmap.shapes import raise_asym_gauss
from han_bullet.errors import check_positive
from han_bullet.messages import Posture, Scene


class PersonalWalkingLayer(Layer):
    """g1 = asymGauss(heading; B, 2 B / 3, B / 2) with B = max(speed, 0.8), [Kirby2010]: longest ahead."""

    name = "personal_walking"

    def __init__(
        self, *, smallest: float = 0.8, side: float = 2.0 / 3.0, rear: float = 0.5, amplitude: float = 1.0
    ) -> None:
        """Configure the shape.

        Args:
            smallest: Least B; B itself is the speed's number taken as metres [m].
            side: Deviation to either side, as a part of B.
            rear: Deviation behind, as a part of B.
            amplitude: What the Gaussian is multiplied with, in [0, 1].
        """
        check_positive(f"layer {self.name}", smallest=smallest, side=side, rear=rear)
        check_amplitude(self.name, amplitude)
        self.smallest = smallest
        self.side = side
        self.rear = rear
        self.amplitude = amplitude

    def apply(self, costmap: Costmap, scene: Scene) -> None:
        """Raise the space around walking people."""
        for person in scene.people:
            if person.posture is Posture.WALKING:
                ahead = max(person.speed, self.smallest)
                shape = (ahead, self.side * ahead, self.rear * ahead, self.amplitude)
                raise_asym_gauss(costmap, person.position_in_world, walking_direction(person), *shape)
