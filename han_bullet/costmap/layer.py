"""The contract of a costmap layer."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar

from han_bullet.costmap.grid import Costmap
from han_bullet.errors import BadInputError
from han_bullet.messages import Scene, Seat, TrackedPerson


class Layer(ABC):
    """One reason why a place costs more.

    Attributes:
        name: As in `--without` and a world's `layers:` section.
    """

    name: ClassVar[str]

    @abstractmethod
    def apply(self, costmap: Costmap, scene: Scene) -> None:
        """Raise the map's costs for what is in the scene; a layer never lowers one."""


def check_amplitude(layer: str, amplitude: float) -> None:
    """Raise BadInputError unless a layer's amplitude, what it is multiplied with, lies in [0, 1]."""
    if not 0.0 <= amplitude <= 1.0:
        raise BadInputError(f"layer {layer}: amplitude is {amplitude!r}; it must lie in [0, 1]")


def walking_direction(person: TrackedPerson) -> float:
    """Return where a walking person is going [rad]: the heading, or that of the velocity while it is not settled."""
    if person.heading is not None:
        return person.heading
    return math.atan2(person.velocity_in_world[1], person.velocity_in_world[0])


def seat_of(person: TrackedPerson, scene: Scene) -> Seat | None:
    """Return the sitting area that a person is on, or None."""
    return next((seat for seat in scene.seats if seat.name == person.seat), None)
