"""What the robot touches."""

from __future__ import annotations

from collections.abc import Mapping

import pybullet

from han_bullet.messages import Contact

TOUCH = 0.0  # [m]; the engine already reports pairs that are still 12 mm apart


class ContactSensor:
    """Collect touches over the physics steps of a control tick, so that a short one is not missed."""

    def __init__(self, client: int, robot: int, bodies: Mapping[int, tuple[str, str]]) -> None:
        """Watch the robot.

        Args:
            client: PyBullet client.
            robot: Body id of the robot.
            bodies: Body id -> name and kind; what is not in here (the floor) is ignored.
        """
        self._client = client
        self._robot = robot
        self._bodies = dict(bodies)
        self._nearest: dict[int, float] = {}

    def sample(self) -> None:
        """Take note of the touches of one physics step."""
        for point in pybullet.getContactPoints(bodyA=self._robot, physicsClientId=self._client):
            self._note(point[2], point[8])

    def read(self) -> tuple[Contact, ...]:
        """Return each body touched since the last call, by its smallest distance, in the order of the bodies."""
        for body in self._bodies:
            for point in pybullet.getClosestPoints(self._robot, body, TOUCH, physicsClientId=self._client):
                self._note(body, point[8])
        touched = [(body, self._nearest[body]) for body in self._bodies if body in self._nearest]
        self._nearest.clear()
        return tuple(Contact(*self._bodies[body], distance) for body, distance in touched)

    def _note(self, body: int, distance: float) -> None:
        if body in self._bodies and distance <= TOUCH:
            self._nearest[body] = min(distance, self._nearest.get(body, TOUCH))
