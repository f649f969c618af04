"""Crops as other cameras would have given them: their size, their range, what repeats and what does not."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.detection.training.augmentation import augment, centre

SIZE = (56, 28)


def half_and_half(count: int) -> np.ndarray:
    """Return crops with a margin, 65 x 33 px, that are dark on the left and bright on the right."""
    crops = np.full((count, 65, 33, 3), 60, np.uint8)
    crops[:, :, 17:] = 200
    return crops


def test_the_centre_leaves_the_same_margin_on_all_sides() -> None:
    crops = np.random.default_rng(0).integers(0, 256, (3, 64, 32, 3), np.uint8)
    middle = centre(crops, (56, 26))
    np.testing.assert_array_equal(middle, crops[:, 4:60, 3:29])
    assert middle.flags.c_contiguous


def test_the_centre_of_a_crop_without_margin_is_the_crop() -> None:
    crops = half_and_half(2)
    np.testing.assert_array_equal(centre(crops, (65, 33)), crops)


def test_every_crop_is_changed_in_its_own_way_and_the_input_left_alone() -> None:
    crops = half_and_half(8)
    before = crops.copy()
    changed = augment(crops, SIZE, np.random.default_rng(5))
    assert changed.shape == (8, 56, 28, 3) and changed.dtype == np.uint8
    assert (np.abs(changed.astype(int) - centre(crops, SIZE)).mean(axis=(1, 2, 3)) > 1.0).all()
    assert len({one.tobytes() for one in changed}) == 8
    np.testing.assert_array_equal(crops, before)


def test_the_same_generator_gives_the_same_crops_and_another_one_others() -> None:
    first, second, other = (augment(half_and_half(4), SIZE, np.random.default_rng(seed)) for seed in (5, 5, 6))
    np.testing.assert_array_equal(first, second)
    assert not np.array_equal(first, other)


def test_about_half_of_the_crops_are_mirrored() -> None:
    changed = augment(half_and_half(400), SIZE, np.random.default_rng(1)).astype(float)
    left, right = changed[:, :, :8].mean(axis=(1, 2, 3)), changed[:, :, -8:].mean(axis=(1, 2, 3))
    assert (np.abs(left - right) > 20.0).all()  # so that every crop shows which way it is
    assert np.mean(left > right) == pytest.approx(0.5, abs=0.08)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0, 128, 255]), st.integers(8, 40), st.integers(8, 40))
def test_extreme_crops_stay_within_0_to_255_without_turning_over(
    seed: int, level: int, rows: int, columns: int
) -> None:
    crops = np.full((4, rows + 6, columns + 6, 3), level, np.uint8)
    changed = augment(crops, (rows, columns), np.random.default_rng(seed))
    assert changed.shape == (4, rows, columns, 3)
    for crop in changed.astype(float):
        # Grey stays within (level - 128) * [0.63, 1.485] + 128 +- 30, and noise below 5 deviations of 7: no black
        # crop turns white, no white one black.
        assert crop.min() >= min((level - 128) * 1.485, (level - 128) * 0.63) + 128 - 30 - 36 or crop.min() == 0
        assert crop.max() <= max((level - 128) * 1.485, (level - 128) * 0.63) + 128 + 30 + 36 or crop.max() == 255
        assert np.ptp(crop.mean(axis=(0, 1))) < 0.3 * 128 + 10.0


def test_a_person_in_the_middle_stays_in_the_middle() -> None:
    crops = np.zeros((300, 65, 33, 3), np.uint8)
    crops[:, 20:45, 12:21] = 255
    changed = augment(crops, SIZE, np.random.default_rng(2)).astype(float).mean(axis=3)
    changed -= changed.min(axis=(1, 2), keepdims=True)
    bright = changed > 0.5 * changed.max(axis=(1, 2), keepdims=True)
    rows = np.array([np.nonzero(one.any(axis=1))[0].mean() for one in bright])
    columns = np.array([np.nonzero(one.any(axis=0))[0].mean() for one in bright])
    assert np.median(rows) == pytest.approx(27.5, abs=0.5)  # centre of 56 px
    assert np.median(columns) == pytest.approx(13.5, abs=0.5)
    assert 0.01 * 56 < rows.std() < 0.06 * 56  # and moves by about 3 % of the side
    assert 0.01 * 28 < columns.std() < 0.06 * 28
