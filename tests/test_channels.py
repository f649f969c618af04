"""The ten channels: colour, gradient magnitude and directions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.detection.channels import CELL, CHANNELS, compute_channels, mirror
from han_bullet.detection.colour import luv
from han_bullet.errors import BadInputError

SHAPE = (48, 64)


def picture(seed: int, shape: tuple[int, int] = SHAPE) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (*shape, 3), dtype=np.uint8)


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


def test_smaller_cells_average_to_larger_ones() -> None:
    planes = luv(picture(2))
    small, large = compute_channels(planes, 2), compute_channels(planes, 4)
    assert small.shape == (SHAPE[0] // 2, SHAPE[1] // 2, CHANNELS)
    means = small.reshape(SHAPE[0] // 4, 2, SHAPE[1] // 4, 2, CHANNELS).mean(axis=(1, 3))
    assert means == pytest.approx(large, abs=1e-6)


def test_rough_reciprocals_change_channels_only_a_little() -> None:
    image = picture(3)
    exact, rough = compute_channels(luv(image)), compute_channels(luv(image, rough=True), rough=True)
    assert 1e-5 < np.abs(exact - rough).mean() < 1e-3


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
    ranges = np.ptp(expected["channels"], axis=(1, 2))
    rough = np.abs(compute_channels(luv(image, True), rough=True).transpose(2, 0, 1) - expected["channels"])
    assert (rough.mean(axis=(1, 2)) / ranges).max() < 2e-5
    # Exact reciprocals differ in the fourth digit, and the normalisation amplifies that in flat regions.
    exact = np.abs(compute_channels(luv(image)).transpose(2, 0, 1) - expected["channels"])
    assert 1e-4 < (exact.mean(axis=(1, 2)) / ranges).max() < 2e-3


@pytest.mark.parametrize(("shape", "cell"), [((3, 197, 120), 4), ((3, 120, 98), 4), ((3, 41, 40), 2)])
def test_planes_that_are_not_whole_cells_are_bad_input(shape: tuple[int, int, int], cell: int) -> None:
    with pytest.raises(BadInputError, match="not whole cells"):
        compute_channels(np.zeros(shape, np.float32), cell)
