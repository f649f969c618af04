"""What pictures tell of the cameras that took them, on rendered scenes with people."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from han_bullet.detection.image_health import image_health
from han_bullet.detection.scene_shift import scene_shift
from han_bullet.detection.still_scene import StillScene
from han_bullet.geometry import Pose2D
from han_bullet.messages import Posture
from han_bullet.sim.gait import Gait
from han_bullet.sim.renderer import Renderer
from han_bullet.sim.scene_state import Exposure, RobotPosture, SceneState
from han_bullet.world_file import load_world

WORLD = load_world("real2")
PIXELS_PER_DEGREE = 240.0 / np.tan(np.radians(22.5)) * np.radians(1.0)  # in the middle of the image
TV_ON = (("tv", True),)


@pytest.fixture(scope="module")
def renderer() -> Renderer:
    return Renderer(WORLD, 0)


def look(renderer: Renderer, camera: str, degrees: float, near: float = 4.0) -> tuple[float, float]:
    """How far the empty scene of a camera has moved in a picture with a person some way before it [m]."""
    scene = StillScene(renderer.calibration_image(camera), np.zeros((0, 4)))
    x, y, _ = WORLD.camera(camera).position  # type: ignore[union-attr]
    towards = np.array(WORLD.camera(camera).look_at[:2]) - (x, y)  # type: ignore[union-attr]
    place = (x, y) + near * towards / np.hypot(*towards)
    pose = Pose2D(float(place[0]), float(place[1]), 0.0)
    body = Gait("slim").advance(pose, 0.0, 0.05, Posture.STANDING)
    state = SceneState(0.0, 7, RobotPosture(Pose2D(3.0, 0.6, 0.0)), (body,), TV_ON)
    knocked = Exposure(camera, 0.0, state, turned=float(np.radians(degrees)))
    image = renderer.render(camera, replace(state, exposures=(knocked,)))
    return scene.shift(image, scene.changes(image))


@pytest.mark.parametrize("camera", ["camera1", "camera2", "camera3", "camera4"])
@pytest.mark.parametrize("near", [2.5, 4.0])
def test_a_person_the_robot_and_a_television_that_goes_on_move_no_scene(
    renderer: Renderer, camera: str, near: float
) -> None:
    assert look(renderer, camera, 0.0, near) == (0.0, 0.0)


@pytest.mark.parametrize("camera", ["camera1", "camera2", "camera3", "camera4"])
@pytest.mark.parametrize("degrees", [-3.0, 0.5, 3.0])
def test_the_scene_of_a_knocked_camera_has_moved_by_the_angle(renderer: Renderer, camera: str, degrees: float) -> None:
    right, down = look(renderer, camera, degrees)
    # Camera 4 looks down steeply: a turn about the vertical is partly one about its view, which moves the middle less.
    assert 0.6 * abs(degrees) < abs(right) / PIXELS_PER_DEGREE < 1.1 * abs(degrees)
    assert np.sign(right) == np.sign(degrees) and abs(down) < 4.0


def test_what_only_differs_is_no_shift() -> None:
    rng = np.random.default_rng(0)
    one, other = (rng.integers(0, 255, (30, 40, 3), np.uint8) for _ in range(2))
    assert scene_shift(one, other) == (0.0, 0.0)
    assert scene_shift(one, np.zeros_like(one)) == (0.0, 0.0)
    assert scene_shift(one, np.roll(one, 3, axis=1)) == pytest.approx((3.0, 0.0), abs=0.5)


def test_asking_for_a_shift_leaves_the_pictures_as_they_are() -> None:
    rng = np.random.default_rng(1)
    one, other = (rng.integers(0, 255, (30, 40, 3), np.uint8) for _ in range(2))
    before = one.copy(), other.copy()
    scene_shift(one, other)
    assert np.array_equal(one, before[0]) and np.array_equal(other, before[1])


def test_equal_pictures_have_equal_checksums_and_other_noise_another() -> None:
    rng = np.random.default_rng(2)
    image = rng.integers(100, 120, (48, 64, 3), np.uint8)
    assert image_health(image) == image_health(image.copy())
    noisy = image + rng.integers(0, 2, image.shape, np.uint8)
    assert image_health(noisy).checksum != image_health(image).checksum


def test_brightness_and_contrast_are_those_of_the_picture_and_not_of_its_noise() -> None:
    rng = np.random.default_rng(3)
    flat = rng.integers(95, 106, (480, 640, 3), np.uint8)
    assert image_health(flat).brightness == pytest.approx(100.0, abs=0.5) and image_health(flat).contrast < 0.5
    halves = flat.copy()
    halves[:, 320:] += 100
    assert image_health(halves).brightness == pytest.approx(150.0, abs=0.5)
    assert image_health(halves).contrast == pytest.approx(50.0, abs=0.5)
