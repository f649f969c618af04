"""The mask of a fixed camera: what the empty scene gives too is no person."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.detection.still_scene import (
    CHANGED_LEVEL,
    LEAST_CHANGED_PART,
    Changes,
    StillScene,
)
from han_bullet.errors import BadInputError

BOX = np.array([[100.0, 60.0, 41.0, 100.0]])


def room(level: int = 120) -> np.ndarray:
    """Return a textured wall, 240 x 320."""
    texture = np.random.default_rng(1).integers(-20, 21, (240, 320, 1))
    return np.clip(level + texture.repeat(3, axis=2), 0, 255).astype(np.uint8)


def noisy(image: np.ndarray, deviation: float, seed: int) -> np.ndarray:
    noise = np.random.default_rng(seed).normal(0.0, deviation, image.shape)
    return np.clip(np.round(image + noise), 0, 255).astype(np.uint8)


def with_body(image: np.ndarray, colour: tuple[int, int, int], columns: slice = slice(112, 130)) -> np.ndarray:
    """Return the image with a body 18 px wide and 92 px high: 40 % of BOX."""
    changed = image.copy()
    changed[64:156, columns] = colour
    return changed


def test_box_on_an_unchanged_scene_is_dropped_under_noise_of_6_grey_levels_in_both_images():
    scene = StillScene(noisy(room(), 6.0, 2), np.zeros((0, 4)))
    for seed in range(3, 13):
        changes = scene.changes(noisy(room(), 6.0, seed))
        assert changes.part_of(BOX)[0] < 0.01
        assert not scene.keep(changes, BOX)[0]


@given(st.integers(0, 2**32 - 1), st.integers(0, 7), st.integers(0, 7))
def test_cells_are_compared_by_the_area_means_that_opencv_gives(seed: int, more_rows: int, more_columns: int):
    generator = np.random.default_rng(seed)
    empty = generator.integers(0, 200, (40 + more_rows, 60 + more_columns, 3), np.uint8)
    image = empty + generator.integers(9, 15, empty.shape, np.uint8)
    shape = image.shape[1] // 4, image.shape[0] // 4
    whole = slice(0, 4 * shape[1]), slice(0, 4 * shape[0])
    before, after = (cv2.resize(one[whole], shape, interpolation=cv2.INTER_AREA) for one in (empty, image))
    expected = cv2.absdiff(before, after).max(axis=2) > CHANGED_LEVEL
    assert 0 < np.count_nonzero(expected) < expected.size
    assert np.array_equal(StillScene(empty, np.zeros((0, 4))).changes(image).cells, expected)


def test_person_is_kept_where_nothing_was_and_where_the_empty_scene_has_a_mistake():
    image = with_body(noisy(room(), 6.0, 3), (40, 40, 90))
    for mistakes in (np.zeros((0, 4)), BOX, BOX + np.array([4.0, 6.0, 2.0, 5.0])):
        scene = StillScene(noisy(room(), 6.0, 2), mistakes)
        assert 0.3 < scene.changes(image).part_of(BOX)[0] < 0.5
        assert scene.keep(scene.changes(image), BOX)[0]


def test_mistake_of_the_empty_scene_stays_masked_when_a_passer_by_covers_its_edge():
    image = with_body(room(), (40, 40, 90), slice(92, 106))
    fresh, repeated = StillScene(room(), np.zeros((0, 4))), StillScene(room(), BOX)
    changes = fresh.changes(image)
    assert LEAST_CHANGED_PART < changes.part_of(BOX)[0] < 0.2
    assert fresh.keep(changes, BOX)[0]
    assert not repeated.keep(changes, BOX)[0]


def test_clothes_count_as_changed_in_any_one_colour():
    scene = StillScene(room(), BOX)
    shirt = room().astype(int)
    shirt[64:156, 112:130, 2] += 15  # bluer than the wall by more than the level, red and green alike
    assert CHANGED_LEVEL < 15
    assert scene.keep(scene.changes(shirt.astype(np.uint8)), BOX)[0]


def test_frame_without_enough_change_for_the_smallest_box_holds_no_person():
    scene = StillScene(noisy(room(), 6.0, 2), np.zeros((0, 4)))
    assert not scene.changes(noisy(room(), 6.0, 3)).may_hold(4100.0)
    assert scene.changes(with_body(noisy(room(), 6.0, 3), (40, 40, 90))).may_hold(4100.0)


@given(st.integers(0, 300), st.integers(0, 220), st.integers(1, 60), st.integers(1, 60), st.integers(100, 140))
def test_a_frame_that_may_hold_nothing_has_no_box_to_keep(x, y, width, height, box_height):
    image = room()
    image[y : y + height, x : x + width] = 0
    scene = StillScene(room(), np.zeros((0, 4)))
    corners = [(float(u), float(v)) for u in range(0, 260, 20) for v in range(0, 130, 20)]
    boxes = np.array([(u, v, 0.41 * box_height, box_height) for u, v in corners])
    changes = scene.changes(image)
    if not changes.may_hold(0.41 * 100.0**2):
        assert not scene.keep(changes, boxes).any()


@given(st.integers(0, 2**32 - 1), st.floats(60.0, 200.0), st.floats(0.0, 0.4))
def test_the_area_of_change_allows_the_boxes_that_are_kept_where_the_empty_scene_has_no_mistakes(seed, height, share):
    rng = np.random.default_rng(seed)
    changes = Changes(rng.random((60, 80)) < share * rng.random((60, 1)))
    x, y = np.linspace(-30.0, 330.0, 23) + rng.random(), np.linspace(-20.0, 250.0, 19) + rng.random()
    boxes = np.array([(u, v, 0.41 * height, height) for v in y for u in x])
    kept = StillScene(room(), np.zeros((0, 4))).keep(changes, boxes)
    assert np.array_equal(changes.windows(x, y, 0.41 * height, height).ravel(), kept)
    assert np.array_equal(changes.allow_boxes(boxes), kept)


def test_part_of_a_box_beyond_the_image_counts_as_unchanged():
    scene = StillScene(room(120), np.zeros((0, 4)))
    boxes = np.array([[-20.0, 40.0, 40.0, 100.0], [40.0, 40.0, 40.0, 100.0], [400.0, 40.0, 40.0, 100.0]])
    np.testing.assert_allclose(scene.changes(room(200)).part_of(boxes), [0.5, 1.0, 0.0])


def test_image_of_another_size_is_refused_with_both_sizes():
    with pytest.raises(BadInputError, match=r"\(120, 160, 3\).*\(240, 320, 3\)"):
        StillScene(room(), BOX).changes(room()[:120, :160])


def test_no_boxes_give_no_answers():
    scene = StillScene(room(), BOX)
    assert scene.keep(scene.changes(room()), np.zeros((0, 4))).shape == (0,)


def test_a_box_without_area_has_nothing_changed_in_it() -> None:
    changes = Changes(np.ones((120, 160), bool))
    assert not changes.windows(np.array([10.0]), np.array([10.0]), 0.0, 50.0).any()
