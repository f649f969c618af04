"""The space between a person and the device they watch (g4)."""

from __future__ import annotations

import numpy as np

from han_bullet.costmap.grid import Costmap, social_cost
from han_bullet.costmap.layer import Layer, check_amplitude, seat_of
from han_bullet.costmap.shapes import raise_disc
from han_bullet.errors import BadInputError
from han_bullet.messages import Device, Posture, Scene, TrackedPerson


class InteractionLayer(Layer):
    """g4 = gamma inside the disc midway between a seated person and the device that their seat watches, while on.

    The disc's radius is half their distance. [Mateus2019] prints the squared distance <= r; the disc needs r^2.
    """

    name = "interaction"

    def __init__(self, *, gamma: float = 0.9, amplitude: float = 1.0) -> None:
        """Configure the cost inside the disc, in (0, 1], and a factor in [0, 1].

        0.9 is never crossed from a planner weight of 5 on.
        """
        if not 0.0 < gamma <= 1.0:
            raise BadInputError(f"layer interaction: gamma is {gamma!r}; it must lie in (0, 1]")
        check_amplitude(self.name, amplitude)
        self.gamma = gamma
        self.amplitude = amplitude

    def apply(self, costmap: Costmap, scene: Scene) -> None:
        """Raise the disc of every seated person whose device is on."""
        for person in scene.people:
            device = _watched(person, scene)
            if device is None or not device.on:
                continue
            middle = 0.5 * (person.position_in_world + device.position_in_world)
            radius = 0.5 * float(np.hypot(*(device.position_in_world - person.position_in_world)))
            raise_disc(costmap, middle, radius, int(social_cost(np.array(self.amplitude * self.gamma))))


def _watched(person: TrackedPerson, scene: Scene) -> Device | None:
    seat = seat_of(person, scene) if person.posture is Posture.SEATED else None
    if seat is None or seat.watches is None:
        return None
    return next((device for device in scene.devices if device.name == seat.watches), None)
