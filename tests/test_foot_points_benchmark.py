"""The benchmark of foot points: its errors have the right signs, and known feet are held against boxes."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.foot_points import WAYS, FootError, FootPoints, rows
from han_bullet.geometry import Intrinsics, Pose2D, look_at, project
from han_bullet.messages import CameraImage, Detections, PoseEstimate, Posture
from han_bullet.tracking.projection import OFFSET_OF_KNOWN_FEET, GroundProjection

INTRINSICS = Intrinsics.from_vertical_field_of_view(640, 480, math.radians(45.0))
CEILING = look_at(np.array([0.2, 0.0, 2.6]), np.array([6.2, 0.0, 0.9]))
IMAGE = CameraImage("camera1", 1.5, np.zeros((480, 640, 3), np.uint8), INTRINSICS, CEILING, True)


def tick(feet: np.ndarray | None, person: tuple[float, float] = (6.0, 0.0), scale: float = 1.0) -> SimpleNamespace:
    toe = 6.0 - OFFSET_OF_KNOWN_FEET
    foot, head = project(np.array([[toe, 0.0, 0.0], [toe, 0.0, 1.75]]), INTRINSICS, CEILING)[0]
    height = scale * (foot[1] - head[1])
    boxes = np.array([[foot[0] - 0.2 * height, head[1], 0.4 * height, height]])
    rows_of_feet = None if feet is None else np.array([foot[1]])
    people = (SimpleNamespace(pose_in_world=Pose2D(*person, 0.0), posture=Posture.STANDING),)
    return SimpleNamespace(
        observation=SimpleNamespace(images=(IMAGE,)),
        decision=SimpleNamespace(
            estimate=PoseEstimate(1.5, Pose2D(-9.0, 0.0, 0.0)),
            detections=(Detections(boxes, np.ones(1), np.ones(1), feet=rows_of_feet),),
        ),
        truth=SimpleNamespace(people=people),
    )


def errors(*arguments: object, **keywords: object) -> dict[str, FootError]:
    hook = FootPoints(GroundProjection(robot_radius=0.3))
    hook.record(tick(*arguments, **keywords))
    return {way: found[0] for way, found in hook.errors.items()}


def test_a_box_that_is_too_long_places_too_near_and_known_feet_do_not() -> None:
    found = errors(np.ones(1), scale=1.06)
    box, feet = (found[way] for way in WAYS)
    assert -0.4 < box.along < -0.15 and not box.known
    assert feet.along == pytest.approx(0.0, abs=1e-6) and feet.known
    assert feet.claimed < box.claimed


def test_who_is_placed_to_the_left_of_the_view_errs_to_the_left() -> None:
    assert errors(np.ones(1), person=(6.0, -0.2))[WAYS[1]].across == pytest.approx(0.2, abs=0.01)


def test_who_is_far_from_everybody_is_no_error() -> None:
    hook = FootPoints(GroundProjection(robot_radius=0.3))
    hook.record(tick(None, person=(8.0, 0.0)))
    assert hook.errors == {way: [] for way in WAYS}


def test_the_table_has_a_line_for_each_group_that_somebody_is_in() -> None:
    line = FootError("camera1", "standing", 150.0, True, True, 0.3, -0.4, 0.2)
    names = [cells[0] for cells in rows([line, line])]
    assert names == ["camera1, standing", "ceiling, 120 to 160 px", "**ceiling cameras**"]
    assert rows([line, line])[0][1:] == [2, "100 %", "+0.300", "-0.400", "0.000", "0.000", "0.500", "0.20"]
