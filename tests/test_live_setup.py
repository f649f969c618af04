"""A real robot's configuration: checked, and read with all that it names."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from live_robot import CONFIG, write_live_robot

from han_bullet.calibration.calibration import Calibration
from han_bullet.calibration.lens import Distortion
from han_bullet.calibration.points import MarkedPoints
from han_bullet.detection.pictures import read_picture
from han_bullet.errors import BadInputError
from han_bullet.geometry import Pose2D
from han_bullet.ros.live_setup import load_live_setup
from han_bullet.world_file import load_world
from han_bullet.world_schema import CeilingCamera

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where a world and its cameras' calibrations lie."""
    folder = tmp_path_factory.mktemp("robot")
    write_live_robot(folder)
    return folder


def write(folder: Path, text: str) -> Path:
    path = folder / "changed.yaml"
    path.write_text(text)
    return path


def test_calibrated_cameras_hang_where_the_solver_found_them(folder: Path) -> None:
    setup, world = load_live_setup(folder / "robot.yaml"), load_world(folder / "world.yaml")
    assert [camera.mounted.name for camera in setup.cameras] == ["camera1", "camera2"]
    for camera in setup.cameras:
        true = world.camera(camera.mounted.name)
        assert isinstance(true, CeilingCamera)
        off = np.linalg.norm(camera.mounted.mount[:3, 3] - true.camera_in_world[:3, 3])
        assert 0.0 < off < 0.1 and camera.mounted.fixed
        assert camera.mounted.intrinsics.fx == pytest.approx(true.intrinsics.fx, rel=0.03)
        assert camera.empty_scene is not None and camera.empty_scene.shape == (480, 640, 3)
        assert camera.period == pytest.approx(0.2)


def test_the_world_of_a_real_robot_has_its_cameras_in_use_and_nobody_in_it(folder: Path) -> None:
    setup = load_live_setup(folder / "robot.yaml")
    assert setup.world.people == () and setup.world.faults == ()
    assert [(camera.name, camera.rate) for camera in setup.world.cameras] == [("camera1", 5.0), ("camera2", 5.0)]
    for camera, stand_in in zip(setup.cameras, setup.world.cameras, strict=True):
        assert isinstance(stand_in, CeilingCamera)
        np.testing.assert_allclose(stand_in.camera_in_world[:3, 2:], camera.mounted.mount[:3, 2:], atol=1e-9)
        assert stand_in.intrinsics.fy == pytest.approx(camera.mounted.intrinsics.fy)


def test_topics_have_their_usual_names_and_a_scanner_the_place_of_the_world_file(folder: Path) -> None:
    setup = load_live_setup(folder / "robot.yaml")
    assert (setup.odometry, setup.command, setup.laser) == ("/odom", "/cmd_vel", "/scan")
    assert setup.goal == "/move_base_simple/goal"
    assert setup.scanner_in_body == Pose2D(0.2, 0.0, 0.0)


def test_a_scanner_may_be_mounted_elsewhere_and_a_robot_may_have_none(folder: Path) -> None:
    mounted = CONFIG.replace("{topic: /scan}", "{topic: front/scan, mount: [-0.1, 0.05, 3.14], rate: 5}")
    setup = load_live_setup(write(folder, mounted))
    assert setup.laser == "/front/scan" and setup.scanner_in_body == Pose2D(-0.1, 0.05, 3.14)
    assert setup.world.robot.laser is not None and setup.world.robot.laser.rate == 5.0
    without = CONFIG.replace("laser: {topic: /scan}\n", "").replace("lidar", "odometry")
    setup = load_live_setup(write(folder, without))
    assert setup.laser is None and setup.world.robot.laser is None


def test_a_camera_without_calibration_is_the_world_files_own_as_the_robots_is(folder: Path) -> None:
    text = CONFIG.replace("world.yaml", "real2").split("  - {name: camera1")[0]
    text += "  - {name: onboard, topic: /head/image_raw}\nlocalization: odometry\n"
    (camera,) = load_live_setup(write(folder, text)).cameras
    own = load_world("real2").camera("onboard")
    assert camera.mounted.intrinsics == own.intrinsics and not camera.mounted.fixed
    assert camera.period == pytest.approx(1.0 / own.rate)


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("localization: lidar", "localisation: lidar", "localisation: unknown key; see docs/ros_live.md"),
        ("localization: lidar", "localization: gps", "localization: Input should be 'lidar' or 'odometry'"),
        ("laser: {topic: /scan}\n", "", "localization is 'lidar', but no laser is given"),
        (
            "localization: lidar",
            "localization: lidar\ncommand: {topic: cmd_vel_teleop}",
            "'/cmd_vel_teleop', on which the robot is driven by hand",
        ),
        ("/scan", "/odom", "topic '/odom' is given twice"),
        ("/scan", "odom", "topic '/odom' is given twice"),
        ("name: camera2", "name: camera1", "camera name 'camera1' is given twice"),
        ("name: camera2", "name: laser", "cameras: the name 'laser' stands for something else in faults"),
        ("name: camera2", "name: tv", "devices: the name 'tv' is a camera's, too"),
        ("/camera2/image_raw", "no topic", r"cameras\[1\].topic: String should match"),
        ("rate: 5}", "rate: 7}", "7 s is not an integer multiple of the control period"),
        ("camera1.yaml", "nothing.yaml", "nothing.yaml: not readable"),
        ("camera1.png", "nothing.png", "nothing.png cannot be read: No such file"),
        ("world.yaml", "nowhere", "world 'nowhere' is not known"),
    ],
)
def test_what_is_wrong_is_told_in_a_sentence_with_file_and_field(folder: Path, old: str, new: str, reason: str) -> None:
    assert old in CONFIG
    path = write(folder, CONFIG.replace(old, new))
    with pytest.raises(BadInputError, match=reason) as caught:
        load_live_setup(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)


def test_an_empty_scene_of_another_size_than_the_camera_is_refused(folder: Path) -> None:
    before, after = (folder / "world.yaml").read_text().split("{name: camera2")
    (folder / "small.yaml").write_text(before + "{name: camera2, size: [320, 240]" + after)
    text = CONFIG.replace("calibration: camera2.yaml, ", "").replace("world.yaml", "small.yaml")
    with pytest.raises(BadInputError, match="is 640 x 480 px; 320 x 240 is right"):
        load_live_setup(write(folder, text))


def test_an_empty_scene_is_undistorted_like_the_images_that_are_held_against_it(folder: Path) -> None:
    bent = replace(
        Calibration.load(folder / "camera1.yaml"),
        distortion=Distortion("plumb_bob", np.array([-0.3, 0.1, 0.0, 0.0, 0.0])),
        points=MarkedPoints.of_rows([]),
    )
    bent.save(folder / "bent.yaml", "of a test")
    camera = load_live_setup(write(folder, CONFIG.replace("camera1.yaml", "bent.yaml"))).cameras[0]
    picture = read_picture(folder / "camera1.png")
    assert camera.empty_scene is not None
    np.testing.assert_array_equal(camera.empty_scene, bent.undistort(picture))
    assert (camera.empty_scene != picture).mean() > 0.3


def test_a_camera_that_looks_straight_down_is_refused_since_nobody_is_recognized_from_there(folder: Path) -> None:
    down = np.diag([1.0, -1.0, -1.0, 1.0])
    down[2, 3] = 2.6
    text = (
        "name: camera1\nsize: [640, 480]\nintrinsics: {fx: 580.0, fy: 580.0, cx: 320.0, cy: 240.0}\n"
        f"camera_in_world: {json.dumps(down.tolist())}\n"
    )
    (folder / "down.yaml").write_text(text)
    with pytest.raises(BadInputError, match="looks straight down"):
        load_live_setup(write(folder, CONFIG.replace("camera1.yaml", "down.yaml")))


def test_the_example_is_a_robot_in_the_corridor_of_real2() -> None:
    setup = load_live_setup(ROOT / "ros1_bridge" / "config" / "real2.yaml")
    assert [camera.mounted.name for camera in setup.cameras] == ["camera1", "camera2", "camera3", "onboard"]
    assert (setup.world.name, setup.localization, setup.laser) == ("real2", "lidar", "/scan")


def test_what_is_no_yaml_or_no_mapping_is_refused(folder: Path) -> None:
    for text in ("{", "- 1\n", ""):
        with pytest.raises(BadInputError):
            load_live_setup(write(folder, text))
    with pytest.raises(BadInputError, match="not readable as YAML"):
        load_live_setup(folder / "missing.yaml")
