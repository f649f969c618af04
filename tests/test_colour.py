"""From RGB to L, U and V."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from han_bullet.detection.colour import luv


def test_white_is_the_lightest_and_nearly_neutral_colour() -> None:
    white = luv(np.full((4, 4, 3), 255, np.uint8))[:, 0, 0]
    assert white == pytest.approx([100 / 270, 88 / 270, 134 / 270], abs=2e-3)  # L = 100, u = v = 0


def test_black_has_no_lightness_and_no_chroma() -> None:
    assert luv(np.zeros((4, 4, 3), np.uint8))[:, 0, 0] == pytest.approx([0.0, 88 / 270, 134 / 270], abs=1e-6)


@given(st.tuples(*[st.integers(0, 255)] * 3))
def test_luv_agrees_with_the_cie_formula_in_double_precision(colour: tuple[int, int, int]) -> None:
    to_xyz = np.array([[0.430574, 0.341550, 0.178325], [0.222015, 0.706655, 0.071330], [0.020183, 0.129553, 0.939180]])
    x, y, z = to_xyz @ np.array(colour) / 255.0
    lightness = 116.0 * np.cbrt(y) - 16.0 if y > (6 / 29) ** 3 else y * (29 / 3) ** 3
    total = x + 15 * y + 3 * z + 1e-35
    u = 13 * lightness * (4 * x / total - 0.197833)
    v = 13 * lightness * (9 * y / total - 0.468331)
    found = luv(np.full((1, 1, 3), colour, np.uint8))[:, 0, 0] * 270 - [0.0, 88.0, 134.0]
    # The table of lightness has 1024 entries: one step near black is 0.9 of 100, and u and v grow with it.
    assert found[0] == pytest.approx(lightness, abs=0.95)
    if lightness > 50.0:
        assert found == pytest.approx([lightness, u, v], abs=0.4)


@given(st.integers(0, 2**32 - 1))
def test_rough_reciprocals_change_colour_by_less_than_their_error(seed: int) -> None:
    image = np.random.default_rng(seed).integers(0, 256, (4, 6, 3), dtype=np.uint8)
    exact, rough = luv(image), luv(image, rough=True)
    # The lightness may fall into the neighbouring entry of its table, and takes u and v with it.
    same = exact[0] == rough[0]
    assert same.mean() > 0.8
    assert np.abs(exact - rough)[:, same].max() < 1.5e-3


def test_images_whose_size_is_no_multiple_of_four_pixels_are_converted_exactly() -> None:
    image = np.random.default_rng(1).integers(0, 256, (5, 7, 3), dtype=np.uint8)
    assert np.array_equal(luv(image), luv(image, rough=True))
