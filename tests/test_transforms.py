"""The tree of frames, put together again as a subscriber does."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from tf_tree import FrameTree

from han_bullet.geometry import Pose2D, Twist2D
from han_bullet.mecanum import WHEELS
from han_bullet.messages import CameraImage, Odometry, PoseEstimate
from han_bullet.ros.frames import optical_frame
from han_bullet.ros.placing import quaternion_of
from han_bullet.ros.robot_description import RobotDescription
from han_bullet.ros.transforms import Transforms
from han_bullet.world_file import load_world
from han_bullet.world_schema import CeilingCamera

WORLD = load_world("real2")
TRANSFORMS = Transforms(WORLD, RobotDescription(WORLD.robot.urdf))
poses = st.builds(Pose2D, st.floats(-30, 30), st.floats(-30, 30), st.floats(-math.pi, math.pi))
STILL = (0.0, 0.0, 0.0, 0.0)


def tree(estimate: Pose2D, odometry: Pose2D = Pose2D(0.0, 0.0, 0.0), angles: tuple[float, ...] = STILL) -> FrameTree:
    moving = TRANSFORMS.moving(PoseEstimate(2.0, estimate), Odometry(2.0, odometry, Twist2D()), angles)
    return FrameTree(moving, TRANSFORMS.static())


@given(poses, poses)
def test_map_to_base_link_is_the_estimate_and_odom_to_base_link_the_odometry(
    estimate: Pose2D, odometry: Pose2D
) -> None:
    frames = tree(estimate, odometry)
    np.testing.assert_allclose(frames.pose("base_link", "map"), estimate.matrix(), atol=1e-9)
    np.testing.assert_allclose(frames.pose("base_link", "odom"), odometry.matrix(), atol=1e-9)


def test_every_camera_frame_is_where_its_images_are_taken_to_be_from() -> None:
    robot = Pose2D(3.0, -0.4, 2.2)
    frames = tree(robot, Pose2D(1.0, 5.0, -0.7))
    assert {type(camera).__name__ for camera in WORLD.cameras} == {"CeilingCamera", "OnboardCamera"}
    for camera in WORLD.cameras:
        fixed = isinstance(camera, CeilingCamera)
        mount = camera.camera_in_world if isinstance(camera, CeilingCamera) else camera.mount
        image = CameraImage(camera.name, 2.0, np.zeros((0, 0, 3), np.uint8), camera.intrinsics, mount, fixed)
        found = frames.pose(optical_frame(camera.name), "map")
        np.testing.assert_allclose(found, image.placed(robot).camera_in_world, atol=1e-9)


def test_there_is_one_tree_from_map_to_every_link_of_the_urdf_and_the_laser() -> None:
    frames = tree(Pose2D(0.0, 0.0, 0.0))
    links = {"head", "camera_mount", *WHEELS, "laser", *(optical_frame(camera.name) for camera in WORLD.cameras)}
    assert set(frames.parents) == links | {"odom", "base_link"}
    assert all(np.isfinite(frames.pose(frame, "map")).all() for frame in frames.parents)


def test_the_laser_is_where_the_world_has_it() -> None:
    laser = WORLD.robot.laser
    assert laser is not None
    place = tree(Pose2D(1.0, 2.0, math.pi / 2)).pose("laser", "map")
    np.testing.assert_allclose(place[:3, 3], [1.0, 2.0 + laser.forward, laser.height], atol=1e-12)


def test_a_wheel_turns_forward_about_its_axle() -> None:
    wheel = tree(Pose2D(0.0, 0.0, 0.0), angles=(math.pi / 2, 0.0, 0.0, 0.0)).pose(WHEELS[0], "base_link")
    np.testing.assert_allclose(wheel[:3, 3], [0.165, 0.195, 0.075])
    np.testing.assert_allclose(wheel[:3, :3] @ [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], atol=1e-12)  # its top goes ahead


@given(st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: float(np.linalg.norm(q)) > 0.1))
def test_a_rotation_as_quaternion_is_the_same_rotation(components: list[float]) -> None:
    rotation = Rotation.from_quat(components).as_matrix()
    quaternion = quaternion_of(rotation)
    np.testing.assert_allclose(Rotation.from_quat(quaternion).as_matrix(), rotation, atol=1e-9)
    assert quaternion[3] >= 0.0


def test_half_turns_have_a_quaternion_too() -> None:
    for axis in np.eye(3):
        turn = 2.0 * np.outer(axis, axis) - np.eye(3)
        np.testing.assert_allclose(np.abs(quaternion_of(turn)), [*axis, 0.0], atol=1e-12)
