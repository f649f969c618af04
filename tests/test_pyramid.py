"""Scales, resampling, smoothing and the approximated levels."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.detection.channels import CELL, CHANNELS, compute_channels, luv
from han_bullet.detection.pyramid import (
    PADDING_COLUMNS,
    PADDING_ROWS,
    build_pyramid,
    pyramid_scales,
    smooth,
    smooth_and_pad,
)

LAMBDAS = (0.0, 0.11579, 0.11579)
SMALLEST = (100, 41)


def cells(seed: int, rows: int, columns: int) -> np.ndarray:
    return np.random.default_rng(seed).random((rows, columns, CHANNELS), dtype=np.float32)


def test_a_vga_image_has_nineteen_scales_from_one_to_a_person_as_high_as_the_image() -> None:
    scales = pyramid_scales(480, 640, *SMALLEST)
    assert len(scales) == 19
    assert scales[0] == 1.0
    assert scales[8] == 0.5
    assert scales[16] == 0.25
    assert scales[-1] == pytest.approx(0.207125)  # 99.4 of 480 px, rounded to 100


@given(st.integers(1, 3000), st.integers(1, 3000))
def test_scales_fall_and_every_level_is_whole_cells_near_its_scale(height: int, width: int) -> None:
    scales = pyramid_scales(height, width, *SMALLEST)
    assert np.all(np.diff(scales) < 0.0)
    assert bool(scales) == (height >= 100 and width >= 41)
    for scale in scales:
        assert abs(round(height * scale / CELL) * CELL - height * scale) <= CELL / 2 + 1e-6


def test_smoothing_spreads_a_point_by_one_two_one() -> None:
    point = np.zeros((7, 9, CHANNELS), np.float32)
    point[3, 4] = 16.0
    spread = smooth(point)[..., 5]
    assert spread[2:5, 3:6].tolist() == [[1, 2, 1], [2, 4, 2], [1, 2, 1]]
    assert spread.sum() == 16.0


def test_padding_repeats_colour_and_clears_gradients() -> None:
    gains = np.arange(1, CHANNELS + 1, dtype=np.float32)
    padded = smooth_and_pad(np.ones((5, 6, CHANNELS), np.float32), gains)
    assert padded.shape == (5 + 2 * PADDING_ROWS, 6 + 2 * PADDING_COLUMNS, CHANNELS)
    assert padded[..., :3] == pytest.approx(np.broadcast_to(gains[:3], padded[..., :3].shape))
    inside = np.zeros(padded.shape[:2], bool)
    inside[PADDING_ROWS:-PADDING_ROWS, PADDING_COLUMNS:-PADDING_COLUMNS] = True
    assert not padded[~inside, 3:].any()
    assert padded[inside, 3:] == pytest.approx(np.broadcast_to(gains[3:], padded[inside, 3:].shape))


def test_the_real_scale_holds_the_smoothed_channels_of_the_image() -> None:
    image = np.random.default_rng(3).integers(0, 256, (120, 160, 3), dtype=np.uint8)
    first = build_pyramid(image, LAMBDAS, SMALLEST)[0]
    inside = first.channels[PADDING_ROWS:-PADDING_ROWS, PADDING_COLUMNS:-PADDING_COLUMNS]
    assert np.array_equal(inside, smooth(compute_channels(luv(image))))


@pytest.mark.data
@pytest.mark.parametrize("name", ["photo", "rendering"])
def test_the_pyramid_agrees_with_the_original(data_folder, name: str) -> None:
    import cv2

    folder = data_folder.parent / "reference" / "acf"
    if not folder.is_dir():
        pytest.skip(f"no reference pyramid of the original detector in {folder}")
    expected = np.load(folder / f"{name}.npz")
    image = np.ascontiguousarray(cv2.imread(str(folder / f"{name}.png"))[..., ::-1])
    levels = build_pyramid(image, LAMBDAS, SMALLEST)
    assert [level.scale for level in levels] == pytest.approx(expected["scales"], abs=1e-12)
    assert [(level.scale_y, level.scale_x) for level in levels] == pytest.approx(expected["scales_hw"], abs=1e-12)
    for number, level in enumerate(levels):
        difference = np.abs(level.channels.transpose(2, 0, 1) - expected[f"pyramid_{number:02d}"])
        assert difference.mean() < 1e-3
        assert difference.max() < 0.03
