"""The ten channels: colour, gradient magnitude and directions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.detection.channels import CELL, CHANNELS, compute_channels, luv, mirror

SHAPE = (48, 64)


def picture(seed: int, shape: tuple[int, int] = SHAPE) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (*shape, 3), dtype=np.uint8)


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


def test_a_flat_image_has_no_gradient() -> None:
    channels = compute_channels(luv(np.full((*SHAPE, 3), (200, 40, 90), np.uint8)))
    assert channels.shape == (SHAPE[0] // CELL, SHAPE[1] // CELL, CHANNELS)
    assert np.abs(channels[..., 3:]).max() < 1e-6


@pytest.mark.parametrize(("turned", "bins"), [(False, (0, 5)), (True, (2, 3))])
def test_a_ramp_falls_into_the_bins_of_its_direction(turned: bool, bins: tuple[int, int]) -> None:
    # Directions: bin k starts at k * 30 degrees; a horizontal gradient is 0 or 180, a vertical one 90 = bin 3.
    ramp = np.repeat(np.arange(96, dtype=np.uint8)[None, :] * 2, 96, axis=0)
    image = np.repeat((ramp.T if turned else ramp)[..., None], 3, axis=2)
    directions = compute_channels(luv(image))[4:-4, 4:-4, 4:].mean(axis=(0, 1))
    assert directions[list(bins)].sum() > 0.99 * directions.sum() > 0.1


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_direction_channels_add_up_to_the_magnitude(seed: int) -> None:
    channels = compute_channels(luv(picture(seed)))
    assert channels[..., 4:].sum(axis=-1) == pytest.approx(channels[..., 3], abs=1e-5)
    assert channels.min() >= 0.0


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_mirrored_image_has_mirrored_colour_and_magnitude(seed: int) -> None:
    image = picture(seed)
    channels = compute_channels(luv(image))
    mirrored = compute_channels(luv(np.ascontiguousarray(image[:, ::-1])))
    assert mirrored[..., :4] == pytest.approx(channels[:, ::-1, :4], abs=1e-5)


def test_the_same_image_gives_the_same_channels_bit_for_bit() -> None:
    image = picture(7)
    assert np.array_equal(compute_channels(luv(image)), compute_channels(luv(image.copy())))


@pytest.mark.parametrize(("index", "inside"), [(-1, 0), (-5, 4), (0, 0), (9, 9), (10, 9), (14, 5)])
def test_an_index_outside_is_mirrored_with_the_border_repeated(index: int, inside: int) -> None:
    assert mirror(index, 10) == inside


def reference(data_folder, name: str):
    folder = data_folder.parent / "reference" / "acf"
    if not folder.is_dir():
        pytest.skip(f"no reference channels of the original detector in {folder}")
    return np.load(folder / f"{name}.npz"), folder / f"{name}.png"


@pytest.mark.data
@pytest.mark.parametrize("name", ["photo", "rendering"])
def test_channels_agree_with_the_original(data_folder, name: str) -> None:
    import cv2

    expected, picture_file = reference(data_folder, name)
    image = np.ascontiguousarray(cv2.imread(str(picture_file))[..., ::-1])
    difference = np.abs(compute_channels(luv(image)).transpose(2, 0, 1) - expected["channels"])
    assert difference[:3].max() < 5e-4
    # The original approximates reciprocals to about 4 digits, and the normalisation amplifies that in flat regions.
    assert difference[3:].mean() < 1.5e-3
    assert difference[3:].max() < 0.07
