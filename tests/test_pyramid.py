"""Smoothing, padding, cells and the approximated levels."""

import functools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from han_bullet.detection.channels import CHANNELS, compute_channels
from han_bullet.detection.colour import luv
from han_bullet.detection.pictures import read_picture
from han_bullet.detection.pyramid import (
    PADDING_COLUMNS,
    PADDING_ROWS,
    Level,
    PyramidSettings,
    build_pyramid,
    smooth,
    smooth_and_pad,
)
from han_bullet.detection.region import Region
from han_bullet.detection.scales import LevelSize

SETTINGS = PyramidSettings((0.0, 0.11579, 0.11579), smallest=(100, 41))


def cells(seed: int, rows: int, columns: int) -> np.ndarray:
    return np.random.default_rng(seed).random((rows, columns, CHANNELS), dtype=np.float32)


@functools.cache
def whole_pyramid(height: int, width: int) -> list[Level]:
    image = np.random.default_rng(4).integers(0, 256, (height, width, 3), dtype=np.uint8)
    return build_pyramid(image, SETTINGS)


def test_smoothing_spreads_a_point_by_one_two_one() -> None:
    point = np.zeros((7, 9, CHANNELS), np.float32)
    point[3, 4] = 16.0
    spread = smooth(point)[..., 5]
    assert spread[2:5, 3:6].tolist() == [[1, 2, 1], [2, 4, 2], [1, 2, 1]]
    assert spread.sum() == 16.0


def test_padding_repeats_colour_and_clears_gradients() -> None:
    gains = np.arange(1, CHANNELS + 1, dtype=np.float32)
    padded = smooth_and_pad(np.ones((5, 6, CHANNELS), np.float32), gains, PADDING_ROWS, PADDING_COLUMNS)
    assert padded.shape == (5 + 2 * PADDING_ROWS, 6 + 2 * PADDING_COLUMNS, CHANNELS)
    assert padded[..., :3] == pytest.approx(np.broadcast_to(gains[:3], padded[..., :3].shape))
    inside = np.zeros(padded.shape[:2], bool)
    inside[PADDING_ROWS:-PADDING_ROWS, PADDING_COLUMNS:-PADDING_COLUMNS] = True
    assert not padded[~inside, 3:].any()
    assert padded[inside, 3:] == pytest.approx(np.broadcast_to(gains[3:], padded[inside, 3:].shape))


def test_the_real_scale_holds_the_smoothed_channels_of_the_image() -> None:
    image = np.random.default_rng(3).integers(0, 256, (120, 160, 3), dtype=np.uint8)
    first = build_pyramid(image, SETTINGS)[0]
    inside = first.channels[PADDING_ROWS:-PADDING_ROWS, PADDING_COLUMNS:-PADDING_COLUMNS]
    assert np.array_equal(inside, smooth(compute_channels(luv(image))))


@pytest.mark.parametrize("chosen", [[], [0], [3, 9], [16], range(5, 15)])
@pytest.mark.parametrize(("first", "last"), [(0, 999), (0, 9), (3, 4), (4, 40), (11, 30), (20, 999), (-1, 999)])
@pytest.mark.parametrize(("left", "right"), [(0, 999), (0, 8), (5, 6), (12, 999), (-1, 999)])
@pytest.mark.parametrize(("height", "width"), [(410, 420), (416, 448)])
def test_parts_that_nobody_looks_at_are_left_out_and_the_others_stay_as_they_are(
    chosen: Sequence[int], first: int, last: int, left: int, right: int, height: int, width: int
) -> None:
    image = np.random.default_rng(4).integers(0, 256, (height, width, 3), dtype=np.uint8)
    everything = whole_pyramid(height, width)
    assert len(everything) == 17
    sizes = [everything[number].size for number in chosen]

    def needed(size: LevelSize) -> Region | None:
        rows, columns = size.rows + 2 * PADDING_ROWS, size.columns + 2 * PADDING_COLUMNS
        part = Region(range(rows)[first:last], range(columns)[left:right], (rows, columns))  # -1: the last one only
        return part if size in sizes else None

    some = build_pyramid(image, SETTINGS, needed)
    assert [level.size for level in some] == sizes
    for number, level in zip(chosen, some, strict=True):
        part = needed(level.size)
        assert part is not None and len(part.rows) > 0 and len(part.columns) > 0
        made = Region(
            range(level.first_row, level.first_row + level.channels.shape[0]),
            range(level.first_column, level.first_column + level.channels.shape[1]),
            part.grid,
        )
        assert np.array_equal(level.channels[part.within(made)], everything[number].channels[part.slices])


def test_smaller_cells_and_other_padding_make_larger_levels() -> None:
    image = np.random.default_rng(5).integers(0, 256, (120, 160, 3), dtype=np.uint8)
    first = build_pyramid(image, replace(SETTINGS, cell=2, padding=(7, 6)))[0]
    assert first.channels.shape == (60 + 14, 80 + 12, CHANNELS)
    inside = first.channels[7:-7, 6:-6]
    assert np.array_equal(inside, smooth(compute_channels(luv(image), 2)))


@pytest.mark.data
@pytest.mark.parametrize("name", ["photo", "rendering"])
def test_the_pyramid_agrees_with_the_original(data_folder, name: str) -> None:
    folder = data_folder.parent / "reference" / "acf"
    if not folder.is_dir():
        pytest.skip(f"no reference pyramid of the original detector in {folder}")
    expected = np.load(folder / f"{name}.npz")
    levels = build_pyramid(read_picture(folder / f"{name}.png"), replace(SETTINGS, rough=True))
    assert [level.size.scale for level in levels] == pytest.approx(expected["scales"], abs=1e-12)
    sizes = [(level.size.scale_y, level.size.scale_x) for level in levels]
    assert sizes == pytest.approx(expected["scales_hw"], abs=1e-12)
    for number, level in enumerate(levels):
        difference = np.abs(level.channels.transpose(2, 0, 1) - expected[f"pyramid_{number:02d}"])
        assert difference.mean() < 2e-5
        assert difference.max() < 0.01
