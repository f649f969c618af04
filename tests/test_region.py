"""Rectangles of grids."""

import numpy as np

from han_bullet.detection.region import Region
from han_bullet.detection.resampling import resample, sources

PART = Region(range(2, 5), range(1, 7), (8, 9))


def test_a_region_cuts_itself_out_of_its_grid_and_out_of_a_larger_region() -> None:
    grid = np.arange(72).reshape(8, 9)
    larger = PART.grown(1)
    assert grid[PART.slices].shape == (3, 6)
    assert np.array_equal(grid[larger.slices][PART.within(larger)], grid[PART.slices])


def test_a_margin_ends_at_the_edge_of_the_grid() -> None:
    assert PART.grown(3) == Region(range(0, 8), range(0, 9), (8, 9))
    assert PART.grown(3) == Region.all_of(8, 9)


def test_the_pixels_of_cells_are_as_many_times_as_many() -> None:
    assert PART.refined(4) == Region(range(8, 20), range(4, 28), (32, 36))


def test_joined_regions_are_the_smallest_that_holds_both() -> None:
    assert PART.joined(Region(range(6, 7), range(0, 2), (8, 9))) == Region(range(2, 7), range(0, 7), (8, 9))
    assert PART.joined(None) is PART


def test_a_part_is_resampled_from_its_sources_alone() -> None:
    channels = np.random.default_rng(0).random((20, 31, 10), dtype=np.float32)
    for rows, columns in ((11, 13), (20, 40), (33, 31)):
        whole = resample(channels, rows, columns)
        wanted = Region(range(3, 9), range(5, 12), (rows, columns))
        given = sources(wanted, 20, 31)
        some = resample(np.ascontiguousarray(channels[given.slices]), rows, columns, wanted, given)
        assert len(given.rows) < 20 and len(given.columns) < 31
        assert np.array_equal(some, whole[wanted.slices])
