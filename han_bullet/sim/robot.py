"""The robot in the physics: an omnidirectional base that follows twists with limited acceleration and limited force."""

from __future__ import annotations

import math

import numpy as np
import pybullet

from han_bullet.geometry import Array, Pose2D, Twist2D, rotated
from han_bullet.mecanum import WHEELS
from han_bullet.sim.robot_model import HEAD, RobotModel
from han_bullet.sim.scene_state import RobotPosture
from han_bullet.world_schema import PHYSICS_PERIOD, Robot

MAX_FORCE = 60.0  # [N]; 40 kg at 1 m/s^2 and half as much again for bends; pushes light things, stops at walls
MAX_TORQUE = 30.0  # [N m]; several times what 3 rad/s^2 need
WHEEL_TORQUE = 2.0  # [N m]; the wheels only turn visibly, the body is driven as a whole


class MecanumRobot:
    """Drive the robot by body twists.

    The wheels' rollers are not simulated: a planar force and a torque on the whole body, both limited, do what they
    would do. Friction with the floor is none, as it is for ideal rollers.

    Attributes:
        body: Its id in the client.
        mass: [kg].
        wheels: Their geometry.
        pose_in_world: True pose at the last measurement.
        twist_in_body: True twist of the robot's centre at the last measurement.
    """

    def __init__(self, client: int, settings: Robot) -> None:
        """Load the robot into a physics client.

        Args:
            client: PyBullet client.
            settings: Start pose and limits.
        """
        self._client = client
        self._limits = settings
        self._model = RobotModel(client, settings.urdf, settings.start_pose_in_world, fixed=False)
        self.body = self._model.body
        self.wheels = self._model.wheels()
        self._wheel_speeds: tuple[float, ...] | None = None
        self._target = Twist2D()
        self._links = [-1, *range(pybullet.getNumJoints(self.body, physicsClientId=client))]
        self._remove_friction()
        self.mass, self._centre_of_mass, self._yaw_inertia = self._mass_properties()
        pybullet.setJointMotorControl2(
            self.body, self._model.joints[HEAD], pybullet.POSITION_CONTROL, 0.0, force=5.0, physicsClientId=client
        )
        self.measure()

    def command(self, twist: Twist2D) -> None:
        """Set the wanted twist in the body frame; beyond the limits it is scaled down to them."""
        scale = min(1.0, self._limits.max_speed / max(twist.speed, 1e-9))
        omega = _clipped(twist.omega, self._limits.max_yaw_rate)
        self._target = Twist2D(twist.vx * scale, twist.vy * scale, omega)

    def drive(self) -> None:
        """Apply the force and torque of one physics step."""
        pose, twist = self.pose_in_world, self.twist_in_body
        next_twist = self._ramp(twist)
        x, y = rotated(twist.vx, twist.vy, pose.yaw)
        next_x, next_y = rotated(next_twist.vx, next_twist.vy, pose.yaw + next_twist.omega * PHYSICS_PERIOD)
        inertia = self.mass / PHYSICS_PERIOD
        force = _shortened(inertia * (next_x - x), inertia * (next_y - y), MAX_FORCE)
        torque = self._yaw_inertia * (next_twist.omega - twist.omega) / PHYSICS_PERIOD
        self._push(pose, force, _clipped(torque, MAX_TORQUE))
        self._turn_wheels(next_twist)

    def measure(self) -> None:
        """Read pose and twist; call this after each physics step."""
        self.pose_in_world = pose = self._model.pose_in_world()
        (x, y, _), (_, _, omega) = pybullet.getBaseVelocity(self.body, physicsClientId=self._client)
        self.twist_in_body = Twist2D(*rotated(x, y, -pose.yaw), omega)

    @property
    def posture(self) -> RobotPosture:
        """Return how the robot looks now."""
        names = (HEAD, *WHEELS)
        joints = [self._model.joints[name] for name in names]
        states = pybullet.getJointStates(self.body, joints, physicsClientId=self._client)
        head, front_left, front_right, rear_left, rear_right = (state[0] for state in states)
        return RobotPosture(self.pose_in_world, head, (front_left, front_right, rear_left, rear_right))

    def _ramp(self, twist: Twist2D) -> Twist2D:
        """Return the twist of the next step: from the present one towards the target, within the accelerations."""
        target, limits = self._target, self._limits
        fastest = limits.max_acceleration * PHYSICS_PERIOD
        change_x, change_y = _shortened(target.vx - twist.vx, target.vy - twist.vy, fastest)
        most = limits.max_yaw_acceleration * PHYSICS_PERIOD
        omega = twist.omega + _clipped(target.omega - twist.omega, most)
        return Twist2D(twist.vx + change_x, twist.vy + change_y, omega)

    def _push(self, pose: Pose2D, force: tuple[float, float], torque: float) -> None:
        x, y, height = self._centre_of_mass
        x, y = rotated(x, y, pose.yaw)
        pybullet.applyExternalForce(
            self.body,
            -1,
            [*force, 0.0],
            [pose.x + x, pose.y + y, height],
            pybullet.WORLD_FRAME,
            physicsClientId=self._client,
        )
        pybullet.applyExternalTorque(
            self.body, -1, [0.0, 0.0, torque], pybullet.WORLD_FRAME, physicsClientId=self._client
        )

    def _turn_wheels(self, twist: Twist2D) -> None:
        speeds = self.wheels.speeds(twist)
        if speeds == self._wheel_speeds:
            return
        self._wheel_speeds = speeds
        pybullet.setJointMotorControlArray(
            self.body,
            [self._model.joints[name] for name in WHEELS],
            pybullet.VELOCITY_CONTROL,
            targetVelocities=speeds,
            forces=[WHEEL_TORQUE] * len(WHEELS),
            physicsClientId=self._client,
        )

    def _remove_friction(self) -> None:
        for link in self._links:
            pybullet.changeDynamics(
                self.body,
                link,
                lateralFriction=0.0,
                restitution=0.0,
                linearDamping=0.0,
                angularDamping=0.0,
                jointDamping=0.0,
                physicsClientId=self._client,
            )

    def _mass_properties(self) -> tuple[float, tuple[float, float, float], float]:
        """Return mass [kg], centre of mass in the body frame [m] and inertia about the vertical there [kg m^2]."""
        infos = [pybullet.getDynamicsInfo(self.body, link, physicsClientId=self._client) for link in self._links]
        masses = np.array([info[0] for info in infos])
        centres = np.array([self._centre_of_link(link) for link in self._links])
        centre = masses @ centres / masses.sum()
        spread = np.sum((centres - centre)[:, :2] ** 2, axis=1)
        inertia = float(sum(info[2][2] for info in infos) + masses @ spread)
        in_body = self._model.pose_in_world().to_body(centre[:2])
        return float(masses.sum()), (float(in_body[0]), float(in_body[1]), float(centre[2])), inertia

    def _centre_of_link(self, link: int) -> Array:
        if link == -1:
            return np.array(pybullet.getBasePositionAndOrientation(self.body, physicsClientId=self._client)[0])
        state = pybullet.getLinkState(self.body, link, computeForwardKinematics=True, physicsClientId=self._client)
        return np.array(state[0])


def _shortened(x: float, y: float, longest: float) -> tuple[float, float]:
    """Return a vector, scaled down where it is longer than a limit."""
    scale = min(1.0, longest / max(math.hypot(x, y), 1e-12))
    return x * scale, y * scale


def _clipped(value: float, most: float) -> float:
    return min(max(value, -most), most)
