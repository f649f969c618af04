"""Why a camera does not show somebody, in words; and that the words agree with the field of view."""

import numpy as np
import pytest

from han_bullet.assembly import field_of_view
from han_bullet.coverage import empty_frame
from han_bullet.geometry import Pose2D, SolidBox
from han_bullet.messages import Frame
from han_bullet.tracking.field_of_view import FieldOfView
from han_bullet.tracking.sight import expected_box, why_unseen
from han_bullet.world_file import load_world

WORLD = load_world("real2")
FAR_AWAY = Pose2D(-50.0, 0.0, 0.0)


def view_of(camera: str, robot: Pose2D = FAR_AWAY) -> Frame:
    return empty_frame(WORLD.camera(camera), robot)


def reason(x: float, y: float, camera: str = "camera1", view: FieldOfView | None = None) -> str | None:
    return why_unseen(view or FieldOfView(), view_of(camera), np.array([x, y]), FAR_AWAY, {})


def test_somebody_whole_and_near_needs_no_reason() -> None:
    assert reason(6.0, 0.0) is None


@pytest.mark.parametrize(
    ("x", "y", "camera", "words"),
    [
        (6.0, 0.0, "camera2", "behind the camera"),
        (4.0, 3.0, "camera1", "outside the image"),
        (2.8, 0.0, "camera1", "cut by the image's lower border"),
        (6.0, 3.3, "camera1", "cut by the image's left border"),
        (9.9, 0.0, "camera1", "too far: the box would be 102 px tall, and a miss counts from 114 px on"),
    ],
)
def test_where_somebody_is_not_in_the_image_the_reason_says_how(x: float, y: float, camera: str, words: str) -> None:
    assert reason(x, y, camera) == words


def test_what_hides_somebody_is_named() -> None:
    couch = SolidBox("couch", "object", np.array([5.0, 0.0, 0.8]), np.array([0.5, 1.0, 1.6]), 0.0)
    frame, place = view_of("camera1"), np.array([5.8, 0.0])
    assert why_unseen(FieldOfView([couch]), frame, place, FAR_AWAY, {}) == "hidden by couch"
    assert why_unseen(FieldOfView(), frame, place, Pose2D(5.2, 0.0, 0.0), {}) == "hidden by the robot"
    assert why_unseen(FieldOfView(), frame, place, FAR_AWAY, {"anna": np.array([5.2, 0.0])}) == "hidden by anna"


def test_there_is_a_reason_wherever_the_field_of_view_sees_nobody_and_only_there() -> None:
    view, robot, other = field_of_view(WORLD), Pose2D(6.0, 0.3, 0.0), np.array([[11.0, -0.4]])
    places = np.stack(np.meshgrid(np.arange(0.3, 23.0, 0.35), np.arange(-3.3, 3.4, 0.35)), axis=-1).reshape(-1, 2)
    told = 0
    for camera in WORLD.cameras:
        frame = empty_frame(camera, robot)
        seen = view.sees(frame, places, robot=robot) & ~view.hidden_by_people(frame, places, other)
        reasons = [why_unseen(view, frame, place, robot, {"bob": other[0]}) for place in places]
        assert [one is None for one in reasons] == seen.tolist()
        told += sum(one is None for one in reasons)
    assert told > 100


def test_the_box_of_an_upright_person_spans_from_head_to_foot() -> None:
    box = expected_box(view_of("camera1"), np.array([6.0, 0.0]))
    assert box is not None
    assert box == pytest.approx([320.0 - 0.205 * box[3], box[1], 0.41 * box[3], box[3]])
    assert 160.0 < box[3] < 180.0
    assert expected_box(view_of("camera2"), np.array([6.0, 0.0])) is None
