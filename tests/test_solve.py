"""Solving cameras: known ones from their own points, with noise, with a wrong point, and what cannot be solved."""

import math
from dataclasses import replace

import numpy as np
import pytest
from floor_points import CAMERAS, floor_points, tilted_camera
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from han_bullet.calibration.calibration import Calibration
from han_bullet.calibration.lens import Distortion
from han_bullet.calibration.points import MarkedPoints
from han_bullet.calibration.solve import Solution, solve
from han_bullet.errors import BadInputError
from han_bullet.geometry import Intrinsics, project
from han_bullet.world_schema import CeilingCamera

SIZE = (640, 480)
LENS = Intrinsics.from_vertical_field_of_view(*SIZE, math.radians(60.0))
KNOWN = pytest.mark.parametrize("known", [True, False], ids=["focal length given", "focal length solved"])
EACH_CAMERA = pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.name)


def solved(camera: CeilingCamera, points: MarkedPoints, known: bool) -> Solution:
    return solve(points, camera.size, camera.intrinsics if known else None, name=camera.name)


def errors(solution: Solution, camera: CeilingCamera) -> tuple[float, float, float]:
    """Of the position [m], of the direction of the axes and of the focal length, relative."""
    pose, focal = solution.calibration.camera_in_world, solution.calibration.intrinsics.fx
    off = np.abs(pose - camera.camera_in_world)
    return float(np.linalg.norm(off[:3, 3])), float(off[:3, :3].max()), abs(focal / camera.intrinsics.fx - 1.0)


@KNOWN
@EACH_CAMERA
def test_the_cameras_of_the_building_are_recovered_from_exact_points(camera: CeilingCamera, known: bool) -> None:
    for count in (6, 12):
        points = floor_points(camera.intrinsics, camera.camera_in_world, count, np.random.default_rng(count))
        solution = solved(camera, points, known)
        assert max(errors(solution, camera)) < 1e-6
        assert solution.calibration.pixel_errors().max() < 1e-6
        assert solution.left_out is None
        assert (solution.focal_deviation is None) == known


@EACH_CAMERA
def test_four_points_are_enough_where_the_focal_length_is_known(camera: CeilingCamera) -> None:
    points = floor_points(camera.intrinsics, camera.camera_in_world, 4, np.random.default_rng(4))
    assert max(errors(solved(camera, points, True), camera)) < 1e-6


@EACH_CAMERA
def test_with_a_pixel_of_noise_place_direction_and_focal_length_stay_within_bounds(camera: CeilingCamera) -> None:
    for known, far, turned, longer in ((True, 0.06, 0.01, 0.0), (False, 0.25, 0.02, 0.05)):
        worst = np.zeros(3)
        for seed in range(5):
            rng = np.random.default_rng(seed)
            points = floor_points(camera.intrinsics, camera.camera_in_world, 12, rng, noise=1.0)
            worst = np.maximum(worst, errors(solved(camera, points, known), camera))
        assert np.all(worst <= (far, turned, longer)), worst
        assert worst[0] > 1e-3  # the noise was there


def test_the_deviations_are_those_of_many_calibrations() -> None:
    camera = CAMERAS[0]
    exact = floor_points(camera.intrinsics, camera.camera_in_world, 12, np.random.default_rng(0))
    rng = np.random.default_rng(1)
    ratios = []
    for _ in range(30):
        noisy = replace(exact, pixels=np.clip(exact.pixels + rng.normal(size=exact.pixels.shape), 0.0, 480.0 - 1e-3))
        keep = np.abs(noisy.pixels - exact.pixels).max(axis=1) < 5.0  # not those that clipping moved
        noisy = MarkedPoints(noisy.pixels[keep], noisy.points_in_world[keep])
        solution = solved(camera, noisy, False)
        assert solution.focal_deviation is not None
        off = solution.calibration.camera_in_world[:3, 3] - camera.camera_in_world[:3, 3]
        focal = (solution.calibration.intrinsics.fx - camera.intrinsics.fx) / solution.focal_deviation
        ratios.append([*(off / solution.position_deviation), focal])
    spread = np.sqrt(np.mean(np.square(ratios), axis=0))
    assert np.all((spread > 0.5) & (spread < 1.4)), spread  # they assume 1 px at least, so they are a little cautious


@settings(max_examples=25)
@given(
    height=st.floats(1.5, 6.0),
    down=st.floats(15.0, 65.0),
    roll=st.floats(-30.0, 30.0),
    angle=st.floats(35.0, 90.0),
    seed=st.integers(0, 1000),
)
def test_any_camera_that_looks_down_at_a_slant_is_recovered(
    height: float, down: float, roll: float, angle: float, seed: int
) -> None:
    lens = Intrinsics.from_vertical_field_of_view(*SIZE, math.radians(angle))
    pose = tilted_camera(height, math.radians(down), math.radians(roll))
    points = floor_points(lens, pose, 10, np.random.default_rng(seed))
    try:
        calibration = solve(points, SIZE).calibration
    except BadInputError as error:
        assume("leave the focal length open" not in str(error))  # by chance close together
        raise
    assert calibration.intrinsics.fx == pytest.approx(lens.fx, rel=1e-5)
    assert calibration.camera_in_world == pytest.approx(pose, abs=1e-4)
    assert np.degrees(calibration.view_angles()) == pytest.approx([0.0, down, roll], abs=1e-3)


@given(st.floats(-8.0, 8.0), st.floats(-8.0, 8.0), st.floats(0.0, 1.5))
def test_projecting_a_point_and_back_onto_its_plane_gives_it_again(x: float, y: float, z: float) -> None:
    pose = tilted_camera(2.6, math.radians(30.0), 0.2)
    place = np.array([[x, y, z]])
    pixel, depth = project(place, LENS, pose)
    assume(depth[0] > 0.1)
    calibration = Calibration("camera", LENS, pose)
    back, in_front = calibration.on_plane(pixel, place[:, 2])
    assert in_front[0] and back[0] == pytest.approx([x, y], abs=1e-6)
    if z == 0.0:
        on_floor = calibration.homography @ [*pixel[0], 1.0]
        assert on_floor[:2] / on_floor[2] == pytest.approx([x, y], abs=1e-6)


def test_points_above_the_floor_help_as_well() -> None:
    camera = CAMERAS[0]
    rng = np.random.default_rng(3)
    places = np.column_stack([rng.uniform(4.5, 10.0, 8), rng.uniform(-1.0, 1.0, 8), rng.uniform(0.0, 2.0, 8)])
    pixels, _ = project(places, camera.intrinsics, camera.camera_in_world)
    assert max(errors(solved(camera, MarkedPoints(pixels, places), False), camera)) < 1e-6


def test_a_distorted_image_gives_the_same_camera_once_its_lens_is_known() -> None:
    camera = CAMERAS[0]
    points = floor_points(camera.intrinsics, camera.camera_in_world, 10, np.random.default_rng(5))
    lens = Distortion("plumb_bob", np.array([-0.25, 0.08, 1e-3, -5e-4, 0.0]))
    bent = replace(points, pixels=lens.distort(points.pixels, camera.intrinsics))
    assert np.abs(bent.pixels - points.pixels).max() > 5.0
    solution = solve(bent, camera.size, camera.intrinsics, lens)
    assert max(errors(solution, camera)) < 1e-5
    assert solution.calibration.points is bent
    straight = solve(bent, camera.size, camera.intrinsics)
    assert errors(straight, camera)[0] > 0.02  # without its lens it is another


@KNOWN
@EACH_CAMERA
def test_a_point_that_is_marked_wrong_is_named_and_left_out(camera: CeilingCamera, known: bool) -> None:
    for seed in range(2):
        rng = np.random.default_rng(seed)
        points = floor_points(camera.intrinsics, camera.camera_in_world, 10, rng, noise=0.5)
        rows, wrong = points.rows(), int(rng.integers(10))
        rows[wrong][0] += 43.0 if rows[wrong][0] < 320.0 else -43.0
        solution = solved(camera, MarkedPoints.of_rows(rows), known)
        assert solution.left_out == wrong
        off = solution.calibration.pixel_errors()
        assert off[wrong] == pytest.approx(43.0, abs=15.0)
        assert np.delete(off, wrong).max() < 3.0


def test_a_metre_typed_wrong_is_named_too() -> None:
    camera = CAMERAS[1]
    rows = floor_points(camera.intrinsics, camera.camera_in_world, 8, np.random.default_rng(0)).rows()
    rows[5][3] += 1.0
    assert solved(camera, MarkedPoints.of_rows(rows), True).left_out == 5


@EACH_CAMERA
def test_nobody_is_accused_where_all_points_are_a_little_off(camera: CeilingCamera) -> None:
    for seed in range(5):
        points = floor_points(camera.intrinsics, camera.camera_in_world, 8, np.random.default_rng(seed), noise=4.0)
        solution = solved(camera, points, True)
        assert solution.left_out is None
        assert solution.calibration.pixel_errors().max() > 3.0


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_a_camera_that_looks_straight_down_needs_its_focal_length(noise: float) -> None:
    pose = tilted_camera(3.0, math.radians(89.999))
    points = floor_points(LENS, pose, 10, np.random.default_rng(1), noise)
    with pytest.raises(BadInputError, match=r"focal length open.*straight down.*--field-of-view DEG, --focal PX or"):
        solve(points, SIZE)
    pose_solved = solve(points, SIZE, LENS).calibration.camera_in_world
    assert np.linalg.norm(pose_solved[:3, 3] - [0.0, 0.0, 3.0]) < (0.1 if noise else 1e-6)


def test_points_that_are_mirrored_put_the_camera_under_the_floor() -> None:
    camera = CAMERAS[0]
    points = floor_points(camera.intrinsics, camera.camera_in_world, 8, np.random.default_rng(0))
    mirrored = replace(points, points_in_world=points.points_in_world * (1.0, -1.0, 1.0))
    with pytest.raises(BadInputError, match=r"2\.60 m under the floor.*y points to the left of x"):
        solved(camera, mirrored, True)


def sky_or_behind(camera: CeilingCamera, behind: bool) -> tuple[list[list[float]], int]:
    rows = floor_points(camera.intrinsics, camera.camera_in_world, 9, np.random.default_rng(2)).rows()
    if behind:
        place = np.array([camera.position[0] - 1.0, camera.position[1] + 0.1, 0.0])
        pixel, depth = project(place, camera.intrinsics, camera.camera_in_world)
        assert depth < 0.0
        rows[4] = [*np.clip(pixel, 0.0, 480.0).tolist(), *place]
    else:
        rows[4][1] = 20.0
    return rows, 4


@KNOWN
@pytest.mark.parametrize("behind", [True, False], ids=["behind", "sky"])
def test_a_floor_point_above_the_horizon_or_behind_the_camera_is_refused_by_its_number(
    behind: bool, known: bool
) -> None:
    rows, wrong = sky_or_behind(CAMERAS[0], behind)
    with pytest.raises(BadInputError, match=f"point {wrong + 1} .*behind their camera or above its horizon"):
        solved(CAMERAS[0], MarkedPoints.of_rows(rows), known)


def test_points_in_a_corner_do_not_tell_the_place() -> None:
    pose = tilted_camera(2.6, math.radians(30.0))
    for side, message in (
        (0.06, r"tell the camera's place only to .* m; check them"),
        (0.005, "mark them farther apart"),
    ):
        places = np.array([[4.5, 0.0, 0.0], [4.5 + side, 0.0, 0.0], [4.5 + side, side, 0.0], [4.5, side, 0.0]])
        pixels, _ = project(places, LENS, pose)
        with pytest.raises(BadInputError, match=message):
            solve(MarkedPoints(pixels, places), SIZE, LENS)
