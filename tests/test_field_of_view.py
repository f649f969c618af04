"""What a camera sees: whole, tall enough, not hidden."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.errors import BadInputError
from han_bullet.geometry import Array, Intrinsics, Pose2D, SolidBox, look_at, project
from han_bullet.messages import Frame
from han_bullet.tracking.field_of_view import BODY_MIDDLE, LOWER_MARGIN, FieldOfView

INTRINSICS = Intrinsics.from_vertical_field_of_view(640, 480, math.radians(45.0))
EMPTY = np.zeros((480, 640, 3), np.uint8)


def camera(position: list[float], target: list[float], fixed: bool = True) -> Frame:
    return Frame("camera", 0.0, EMPTY, INTRINSICS, look_at(np.array(position), np.array(target)), fixed)


CEILING = camera([0.2, 0.0, 2.6], [6.2, 0.0, 0.9])
OPEN = FieldOfView()


def at(*places: tuple[float, float]) -> Array:
    return np.array(places, float).reshape(-1, 2)


def test_a_ceiling_camera_sees_whole_people_from_its_lower_border_to_where_they_are_114_pixels_tall() -> None:
    places = np.column_stack([np.arange(0.5, 14.0, 0.05), np.zeros(270)])
    seen = places[OPEN.sees(CEILING, places), 0]
    assert np.diff(seen) == pytest.approx(0.05)
    foot = project(np.array([seen[0], 0.0, 0.0]), INTRINSICS, CEILING.camera_in_world)[0]
    assert 466.0 < foot[1] <= 474.0
    ends = project(np.array([[seen[-1], 0.0, 0.0], [seen[-1], 0.0, 1.75]]), INTRINSICS, CEILING.camera_in_world)[0]
    assert 114.0 <= ends[0, 1] - ends[1, 1] < 115.0
    assert seen[0] == pytest.approx(3.6, abs=0.2)
    assert seen[-1] == pytest.approx(8.9, abs=0.2)


def test_a_moving_camera_does_not_miss_people_whose_feet_are_at_the_lower_border() -> None:
    """Their boxes are no measurement, and who is near must not be given up for it."""
    onboard = camera([0.0, 0.0, 1.2], [10.0, 0.0, 0.7], fixed=False)
    still = camera([0.0, 0.0, 1.2], [10.0, 0.0, 0.7])
    places = np.column_stack([np.arange(1.5, 6.0, 0.02), np.zeros(225)])
    moving_sees, still_sees = places[OPEN.sees(onboard, places), 0], places[OPEN.sees(still, places), 0]
    assert moving_sees[-1] == still_sees[-1]
    assert moving_sees[0] > still_sees[0] + 0.1
    body = np.array([[moving_sees[0], 0.0, 0.0], [moving_sees[0], 0.0, 1.75]])
    foot, head = project(body, INTRINSICS, onboard.camera_in_world)[0]
    assert 480.0 - foot[1] == pytest.approx(LOWER_MARGIN * (foot[1] - head[1]), abs=3.0)


def test_nobody_is_seen_behind_the_camera_or_beside_the_image() -> None:
    assert OPEN.sees(CEILING, at((-5.0, 0.0), (4.0, 3.0), (6.0, 0.0))).tolist() == [False, False, True]


def test_nobody_is_seen_whose_head_is_behind_a_low_camera_that_looks_down() -> None:
    """What is behind a camera has a place in the formula's image too."""
    assert OPEN.sees(camera([0.0, 0.0, 1.2], [0.2, 0.0, 0.0]), at((-0.25, -0.1))).tolist() == [False]


def test_walls_hide_people_and_a_low_couch_does_not() -> None:
    wall = SolidBox("wall0", "wall", np.array([5.0, 0.5, 1.4]), np.array([0.1, 1.0, 2.8]), 0.0)
    couch = SolidBox("couch", "object", np.array([5.0, -0.5, 0.4]), np.array([0.8, 1.0, 0.8]), 0.0)
    view = FieldOfView([wall, couch])
    assert OPEN.sees(CEILING, at((7.0, 0.5), (7.0, -0.5))).tolist() == [True, True]
    assert view.sees(CEILING, at((7.0, 0.5), (7.0, -0.5), (4.5, 0.3))).tolist() == [False, True, True]


@pytest.mark.parametrize(("height", "seen"), [(0.9, True), (1.1, False)])
def test_furniture_hides_whoever_shows_less_than_their_upper_half(height: float, seen: bool) -> None:
    """The line of sight to a person's middle passes the far edge of what stands before them at 1.0 m."""
    shelf = SolidBox("shelf", "object", np.array([6.4, 0.0, 0.5 * height]), np.array([0.4, 1.0, height]), 0.0)
    assert FieldOfView([shelf]).sees(CEILING, at((7.0, 0.0))).tolist() == [seen]


def test_a_camera_let_into_a_wall_is_not_blind() -> None:
    wall = SolidBox("wall0", "wall", np.array([0.2, 0.0, 1.4]), np.array([0.1, 3.0, 2.8]), 0.0)
    assert FieldOfView([wall]).sees(CEILING, at((6.0, 0.0))).tolist() == [True]


def test_the_robot_hides_who_stands_close_behind_it_from_a_ceiling_camera() -> None:
    robot = Pose2D(5.0, 0.0, 0.0)
    places = at((5.7, 0.0), (5.7, 0.8), (4.3, 0.0), (8.5, 0.0))
    # 3.5 m behind, the line of sight to the knees passes 1.4 m over the floor where the robot stands.
    assert OPEN.sees(CEILING, places, robot=robot).tolist() == [False, True, True, True]
    assert OPEN.sees(CEILING, places).all()


@pytest.mark.parametrize(("radius", "seen"), [(0.25, True), (0.35, False), (0.45, False)])
def test_a_wider_robot_hides_more(radius: float, seen: bool) -> None:
    beside, robot = at((5.7, 0.35)), Pose2D(5.0, 0.0, 0.0)
    assert FieldOfView(robot_radius=radius).sees(CEILING, beside, robot=robot).tolist() == [seen]
    assert OPEN.sees(CEILING, beside, robot=robot).tolist() == [False]  # 0.35 m is the default


@pytest.mark.parametrize("radius", [0.0, -0.3, math.nan])
def test_a_robot_without_a_radius_is_refused(radius: float) -> None:
    with pytest.raises(BadInputError, match=f"robot_radius is {radius};"):
        FieldOfView(robot_radius=radius)


@pytest.mark.parametrize(("ahead", "height"), [(0.25, 1.2), (-0.15, 1.0)])
def test_the_camera_on_the_robot_is_not_hidden_by_the_robot(ahead: float, height: float) -> None:
    onboard = camera([1.0 + ahead, 0.0, height], [5.0 + ahead, 0.0, height - 0.2], fixed=False)
    assert OPEN.sees(onboard, at((5.0, 0.0)), robot=Pose2D(1.0, 0.0, 0.0)).tolist() == [True]


def test_people_hide_others_behind_them_and_nobody_hides_themselves() -> None:
    people = at((5.0, 0.0), (5.8, 0.1), (5.8, 0.9))
    assert OPEN.hidden_by_people(CEILING, people, people).tolist() == [False, True, False]


def test_no_places_give_no_answers() -> None:
    assert OPEN.sees(CEILING, np.zeros((0, 2))).shape == (0,)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_furniture_hides_whom_each_box_blocks(seed: int) -> None:
    rng = np.random.default_rng(seed)
    boxes = [
        SolidBox("box", "object", rng.uniform((0, -3, 0), (10, 3, 2)), rng.uniform(0.05, 2.0, 3), rng.uniform(-4, 4))
        for _ in range(6)
    ]
    places = np.column_stack([rng.uniform(4.0, 8.0, 40), rng.uniform(-1.5, 1.5, 40)])
    eye, middles = CEILING.camera_in_world[:3, 3], np.column_stack([places, np.full(40, BODY_MIDDLE)])
    expected = FieldOfView().sees(CEILING, places)
    assert expected.any()
    for box in boxes:
        if not box.contains(eye[:2]):
            expected &= ~box.blocks(eye, middles)
    assert FieldOfView(boxes).sees(CEILING, places).tolist() == expected.tolist()
