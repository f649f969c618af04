"""Channels through filters."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import convolve2d

from han_bullet.detection.channels import CHANNELS
from han_bullet.detection.filters import filter_channels, halved


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 12), st.integers(1, 12), st.sampled_from([(5, 5), (3, 1), (1, 7)]))
def test_every_channel_goes_through_every_filter_and_is_halved(
    seed: int, rows: int, columns: int, size: tuple[int, int]
) -> None:
    rng = np.random.default_rng(seed)
    channels = rng.random((2 * rows, 2 * columns, CHANNELS), np.float32)
    filters = rng.normal(0.0, 1.0, (3, *size, CHANNELS)).astype(np.float32)
    found = filter_channels(channels, filters)
    assert found.shape == (rows, columns, 3 * CHANNELS)
    for which in range(3):
        for channel in range(CHANNELS):
            whole = convolve2d(channels[..., channel], filters[which, ..., channel], mode="full")
            down, across = size[0] // 2, size[1] // 2
            same = whole[down : down + 2 * rows, across : across + 2 * columns]
            expected = same.reshape(rows, 2, columns, 2).mean(axis=(1, 3))
            assert found[..., which * CHANNELS + channel] == pytest.approx(expected, abs=1e-4)


def test_of_an_odd_number_of_cells_the_greater_half_remains() -> None:
    assert [halved(cells) for cells in (1, 2, 3, 133)] == [1, 1, 2, 67]
    channels = np.ones((7, 9, CHANNELS), np.float32)
    point = np.zeros((1, 1, 1, CHANNELS), np.float32)
    point[...] = 2.0
    assert filter_channels(channels, point) == pytest.approx(np.full((4, 5, CHANNELS), 2.0))
