"""Area means and bilinear growth."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from han_bullet.detection.channels import CHANNELS
from han_bullet.detection.resampling import resample, resample_planes


def cells(seed: int, rows: int, columns: int) -> np.ndarray:
    return np.random.default_rng(seed).random((rows, columns, CHANNELS), dtype=np.float32)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 99), st.integers(2, 40), st.integers(2, 40), st.integers(1, 60), st.integers(1, 60))
def test_resampling_keeps_a_constant_and_stays_within_the_range(
    seed: int, height: int, width: int, rows: int, columns: int
) -> None:
    constant = np.full((height, width, CHANNELS), 0.7, np.float32)
    assert resample(constant, rows, columns) == pytest.approx(np.full((rows, columns, CHANNELS), 0.7), abs=1e-5)
    values = cells(seed, height, width)
    result = resample(values, rows, columns)
    assert result.min() >= values.min() - 1e-5
    assert result.max() <= values.max() + 1e-5


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 99), st.integers(4, 40), st.integers(4, 40), st.data())
def test_shrinking_keeps_the_mean(seed: int, height: int, width: int, data: st.DataObject) -> None:
    values = cells(seed, height, width)
    rows, columns = data.draw(st.integers(1, height)), data.draw(st.integers(1, width))
    # Parts of a pixel below a thousandth are left out, hence the tolerance.
    assert resample(values, rows, columns).mean() == pytest.approx(values.mean(), abs=2e-3)


def test_halving_takes_the_mean_of_four() -> None:
    values = cells(1, 6, 8)
    expected = values.reshape(3, 2, 4, 2, CHANNELS).mean(axis=(1, 3))
    assert resample(values, 3, 4) == pytest.approx(expected, abs=1e-6)


def test_planes_and_channels_are_resampled_alike() -> None:
    values = cells(2, 37, 53)
    planes = np.ascontiguousarray(values[..., :3].transpose(2, 0, 1))
    assert np.array_equal(resample_planes(planes, 20, 60).transpose(1, 2, 0), resample(values, 20, 60)[..., :3])


def test_halving_planes_gives_the_bits_that_resampling_gives() -> None:
    planes = np.random.default_rng(8).random((3, 24, 36), dtype=np.float32)
    channels = np.concatenate([planes.transpose(1, 2, 0), np.zeros((24, 36, CHANNELS - 3), np.float32)], axis=2)
    assert np.array_equal(resample_planes(planes, 12, 18).transpose(1, 2, 0), resample(channels, 12, 18)[..., :3])
