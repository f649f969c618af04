"""A person of the simulation: a behaviour, the gait that goes with it, and a body that can be bumped into."""

from __future__ import annotations

import pybullet

from han_bullet.messages import Posture, TruePerson
from han_bullet.sim.behaviours import behaviour_of
from han_bullet.sim.gait import BodyPose, Gait
from han_bullet.sim.trigger import RobotNow
from han_bullet.world_schema import Person, World

BODY_RADIUS = 0.25  # [m]
STANDING_HEIGHT = 1.75  # [m]
SEATED_HEIGHT = 1.3  # [m]


class Pedestrian:
    """A person who moves by intention, not by forces: an upright cylinder that the robot cannot push away.

    Attributes:
        name: As in the world file.
        body: Id of the cylinder in the physics client.
        body_pose: Posture of the whole body at the last call of pose_body.
    """

    def __init__(self, client: int, person: Person, world: World) -> None:
        self._client = client
        self.name = person.name
        self._behaviour = behaviour_of(person, world)
        self._gait = Gait(person.build)
        self._height = SEATED_HEIGHT if self._behaviour.posture is Posture.SEATED else STANDING_HEIGHT
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_CYLINDER, radius=BODY_RADIUS, height=self._height, physicsClientId=client
        )
        self.body: int = pybullet.createMultiBody(0.0, shape, physicsClientId=client)
        self._place()
        self.body_pose = self.pose_body(0.0)

    def advance(self, robot: RobotNow, dt: float) -> None:
        """Move on by one physics step [s]."""
        self._behaviour.advance(robot, dt)
        self._place()

    def pose_body(self, dt: float) -> BodyPose:
        """Let the limbs follow the movement of the last time step [s]."""
        moved = self._behaviour
        self.body_pose = self._gait.advance(moved.pose_in_world, moved.speed, dt, moved.posture)
        return self.body_pose

    @property
    def truth(self) -> TruePerson:
        """Return where the person is and what they do."""
        now = self._behaviour
        return TruePerson(self.name, now.pose_in_world, now.velocity_in_world, now.posture)

    def _place(self) -> None:
        pose = self._behaviour.pose_in_world
        pybullet.resetBasePositionAndOrientation(
            self.body, [pose.x, pose.y, 0.5 * self._height], [0.0, 0.0, 0.0, 1.0], physicsClientId=self._client
        )
