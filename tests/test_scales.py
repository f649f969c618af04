"""The scales of the pyramid."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.detection.scales import level_sizes, octaves, pyramid_scales

SMALLEST = (100, 41)


def test_a_vga_image_has_nineteen_scales_from_one_to_a_person_as_high_as_the_image() -> None:
    scales = pyramid_scales(480, 640, *SMALLEST)
    assert len(scales) == 19
    assert scales[0] == 1.0
    assert scales[8] == 0.5
    assert scales[16] == 0.25
    assert scales[-1] == pytest.approx(0.207125)  # 99.4 of 480 px, rounded to 100


@given(st.integers(1, 3000), st.integers(1, 3000), st.sampled_from([2, 4]))
def test_scales_fall_and_every_level_is_whole_cells_near_its_scale(height: int, width: int, cell: int) -> None:
    scales = pyramid_scales(height, width, *SMALLEST, cell)
    assert np.all(np.diff(scales) < 0.0)
    assert bool(scales) == (height >= 100 and width >= 41)
    for size in level_sizes(height, width, SMALLEST, cell):
        assert abs(size.rows * cell - height * size.scale) <= cell / 2 + 1e-6
        assert size.scale_y * height == pytest.approx(size.rows * cell)
        assert size.scale_x * width == pytest.approx(size.columns * cell)


def test_every_scale_belongs_to_the_nearest_real_one() -> None:
    assert octaves(19) == [(0, range(0, 5)), (8, range(5, 13)), (16, range(13, 19))]
    assert octaves(1) == [(0, range(0, 1))]
    assert octaves(0) == []
