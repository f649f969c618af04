import math
from collections.abc import Iterator

import numpy as np
import pybullet
import pytest

from han_bullet.errors import BadInputError
from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.mecanum import MecanumWheels
from han_bullet.sim.robot import MAX_FORCE, MecanumRobot
from han_bullet.sim.robot_model import RobotModel
from han_bullet.sim.scene_state import RobotPosture
from han_bullet.world_schema import PHYSICS_PERIOD, Robot

TICK = 12  # physics steps


@pytest.fixture
def client() -> Iterator[int]:
    number = pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(0.0, 0.0, -9.81, physicsClientId=number)
    pybullet.setTimeStep(PHYSICS_PERIOD, physicsClientId=number)
    ground = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=number)
    pybullet.createMultiBody(0.0, ground, physicsClientId=number)
    yield number
    pybullet.disconnect(physicsClientId=number)


def run(client: int, robot: MecanumRobot, twist: Twist2D, seconds: float) -> None:
    robot.command(twist)
    for _ in range(round(seconds / PHYSICS_PERIOD)):
        robot.drive()
        pybullet.stepSimulation(physicsClientId=client)
        robot.measure()


def box(client: int, mass: float, position: list[float], half: list[float]) -> int:
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client)
    number: int = pybullet.createMultiBody(mass, shape, -1, position, physicsClientId=client)
    return number


def test_a_commanded_ramp_is_followed_within_two_centimetres_per_second(client: int) -> None:
    robot = MecanumRobot(client, Robot(start=(0.0, 0.0, 0.6)))
    assert robot.mass == pytest.approx(40.0, abs=1.0)
    for tick in range(60):
        speed, omega = min(0.05 * (tick + 1), 1.0), 0.8 * math.sin(tick / 6.0)
        wanted = Twist2D(0.8 * speed, 0.6 * speed, omega)
        run(client, robot, wanted, TICK * PHYSICS_PERIOD)
        got = robot.twist_in_body
        assert abs(got.vx - wanted.vx) < 0.02 and abs(got.vy - wanted.vy) < 0.02, f"tick {tick}: {got}"
        assert abs(got.omega - wanted.omega) < 0.02


def test_a_jump_of_the_command_is_followed_with_one_metre_per_second_squared(client: int) -> None:
    robot = MecanumRobot(client, Robot(start=(0.0, 0.0, 0.0)))
    run(client, robot, Twist2D(1.0, 0.0, 0.0), 0.5)
    assert robot.twist_in_body.vx == pytest.approx(0.5, abs=0.02)
    run(client, robot, Twist2D(0.0, 0.0, 1.5), 0.25)
    assert robot.twist_in_body.vx == pytest.approx(0.25, abs=0.02)
    assert robot.twist_in_body.omega == pytest.approx(0.75, abs=0.02)


def test_commands_beyond_the_limits_are_scaled_down_to_them(client: int) -> None:
    robot = MecanumRobot(client, Robot(start=(0.0, 0.0, 0.0)))
    run(client, robot, Twist2D(3.0, 4.0, -9.0), 2.0)
    assert robot.twist_in_body.vx == pytest.approx(0.6, abs=0.03)  # the bend takes all of the 60 N
    assert robot.twist_in_body.vy == pytest.approx(0.8, abs=0.03)
    assert robot.twist_in_body.omega == pytest.approx(-1.5, abs=0.01)


def test_an_idle_robot_stays_where_it_is(client: int) -> None:
    robot = MecanumRobot(client, Robot(start=(1.0, -2.0, 0.7)))
    run(client, robot, Twist2D(), 2.0)
    pose = robot.pose_in_world
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((1.0, -2.0, 0.7), abs=1e-3)


def test_a_wall_stops_the_robot_which_stays_upright(client: int) -> None:
    robot = MecanumRobot(client, Robot(start=(0.0, 0.0, 0.0)))
    box(client, 0.0, [1.35, 0.0, 1.0], [0.05, 2.0, 1.0])
    run(client, robot, Twist2D(1.0, 0.0, 0.0), 4.0)
    assert robot.pose_in_world.x == pytest.approx(1.0, abs=0.01)  # 1.3 m to the wall less the radius of 0.3 m
    assert robot.twist_in_body.speed < 0.02
    _, quaternion = pybullet.getBasePositionAndOrientation(robot.body, physicsClientId=client)
    roll, pitch, _ = pybullet.getEulerFromQuaternion(quaternion)
    assert abs(roll) < 0.01 and abs(pitch) < 0.01


def test_a_light_box_is_pushed_and_a_heavy_one_that_sticks_is_not(client: int) -> None:
    robot = MecanumRobot(client, Robot(start=(0.0, 0.0, 0.0)))
    light = box(client, 2.0, [0.8, 0.0, 0.2], [0.2, 0.2, 0.2])
    run(client, robot, Twist2D(0.5, 0.0, 0.0), 3.0)
    assert pybullet.getBasePositionAndOrientation(light, physicsClientId=client)[0][0] > 1.3
    assert robot.twist_in_body.vx == pytest.approx(0.5, abs=0.1)
    pybullet.removeBody(light, physicsClientId=client)
    before = robot.pose_in_world.x
    heavy = box(client, 60.0, [before + 1.0, 0.0, 0.4], [0.4, 0.4, 0.4])
    pybullet.changeDynamics(heavy, -1, lateralFriction=2.0 * MAX_FORCE / (60.0 * 9.81) / 0.5, physicsClientId=client)
    run(client, robot, Twist2D(0.5, 0.0, 0.0), 4.0)
    moved = pybullet.getBasePositionAndOrientation(heavy, physicsClientId=client)[0][0] - (before + 1.0)
    assert 0.0 <= moved < 0.08  # the knock of 40 kg at 0.5 m/s, no more
    assert robot.pose_in_world.x > before + 0.25


def test_wheel_geometry_is_read_from_the_urdf(client: int) -> None:
    wheels = RobotModel(client, "mbot.urdf", Pose2D(2.0, 1.0, 0.5), fixed=True).wheels()
    assert 0.05 < wheels.radius < 0.15
    assert 0.1 < wheels.half_length < 0.3 and 0.1 < wheels.half_width < 0.3


@pytest.mark.parametrize(
    ("twist", "signs"),
    [
        (Twist2D(0.3, 0.0, 0.0), (1, 1, 1, 1)),
        (Twist2D(0.0, 0.3, 0.0), (-1, 1, 1, -1)),
        (Twist2D(0.0, 0.0, 0.6), (-1, 1, -1, 1)),
    ],
)
def test_wheels_turn_as_mecanum_wheels_do(client: int, twist: Twist2D, signs: tuple[int, ...]) -> None:
    robot = MecanumRobot(client, Robot(start=(0.0, 0.0, 0.0)))
    run(client, robot, twist, 1.0)
    before = np.array(robot.posture.wheel_angles)
    run(client, robot, twist, 1.0)
    turned = np.array(robot.posture.wheel_angles) - before
    wheels = RobotModel(client, "mbot.urdf", Pose2D(9.0, 9.0, 0.0), fixed=True).wheels()
    assert np.array_equal(np.sign(turned), signs)
    assert turned == pytest.approx(np.array(wheels.speeds(twist)), rel=0.02)


def test_wheel_speeds_of_a_known_twist_are_the_textbooks() -> None:
    wheels = MecanumWheels(radius=0.1, half_length=0.2, half_width=0.3)
    assert wheels.speeds(Twist2D(1.0, 0.5, 0.4)) == pytest.approx((3.0, 17.0, 13.0, 7.0))


def test_a_robot_is_drawn_where_its_posture_says(client: int) -> None:
    model = RobotModel(client, "mbot.urdf", Pose2D(0.0, 0.0, 0.0), fixed=True)
    model.place(RobotPosture(Pose2D(3.0, -1.0, 2.5), 0.3, (0.1, 0.2, 0.3, 0.4)))
    pose = model.pose_in_world()
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((3.0, -1.0, 2.5))
    state = pybullet.getJointState(model.body, model.joints["wheel_rear_left"], physicsClientId=client)
    assert state[0] == pytest.approx(0.3)


def test_a_urdf_without_wheels_is_refused_by_the_missing_joint(client: int) -> None:
    with pytest.raises(BadInputError, match="head_pan"):
        RobotModel(client, "couch.urdf", Pose2D(0.0, 0.0, 0.0), fixed=True)
    with pytest.raises(BadInputError, match=r"'nobot\.urdf'.*mbot\.urdf"):
        RobotModel(client, "nobot.urdf", Pose2D(0.0, 0.0, 0.0), fixed=True)
