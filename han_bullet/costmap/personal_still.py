"""Personal space of people who stand or sit (g2), with the opening for a hand-over."""

from __future__ import annotations

import math

import numpy as np

from han_bullet.costmap.grid import Costmap, social_cost
from han_bullet.costmap.layer import Layer, check_amplitude
from han_bullet.costmap.shapes import REACH, raise_asym_gauss
from han_bullet.errors import check_positive
from han_bullet.geometry import Array
from han_bullet.messages import HandOver, Posture, Scene, TrackedPerson


class PersonalStillLayer(Layer):
    """g2, a round Gaussian; for the person of the current hand-over it is 0 inside a sector in front of them."""

    name = "personal_still"

    def __init__(
        self,
        *,
        deviation: float = 0.56,
        opening_angle: float = math.radians(45.0),
        opening_from: float = 0.6,
        amplitude: float = 1.0,
    ) -> None:
        """Configure the shape.

        Args:
            deviation: Of the Gaussian [m]; 0.56 falls to 0.1 at 1.2 m, the edge of the personal distance [Hall1966].
            opening_angle: Of the whole sector [rad].
            opening_from: Distance from the person at which the sector begins [m].
            amplitude: What the Gaussian is multiplied with, in [0, 1].
        """
        check_positive(
            f"layer {self.name}", deviation=deviation, opening_angle=opening_angle, opening_from=opening_from
        )
        check_amplitude(self.name, amplitude)
        self.deviation = deviation
        self.opening_angle = opening_angle
        self.opening_from = opening_from
        self.amplitude = amplitude

    def apply(self, costmap: Costmap, scene: Scene) -> None:
        """Raise the space around standing and seated people."""
        for person in scene.people:
            if person.posture is Posture.WALKING:
                continue
            heading = _opening_heading(person, scene)
            if heading is not None:
                self._raise_with_opening(costmap, person.position_in_world, heading)
            else:
                shape = (self.deviation, self.deviation, self.deviation, self.amplitude)
                raise_asym_gauss(costmap, person.position_in_world, 0.0, *shape)

    def _raise_with_opening(self, costmap: Costmap, position_in_world: Array, heading: float) -> None:
        window, x, y = costmap.centres_in_window(position_in_world, REACH * self.deviation)
        dx, dy = x - position_in_world[0], y - position_in_world[1]
        distance = np.hypot(dx, dy)
        ahead = dx * math.cos(heading) + dy * math.sin(heading)
        opening = (distance >= self.opening_from) & (ahead >= distance * math.cos(0.5 * self.opening_angle))
        g = self.amplitude * np.exp(-0.5 * (distance / self.deviation) ** 2)
        costmap.raise_to(window, social_cost(np.where(opening, 0.0, g)))


def _opening_heading(person: TrackedPerson, scene: Scene) -> float | None:
    """Return the direction [rad] of a person's hand-over opening, or None where there is none."""
    if isinstance(scene.task, HandOver) and scene.task.person == person.id:
        return scene.task.heading
    return None
