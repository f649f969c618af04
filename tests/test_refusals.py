"""Why a box gives no measurement, in words; and that the words agree with the projection."""

import numpy as np
import pytest
from made_runs import corridor

from han_bullet.coverage import empty_frame
from han_bullet.geometry import Array, Pose2D, SolidBox
from han_bullet.messages import Detections, Frame, Seat
from han_bullet.tracking.projection import GroundProjection
from han_bullet.tracking.refusals import RefusalReasons
from han_bullet.tracking.sight import expected_box
from han_bullet.world_schema import FloorArea

WORLD = corridor()
FAR_AWAY = Pose2D(-50.0, 0.0, 0.0)
FRAME = empty_frame(WORLD.camera("camera1"), FAR_AWAY)


def box_at(x: float, y: float, height: float = 1.75, frame: Frame = FRAME) -> list[float]:
    box = expected_box(frame, np.array([x, y]), height)
    assert box is not None
    return [float(number) for number in box]


def reasons(
    *boxes: list[float], robot: Pose2D = FAR_AWAY, projection: GroundProjection | None = None, frame: Frame = FRAME
) -> tuple[str | None, ...]:
    projection = projection or GroundProjection(robot_radius=0.3, floor=WORLD.floor, obstacles=WORLD.solid_boxes())
    found = Detections(np.array(boxes), np.full(len(boxes), 50.0), np.ones(len(boxes)))
    return RefusalReasons(projection).of(found, projection.project(frame, found, robot))


def only(*boxes: list[float], **how: object) -> str:
    (reason,) = reasons(*boxes, **how)  # type: ignore[arg-type]
    assert reason is not None
    return reason


def test_a_box_that_is_measured_needs_no_reason() -> None:
    assert reasons(box_at(6.0, 0.0)) == (None,)


def test_a_small_box_is_given_its_height_and_the_smallest_one() -> None:
    assert only(box_at(9.9, 0.0)) == "the box is 102 px tall, and the smallest that is measured 104 px"


def test_a_box_at_the_lower_border_is_cut() -> None:
    x, y, width, _ = box_at(4.0, 0.0)
    assert only([x, y, width, 480.0 - y]) == "the box ends at the image's lower border, below which the feet may be"


def test_a_box_in_the_sky_has_its_edge_above_the_horizon() -> None:
    assert only([300.0, -120.0, 45.0, 110.0]) == "its lower edge is above the horizon"


def test_the_robot_itself_is_told_apart() -> None:
    reason = only(box_at(6.0, 0.0, 1.2), robot=Pose2D(6.0, 0.0, 0.0))
    assert reason.startswith("the foot point (6.") and reason.endswith("belongs to the robot itself")


def test_dwarfs_and_giants_are_told_their_height() -> None:
    assert "would be 1.09 m tall" in only(box_at(5.0, 0.0, 1.1))
    assert "m tall, not 1.3 to 2.2 m" in only(box_at(6.0, 0.0, 2.6))


def test_places_off_the_floor_and_in_the_building_are_told() -> None:
    floor = (FloorArea(x=(0.0, 5.0), y=(-1.5, 1.5)),)
    assert "is off the floor" in only(box_at(6.5, 0.0), projection=GroundProjection(robot_radius=0.3, floor=floor))
    wall = SolidBox("wall0", "wall", np.array([5.0, 0.0, 1.4]), np.array([0.1, 3.0, 2.8]), 0.0)
    behind = GroundProjection(robot_radius=0.3, obstacles=[wall])
    assert "is in or behind a part of the building" in only(box_at(6.5, 0.0), projection=behind)


def test_hidden_feet_without_seat_or_head_are_told() -> None:
    # A child-high head, level with nothing: too short for the feet to show, and too near for an adult's head.
    couch = SolidBox("couch", "object", np.array([5.6, 0.0, 0.4]), np.array([0.8, 2.0, 0.8]), 0.0)
    projection = GroundProjection(robot_radius=0.3, obstacles=[couch])
    frame = empty_frame(WORLD.camera("onboard"), Pose2D(2.0, 0.0, 0.0))
    x, y, width, height = box_at(6.4, 0.0, 1.4, frame=frame)
    assert "neither seat nor head" in only([x, y, width, height], projection=projection, frame=frame)


def many_boxes(rng: np.random.Generator, count: int) -> Array:
    heights = rng.uniform(60.0, 400.0, count)
    return np.column_stack([rng.uniform(-50, 640, count), rng.uniform(-200, 400, count), 0.41 * heights, heights])


@pytest.mark.parametrize("camera", ["camera1", "camera4", "onboard"])
def test_every_box_without_a_measurement_has_a_reason_and_no_other(camera: str) -> None:
    robot = Pose2D(17.0, -1.0, -0.3)
    seat = Seat("couch", np.array([19.5, -0.4]), -1.5708, 0.8, 1.9)
    projection = GroundProjection(robot_radius=0.3, floor=WORLD.floor, obstacles=WORLD.solid_boxes(), seats=[seat])
    frame = empty_frame(WORLD.camera(camera), robot)
    boxes = many_boxes(np.random.default_rng(5), 4000)
    found = Detections(boxes, np.ones(len(boxes)), np.ones(len(boxes)))
    scan = projection.project(frame, found, robot)
    told = RefusalReasons(projection).of(found, scan)
    assert {row for row, reason in enumerate(told) if reason is None} == set(scan.sources.tolist())
    assert len({reason.split("(")[0] for reason in told if reason is not None}) >= 4
