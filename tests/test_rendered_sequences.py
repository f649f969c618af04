"""Sequences of rendered people: who counts, what repeats, and that pictures and boxes belong together."""

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest

from han_bullet.geometry import Pose2D
from han_bullet.messages import Detections, Frame, Posture
from han_bullet.rendered_sequences import PersonInPicture, RenderedFrame, corridor, couch, film, mbot
from han_bullet.rendered_takes import Take
from han_bullet.tracking.projection import GroundProjection
from han_bullet.tracking.seats import in_sitting_area
from han_bullet.world_file import load_world
from han_bullet.world_schema import Furniture, Person

SEQUENCES = [corridor, mbot, couch]
LARGER_SCALE = 2.0 ** (1.0 / 8.0)  # between neighbouring boxes of the detector
Sequence = Callable[..., Iterator[RenderedFrame]]
WHOLE = PersonInPicture(np.array([100.0, 50.0, 60.0, 110.0]), False, 0.3, math.radians(34.9), 0.0, Posture.STANDING)


@pytest.fixture(scope="module")
def frames() -> dict[str, list[RenderedFrame]]:
    return {sequence.__name__: list(sequence(20, seed=3)) for sequence in SEQUENCES}


def test_a_person_just_inside_every_limit_counts() -> None:
    assert WHOLE.counts


@pytest.mark.parametrize(
    "change",
    [
        {"box": np.array([100.0, 50.0, 60.0, 109.0])},
        {"cut": True},
        {"hidden": 0.31},
        {"elevation": math.radians(35.0)},
    ],
    ids=["small", "cut", "hidden", "steep"],
)
def test_one_limit_is_enough_not_to_count(change: dict[str, object]) -> None:
    assert not replace(WHOLE, **change).counts  # type: ignore[arg-type]


def test_boxes_are_of_those_who_count_and_ignored_of_those_who_do_not() -> None:
    image = np.zeros((480, 640, 3), np.uint8)
    camera = load_world("real2").camera("camera1")
    frame = Frame("camera1", 0.0, image, camera.intrinsics, np.eye(4), True)
    both = RenderedFrame(frame, (WHOLE, replace(WHOLE, box=np.array([1.0, 2.0, 3.0, 4.0]))), None, 0)
    assert both.boxes.tolist() == [[100.0, 50.0, 60.0, 110.0]]
    assert both.ignored.tolist() == [[1.0, 2.0, 3.0, 4.0]]
    nobody = RenderedFrame(frame, (), None, 0)
    assert nobody.boxes.shape == nobody.ignored.shape == (0, 4)


def take(*places: Pose2D, furniture: tuple[Furniture, ...] = ()) -> Take:
    """People who stand before camera1."""
    world = load_world("real2")
    people = tuple(Person(name=f"p{n}", start=(p.x, p.y, p.yaw)) for n, p in enumerate(places))
    update = {"cameras": (world.camera("camera1"),), "people": people, "furniture": furniture}
    return Take(world.model_copy(update=update), 0, Pose2D(14.0, 1.0, 0.0))


def test_a_film_says_who_counts_and_who_is_ignored_and_leaves_out_who_is_wholly_hidden() -> None:
    cupboard = Furniture(name="cupboard", position=(7.0, 0.9), size=(0.5, 0.9, 2.7))
    counts, far, cut, behind = (
        Pose2D(6.0, 0.0, 0.0),
        Pose2D(12.0, -0.4, 0.0),
        Pose2D(2.8, -0.6, 0.0),
        Pose2D(7.6, 1.0, 0.0),
    )
    (frame,) = film(take(counts, far, cut, behind, furniture=(cupboard,)), 7, 1)
    assert [person.counts for person in frame.people] == [True, False, False]
    assert frame.people[1].box[3] < 110.0
    assert frame.people[2].cut
    assert frame.take == 7


def test_elevation_and_facing_are_those_of_the_floor_plan() -> None:
    (frame,) = film(take(Pose2D(6.2, 0.0, math.pi), Pose2D(6.2, 0.8, 0.0)), 0, 1)
    towards, away = frame.people
    assert towards.elevation == pytest.approx(math.atan2(2.6 - 0.9, 6.0), abs=0.01)  # hips at 0.9 m, camera at 2.6 m
    assert towards.facing == pytest.approx(0.0, abs=0.01)
    assert abs(away.facing) > 2.9


@pytest.mark.parametrize("sequence", SEQUENCES, ids=lambda s: s.__name__)
def test_the_same_seed_gives_the_same_frames_to_the_last_bit_and_another_does_not(
    sequence: Sequence, frames: dict[str, list[RenderedFrame]]
) -> None:
    again, other = list(sequence(6, seed=3)), list(sequence(6, seed=4))
    for one, two in zip(frames[sequence.__name__], again, strict=False):
        assert np.array_equal(one.image, two.image)
        assert np.array_equal(one.boxes, two.boxes)
        assert np.array_equal(one.ignored, two.ignored)
    assert not any(np.array_equal(one.image, two.image) for one, two in zip(again, other, strict=True))


@pytest.mark.parametrize("name", ["corridor", "mbot", "couch"])
def test_twenty_frames_hold_people_who_count_each_inside_the_picture(
    name: str, frames: dict[str, list[RenderedFrame]]
) -> None:
    assert len(frames[name]) == 20
    assert sum(len(frame.boxes) for frame in frames[name]) >= 15
    for frame in frames[name]:
        assert frame.image.shape == (480, 640, 3)
        boxes = frame.boxes
        assert (boxes[:, :2] > 0.0).all() and (boxes[:, :2] + boxes[:, 2:] < [640.0, 480.0]).all()
        assert (boxes[:, 3] >= 110.0).all()


@pytest.mark.parametrize("name", ["corridor", "couch"])
def test_before_a_fixed_camera_a_true_box_is_where_the_empty_picture_has_changed(
    name: str, frames: dict[str, list[RenderedFrame]]
) -> None:
    for frame in frames[name]:
        assert frame.empty is not None
        changed = (np.abs(frame.image.astype(int) - frame.empty.astype(int)).max(axis=2) > 30).astype(float)
        for x, y, width, height in frame.boxes.astype(int):
            assert changed[y : y + height, x : x + width].mean() > 0.2


def test_a_moving_camera_has_no_empty_picture_and_moves(frames: dict[str, list[RenderedFrame]]) -> None:
    assert all(frame.empty is None and not frame.frame.fixed for frame in frames["mbot"])
    ways = [
        np.linalg.norm(two.frame.camera_in_world[:3, 3] - one.frame.camera_in_world[:3, 3])
        for one, two in itertools.pairwise(frames["mbot"])
        if one.take == two.take
    ]
    assert np.median(ways) == pytest.approx(0.4 / 5.0, abs=0.04)  # 0.4 m/s at 5 frames a second


def test_seated_people_of_the_couch_are_drawn_in_several_outfits(frames: dict[str, list[RenderedFrame]]) -> None:
    assert all(person.posture is Posture.SEATED for frame in frames["couch"] for person in frame.people)
    middles = {}
    for frame in frames["couch"]:
        x, y, width, height = frame.people[0].box.astype(int)
        middles[frame.take] = tuple(frame.image[y + height // 3, x + width // 2] // 32)
    assert len(middles) == 5
    assert len(set(middles.values())) >= 3


def test_boxes_around_seated_people_end_inside_the_picture_though_a_scale_too_large_and_are_measured(
    frames: dict[str, list[RenderedFrame]],
) -> None:
    world = load_world("real2")
    (seat,) = world.seats()
    projection = GroundProjection(robot_radius=0.3, obstacles=world.solid_boxes(), seats=[seat])
    for frame in frames["couch"]:
        x, y, width, height = frame.boxes[0]
        larger = np.array([[x, y, width, LARGER_SCALE * height]])
        found = Detections(larger, scores=np.array([30.0]), probabilities=np.ones(1))
        scan = projection.project(frame.frame, found, Pose2D(0.0, 0.0, 0.0))
        assert len(scan.positions) == 1
        assert in_sitting_area(seat, scan.positions).all()


def test_frames_are_made_one_by_one_as_they_are_asked_for_and_reported() -> None:
    done: list[int] = []
    sequence = couch(3, seed=0, report=done.append)
    assert done == []
    next(sequence)
    assert done == [1]
    assert len(list(sequence)) == 2
    assert done == [1, 2, 3]
