import itertools
import math
from dataclasses import replace

import numpy as np
import pybullet
import pytest
from tiny_renderer import tiny_picture

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Intrinsics, Pose2D, camera_on_robot, look_at, project, rotation
from han_bullet.messages import Posture
from han_bullet.sim.avatar import Avatar
from han_bullet.sim.drawn_scene import DrawnScene
from han_bullet.sim.gait import Gait
from han_bullet.sim.image_noise import ImageNoise
from han_bullet.sim.raster import Raster, View
from han_bullet.sim.rasterizer import draw
from han_bullet.sim.renderer import Renderer
from han_bullet.sim.robot_model import RobotModel
from han_bullet.sim.room import VisualRoom
from han_bullet.sim.room_surfaces import room_surfaces
from han_bullet.sim.scene_state import DevicesOn, RobotPosture, SceneState
from han_bullet.sim.surfaces import LARGEST_TILE, box_sides
from han_bullet.world_file import load_world
from han_bullet.world_schema import CeilingCamera, Furniture, Light, World

SMALL = Intrinsics.from_vertical_field_of_view(320, 240, math.radians(45.0))
TINY = Intrinsics.from_vertical_field_of_view(192, 144, math.radians(45.0))
LONGEST_VIEW = 24.0  # [m]
TV_OFF, TV_ON = (("tv", False),), (("tv", True),)


def real2(**changes: object) -> World:
    return load_world("real2").model_copy(update=changes)


def scene(robot: Pose2D, *people: Pose2D, number: int = 0, posture: Posture = Posture.STANDING) -> SceneState:
    poses = tuple(Gait("slim").advance(pose, 0.0, 0.05, posture) for pose in people)
    return SceneState(0.0, number, RobotPosture(robot), poses, TV_OFF)


def rays(intrinsics: Intrinsics, camera_in_world: Array) -> Array:
    """Return the directions through all pixel centres, shape (height, width, 3), one unit deep."""
    u, v = np.meshgrid(np.arange(intrinsics.width) + 0.5, np.arange(intrinsics.height) + 0.5)
    in_camera = np.stack(
        [(u - intrinsics.cx) / intrinsics.fx, (v - intrinsics.cy) / intrinsics.fy, np.ones_like(u)], -1
    )
    return in_camera @ camera_in_world[:3, :3].T


def cast(world: World, intrinsics: Intrinsics, camera_in_world: Array) -> Array:
    """Return the depth of floor plane and walls by intersecting rays, inf where there is nothing."""
    along, start = rays(intrinsics, camera_in_world), camera_in_world[:3, 3]
    depth = np.where(along[..., 2] < -1e-9, -start[2] / np.minimum(along[..., 2], -1e-9), np.inf)
    for box in world.solid_boxes():
        turn = np.eye(3)
        turn[:2, :2] = rotation(box.yaw)
        origin, direction = (start - box.centre_in_world) @ turn, along @ turn
        direction = np.where(np.abs(direction) < 1e-12, 1e-12, direction)
        first, second = (-0.5 * box.size - origin) / direction, (0.5 * box.size - origin) / direction
        enter, leave = np.minimum(first, second).max(axis=-1), np.maximum(first, second).min(axis=-1)
        depth = np.where((enter < leave) & (enter > 0.0), np.minimum(depth, enter), depth)
    return depth


def picture_of_room(drawn: DrawnScene, view: View, light: Light, devices: DevicesOn = ()) -> Raster:
    raster = Raster.blank(view.intrinsics)
    for mesh in drawn.room(devices):
        draw(raster, mesh, view, light)
    return raster


def depth_of_room(drawn: DrawnScene, view: View) -> Array:
    """The distances along the view, inf where nothing is [m]."""
    inverse = picture_of_room(drawn, view, Light()).inverse_depth.astype(float)
    return np.divide(1.0, inverse, out=np.full_like(inverse, np.inf), where=inverse > 0.0)


def test_floor_and_walls_are_complete_from_every_viewpoint() -> None:
    world = real2(furniture=(), devices=(), people=())
    scene_of_world = DrawnScene(world)
    generator = np.random.default_rng(3)
    views = [
        ((0.0, 0.0, 2.5), (5.0, 0.0, 0.5)),
        ((0.2, 0.0, 2.6), (6.2, 0.0, 0.9)),
        ((8.0, 0.0, 2.5), (13.0, 0.0, 0.5)),
    ]
    for _ in range(25):
        position = generator.uniform([0.3, -1.3, 0.8], [15.5, 1.3, 2.7])
        views.append((tuple(position), tuple(generator.uniform([0.0, -1.5, 0.0], [22.0, 1.5, 2.0]))))
    for position, target in views:
        camera = look_at(np.array(position), np.array(target))
        depth = depth_of_room(scene_of_world, View(TINY, camera))
        expected = cast(world, TINY, camera)
        expected[expected > LONGEST_VIEW] = np.inf
        there = np.isfinite(expected)
        wrong = np.abs(depth[there] - expected[there]) > 0.02 + 0.02 * expected[there]
        assert wrong.sum() <= 3, f"{wrong.sum()} px wrong from {position} to {target}"  # a pixel on an edge may differ
    scene_of_world.close()


def test_pixel_centres_of_a_rendering_agree_with_the_projection_within_a_tenth_of_a_pixel() -> None:
    world = real2(furniture=(), devices=(), people=())
    drawn = DrawnScene(world)
    camera = look_at(np.array([0.2, 0.3, 2.6]), np.array([6.2, -0.4, 0.9]))
    depth = depth_of_room(drawn, View(SMALL, camera))
    expected = np.minimum(cast(world, SMALL, camera), LONGEST_VIEW)
    slope_v, slope_u = np.gradient(expected)
    smooth = np.hypot(*np.gradient(slope_v)) + np.hypot(*np.gradient(slope_u)) < 0.1 * (
        np.abs(slope_v) + np.abs(slope_u)
    )
    good = smooth & (expected < 12.0)
    assert good.sum() > 20_000
    system = np.column_stack([slope_u[good], slope_v[good]])
    shift, *_ = np.linalg.lstsq(system, (depth - expected)[good], rcond=None)
    assert np.abs(shift).max() < 0.1, f"the rendering is shifted by {shift} px"
    drawn.close()


def agrees(ours: Raster, theirs: Raster) -> tuple[float, float]:
    """The shares of pixels whose colour, to a grey level, and whose depth, to a millimetre, are the same."""
    colours = np.abs(ours.colour.astype(int) - theirs.colour).max(axis=-1) <= 1
    with np.errstate(divide="ignore", invalid="ignore"):
        depths = np.abs(1.0 / ours.inverse_depth - 1.0 / theirs.inverse_depth) < 1e-3
    return float(colours.mean()), float((depths | ~(ours.drawn | theirs.drawn)).mean())


@pytest.mark.parametrize(
    ("camera", "person"),
    [
        ("camera1", Pose2D(3.4, -0.2, 0.0)),  # the robot stands in front of the person's legs
        ("camera3", Pose2D(3.4, -0.2, 0.0)),
        ("camera4", Pose2D(18.5, 1.0, -0.7)),  # couch and television in the picture
        ("onboard", Pose2D(3.9, 0.2, 2.0)),
    ],
)
@pytest.mark.parametrize("devices", [TV_OFF, TV_ON])
def test_pictures_are_those_of_pybullets_own_renderer(
    camera: str, person: Pose2D, devices: tuple[tuple[str, bool]]
) -> None:
    world = real2(image_noise=0.0, light=Light(direction=(0.3, 0.5, 0.8), colour=(1.0, 0.95, 0.9)))
    state = replace(scene(Pose2D(2.6, 0.1, 0.2), person), devices_on=devices)
    client = pybullet.connect(pybullet.DIRECT)
    VisualRoom(client, world).show_devices(devices)
    Avatar(client, "slim", world.people[0].outfit).place(state.people[0])
    mounted = world.camera(camera)
    if isinstance(mounted, CeilingCamera):
        RobotModel(client, "mbot.urdf", Pose2D(0.0, 0.0, 0.0), fixed=True).place(state.robot)
        view = View(mounted.intrinsics, mounted.camera_in_world)
    else:
        view = View(mounted.intrinsics, camera_on_robot(state.robot.pose_in_world, 0.25, 1.2, 0.05))
    theirs = tiny_picture(client, view, world.light)
    pybullet.disconnect(physicsClientId=client)
    drawn = DrawnScene(world)
    ours = Raster.blank(view.intrinsics)
    bodies = [drawn.people(state.people)[0], *([drawn.robot(state.robot)] if camera != "onboard" else [])]
    for mesh in (*drawn.room(devices), *itertools.chain(*bodies)):
        draw(ours, mesh, view, world.light)
    drawn.close()
    for picture in (ours, theirs):
        picture.fill_empty((153, 145, 138))
    colours, depths = agrees(ours, theirs)
    assert colours > 0.9999, f"{colours} {depths}"
    assert depths > 0.999
    renderer = Renderer(world, seed=0)
    assert np.array_equal(renderer.render(camera, state), ours.colour)
    renderer.close()


def test_the_person_is_where_the_projection_says() -> None:
    world = real2(image_noise=0.0)
    renderer = Renderer(world, seed=0)
    camera = world.camera("camera1")
    assert isinstance(camera, CeilingCamera)
    changed = np.any(
        renderer.render("camera1", scene(Pose2D(20.0, 3.0, 0.0), Pose2D(5.0, 0.3, 0.0)))
        != renderer.calibration_image("camera1"),
        axis=-1,
    )
    rows, columns = np.nonzero(changed)
    pixels, _ = project(np.array([[5.0, 0.3, 0.0], [5.0, 0.3, 1.75]]), camera.intrinsics, camera.camera_in_world)
    assert abs(columns.mean() - pixels[0, 0]) < 8.0
    assert abs(rows.max() - pixels[0, 1]) < 15.0  # the shoes reach towards the camera
    assert abs(rows.min() - pixels[1, 1]) < 10.0
    renderer.close()


def test_the_onboard_camera_sees_the_person_ahead_and_not_its_own_robot() -> None:
    world = real2(image_noise=0.0)
    renderer = Renderer(world, seed=0)
    near, nobody = (
        renderer.render("onboard", scene(Pose2D(3.0, 0.0, 0.0), pose))
        for pose in (Pose2D(6.0, 0.0, 0.0), Pose2D(1.0, 0.0, 0.0))
    )
    rows, columns = np.nonzero(np.any(near != nobody, axis=-1))
    assert abs(columns.mean() - 320.0) < 15.0
    assert 200.0 < rows.max() - rows.min() < 320.0  # 1.75 m at 2.75 m and 416 px: 265 px
    view = View(world.camera("onboard").intrinsics, camera_on_robot(Pose2D(3.0, 0.0, 0.0), 0.25, 1.2, 0.05))
    empty = picture_of_room(DrawnScene(world), view, world.light, TV_OFF)
    empty.fill_empty((153, 153, 153))
    assert np.array_equal(nobody, empty.colour)
    renderer.close()


def test_a_picture_depends_on_the_state_alone_not_on_what_was_rendered_before() -> None:
    world = real2()
    first, second = (
        scene(Pose2D(2.0, 0.0, 0.0), Pose2D(4.5, 0.0, 0.0), number=4),
        scene(Pose2D(9.0, 0.5, 1.0), Pose2D(7.0, 0.0, 2.0), number=6),
    )
    one, other = Renderer(world, seed=5), Renderer(world, seed=5)
    for state in (second, first):
        other.render("camera2", state)
    for name in ("camera1", "onboard"):
        assert np.array_equal(one.render(name, first), other.render(name, first))
    one.close()
    other.close()


def test_a_television_that_goes_on_changes_its_screen_and_nothing_else() -> None:
    camera = CeilingCamera(name="tv_view", position=(19.5, 1.5, 1.8), look_at=(19.5, -3.4, 0.9))
    world = real2(image_noise=0.0, cameras=(camera,), furniture=())
    renderer = Renderer(world, seed=0)
    state = scene(Pose2D(1.0, 0.0, 0.0), Pose2D(4.0, 0.0, 0.0))
    off, on, off_again = (
        renderer.render("tv_view", replace(state, devices_on=devices)) for devices in (TV_OFF, TV_ON, TV_OFF)
    )
    assert np.array_equal(off, off_again)
    rows, columns = np.nonzero(np.any(off != on, axis=-1))
    corners, _ = project(np.array([[18.9, -3.36, 0.6], [20.1, -3.36, 1.3]]), camera.intrinsics, camera.camera_in_world)
    assert corners[:, 0].min() - 1 < columns.min() and columns.max() < corners[:, 0].max() + 1
    assert corners[:, 1].min() - 1 < rows.min() and rows.max() < corners[:, 1].max() + 1
    assert off[rows, columns].mean() < 30.0 < on[rows, columns].mean()
    renderer.close()


def test_noise_has_the_stated_deviation_and_is_fresh_in_every_frame() -> None:
    noise = ImageNoise(4.0, seed=1, largest_image=640 * 480 * 3)
    grey = np.full((480, 640, 3), 128, np.uint8)
    frames = [noise.add(grey, camera, number).astype(float) - 128.0 for camera, number in ((0, 0), (0, 2), (1, 0))]
    for frame in frames:
        assert frame.mean() == pytest.approx(0.0, abs=0.02)
        assert frame.std() == pytest.approx(4.0, abs=0.05)
    for one, other in ((0, 1), (0, 2), (1, 2)):
        assert abs(np.corrcoef(frames[one].ravel(), frames[other].ravel())[0, 1]) < 0.01
    assert np.array_equal(noise.add(grey, 0, 2), ImageNoise(4.0, 1, 640 * 480 * 3).add(grey, 0, 2))
    assert noise.add(np.full_like(grey, 254), 0, 0).min() > 200  # saturates, never wraps
    assert noise.add(np.full_like(grey, 1), 0, 0).max() < 55


def test_noise_of_zero_changes_nothing() -> None:
    image = np.random.default_rng(0).integers(0, 256, (64, 96, 3), dtype=np.uint8)
    assert np.array_equal(ImageNoise(0.0, 0, image.size).add(image, 3, 9), image)


def test_every_tile_of_a_room_is_small_and_wound_towards_its_normal() -> None:
    table = Furniture(name="table", position=(20.0, 2.0), yaw=0.4, size=(2.2, 1.4, 0.7))
    for surface in room_surfaces(real2(furniture=(table,))).values():
        corners = surface.vertices[surface.triangles]
        edges = corners - np.roll(corners, 1, axis=1)
        assert np.linalg.norm(edges, axis=-1).max() <= math.sqrt(2.0) * LARGEST_TILE + 1e-9
        facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert (np.einsum("ij,ij->i", facing, surface.normals[surface.triangles[:, 0]]) > 0.0).all()


def test_box_sides_face_outward_and_have_the_boxs_area() -> None:
    (box,) = real2(walls=(), devices=()).solid_boxes()
    sides = box_sides(box, with_bottom=True)
    x, y, z = box.size
    area = 0.0
    for side in sides:
        assert (np.einsum("ij,ij->i", side.vertices - box.centre_in_world, side.normals) > 0.0).all()
        corners = side.vertices[side.triangles]
        area += (
            0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
        )
    assert area == pytest.approx(2.0 * (x * y + y * z + z * x))


def test_an_unknown_texture_is_named_with_those_that_exist() -> None:
    world = load_world("real2")
    bad = world.model_copy(update={"floor": (world.floor[0].model_copy(update={"texture": "marble"}),)})
    with pytest.raises(BadInputError, match=r"'marble'.*parquet"):
        Renderer(bad, seed=0).calibration_image("camera1")


def test_a_moving_camera_has_no_calibration_image() -> None:
    with pytest.raises(BadInputError, match="onboard"):
        Renderer(load_world("real2"), seed=0).calibration_image("onboard")
