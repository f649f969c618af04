"""The true outline of a body in a picture: against geometry, and against bodies that are half hidden."""

import math

import numpy as np
import pybullet
import pytest

from han_bullet import assets
from han_bullet.geometry import Array, Pose2D, camera_on_robot, project
from han_bullet.messages import Posture
from han_bullet.sim.avatar import Avatar
from han_bullet.sim.gait import BodyPose, Gait
from han_bullet.sim.raster import Raster
from han_bullet.sim.renderer import Renderer
from han_bullet.sim.scene_state import RobotPosture, SceneState
from han_bullet.sim.silhouette import Silhouette, silhouette_of
from han_bullet.world_file import load_world
from han_bullet.world_schema import CeilingCamera, Furniture, World

ROBOT = Pose2D(1.5, 0.0, 0.0)
TV_OFF = (("tv", False),)


def standing(pose: Pose2D, build: str = "slim") -> BodyPose:
    return Gait(build).advance(pose, 0.0, 0.05, Posture.STANDING)


def seen(camera: str, *people: Pose2D, furniture: tuple[Furniture, ...] = ()) -> tuple[Silhouette | None, ...]:
    """What a camera of real2 shows of slim people; the onboard one is at ROBOT."""
    world = load_world("real2")
    person = world.people[0].model_copy(update={"build": "slim"})
    everybody = tuple(person.model_copy(update={"name": f"p{number}"}) for number in range(len(people)))
    world = world.model_copy(update={"people": everybody, "furniture": furniture})
    renderer = Renderer(world, seed=0)
    robot = RobotPosture(ROBOT if camera == "onboard" else Pose2D(22.0, 3.0, 0.0))
    _, silhouettes = renderer.render_with_people(
        camera, SceneState(0.0, 0, robot, tuple(standing(pose) for pose in people), TV_OFF)
    )
    renderer.close()
    return silhouettes


def vertices_in_world(body_pose: BodyPose, build: str) -> Array:
    """Every vertex of a body without coat and bag, carried along by PyBullet's forward kinematics, (n, 3) [m]."""
    client = pybullet.connect(pybullet.DIRECT)
    avatar = Avatar(client, build, 0)
    avatar.place(body_pose)
    found = []
    for shape in pybullet.getVisualShapeData(avatar.body, physicsClientId=client):
        if shape[7][3] == 0.0:
            continue
        text = (assets.urdf_folder() / shape[4].decode()).read_text().splitlines()
        vertices = np.array([line.split()[1:4] for line in text if line.startswith("v ")], float)
        if shape[1] == -1:
            origin, quaternion = pybullet.getBasePositionAndOrientation(avatar.body, physicsClientId=client)
        else:
            state = pybullet.getLinkState(avatar.body, shape[1], computeForwardKinematics=1, physicsClientId=client)
            origin, quaternion = state[4:6]
        found.append(vertices @ np.array(pybullet.getMatrixFromQuaternion(quaternion)).reshape(3, 3).T + origin)
    pybullet.disconnect(physicsClientId=client)
    return np.concatenate(found)


def view_of(world: World, name: str) -> tuple[object, Array]:
    camera = world.camera(name)
    if isinstance(camera, CeilingCamera):
        return camera.intrinsics, camera.camera_in_world
    return camera.intrinsics, camera_on_robot(ROBOT, camera.forward, camera.height, camera.pitch_down)


@pytest.mark.parametrize("camera", ["camera1", "onboard"])
@pytest.mark.parametrize("yaw", [0.0, 0.5 * math.pi, 2.3])
def test_the_box_of_a_standing_person_is_that_of_the_projected_body(camera: str, yaw: float) -> None:
    pose = Pose2D(6.2, 0.4, yaw)
    (silhouette,) = seen(camera, pose)
    assert silhouette is not None
    pixels, _ = project(vertices_in_world(standing(pose), "slim"), *view_of(load_world("real2"), camera))
    corners = np.array([silhouette.box[:2], silhouette.box[:2] + silhouette.box[2:]])
    assert np.abs(corners - [pixels.min(axis=0), pixels.max(axis=0)]).max() < 2.0  # [px]
    assert silhouette.box[3] > 150.0
    assert silhouette.hidden == 0.0
    assert not silhouette.cut


def test_foot_point_and_height_of_a_person_are_where_the_floor_plan_says() -> None:
    pose = Pose2D(8.0, -0.3, 0.5 * math.pi)  # seen from the side: no toe reaches towards the camera
    (silhouette,) = seen("onboard", pose)
    assert silhouette is not None
    pixels, _ = project(np.array([[8.0, -0.3, 0.0], [8.0, -0.3, 1.7]]), *view_of(load_world("real2"), "onboard"))
    x, y, width, height = silhouette.box
    assert abs(y + height - pixels[0, 1]) < 3.0  # [px]
    assert abs(height - (pixels[0, 1] - pixels[1, 1])) < 3.0
    assert abs(x + 0.5 * width - pixels[0, 0]) < 8.0


def test_a_person_of_whom_a_cupboard_hides_one_side_is_half_hidden_and_keeps_the_whole_box() -> None:
    pose = Pose2D(6.2, 0.0, math.pi)
    cupboard = Furniture(
        name="cupboard", position=(5.2, 0.5), size=(0.4, 1.0, 2.4)
    )  # its edge is in the camera's plane
    (free,), (hidden,) = seen("onboard", pose), seen("onboard", pose, furniture=(cupboard,))
    assert free is not None and hidden is not None
    assert np.array_equal(free.box, hidden.box)
    assert free.hidden == 0.0
    assert hidden.hidden == pytest.approx(0.5, abs=0.05)


def test_somebody_nearer_hides_somebody_farther_and_not_the_other_way_round() -> None:
    near, far = seen("onboard", Pose2D(4.5, 0.0, math.pi), Pose2D(6.5, 0.0, math.pi))
    assert near is not None and far is not None
    assert near.hidden == 0.0
    assert 0.6 < far.hidden < 1.0


def test_a_person_behind_the_camera_has_no_outline_and_one_behind_a_wall_is_all_hidden() -> None:
    wall = Furniture(name="screen", position=(5.0, 0.0), size=(0.2, 2.8, 2.8))
    behind, hidden = seen("onboard", Pose2D(0.5, 0.0, 0.0), Pose2D(7.0, 0.0, 0.0), furniture=(wall,))
    assert behind is None
    assert hidden is not None and hidden.hidden == 1.0


def test_a_person_near_the_camera_is_cut_by_the_picture_s_edge() -> None:
    (close,) = seen("camera1", Pose2D(2.6, 0.0, 0.0))
    assert close is not None and close.cut
    assert close.box[1] + close.box[3] == 480.0


def raster(inverse_depth: float) -> Raster:
    return Raster(np.zeros((60, 80, 3), np.uint8), np.full((60, 80), inverse_depth, np.float32))


@pytest.mark.parametrize(("covered", "hidden"), [(0, 0.0), (3, 0.3), (10, 1.0)])
def test_hidden_is_the_part_of_the_body_s_pixels_that_show_something_nearer(covered: int, hidden: float) -> None:
    picture, body = raster(0.1), raster(0.0)
    body.inverse_depth[15:25, 24:32] = 0.2
    picture.inverse_depth[15:25, 24:32] = 0.2
    picture.inverse_depth[15 : 15 + covered, 20:40] = 0.5
    silhouette = silhouette_of(body, picture)
    assert silhouette is not None
    assert silhouette.box.tolist() == [24.0, 15.0, 8.0, 10.0]
    assert silhouette.hidden == pytest.approx(hidden)
    assert not silhouette.cut


def test_a_body_without_a_pixel_has_no_outline() -> None:
    assert silhouette_of(raster(0.0), raster(0.1)) is None
