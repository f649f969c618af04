"""Where the robot would touch a person."""

from __future__ import annotations

import math

from han_bullet.costmap.grid import LETHAL, Costmap
from han_bullet.costmap.layer import Layer
from han_bullet.costmap.shapes import raise_disc
from han_bullet.errors import BadInputError, check_positive
from han_bullet.messages import Scene, TrackedPerson


class BodyLayer(Layer):
    """A LETHAL disc for the robot's centre around every person: both bodies and the track's own uncertainty."""

    name = "body"

    def __init__(
        self,
        *,
        robot_radius: float,
        body_radius: float = 0.25,
        smallest_margin: float = 0.1,
        largest_margin: float = 0.2,
    ) -> None:
        """Configure the disc.

        Args:
            robot_radius: Of the footprint [m].
            body_radius: Of a person [m]; shoulders are about 0.5 m wide.
            smallest_margin: Least value of two deviations of the track [m], for what moves while the robot brakes.
            largest_margin: Most [m], so that a vague track leaves a 3 m corridor passable.
        """
        check_positive(f"layer {self.name}", robot_radius=robot_radius, body_radius=body_radius)
        check_positive(f"layer {self.name}", smallest_margin=smallest_margin, largest_margin=largest_margin)
        if smallest_margin > largest_margin:
            raise BadInputError(
                f"layer body: smallest_margin is {smallest_margin!r} m; it must be at most largest_margin, "
                f"{largest_margin!r} m"
            )
        self.robot_radius = robot_radius
        self.body_radius = body_radius
        self.smallest_margin = smallest_margin
        self.largest_margin = largest_margin

    @property
    def largest_radius(self) -> float:
        """Return the radius [m] that no person's disc exceeds."""
        return self.body_radius + self.robot_radius + self.largest_margin

    def radius(self, person: TrackedPerson) -> float:
        """Return the radius [m] of a person's disc."""
        (xx, xy), (_, yy) = person.covariance[:2, :2].tolist()
        largest_variance = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)
        deviation = math.sqrt(max(largest_variance, 0.0))
        margin = min(max(2.0 * deviation, self.smallest_margin), self.largest_margin)
        return self.body_radius + self.robot_radius + margin

    def apply(self, costmap: Costmap, scene: Scene) -> None:
        """Raise the discs of all people."""
        for person in scene.people:
            raise_disc(costmap, person.position_in_world, self.radius(person), LETHAL)
