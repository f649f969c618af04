"""Training crops of the second stage: exact, deformed and misplaced boxes, hard negatives, the split."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from little_samples import everything_detector, write_pictures

from han_bullet.detection.inria import train_backgrounds, train_people
from han_bullet.detection.overlap import intersection_over_union
from han_bullet.detection.training.boxes import deformed, misplaced, placed
from han_bullet.detection.training.cnn_samples import (
    Samples,
    collect_samples,
    samples_around_people,
    samples_of_background,
    split,
    weakened,
)
from han_bullet.detection.training.recipe import PAPER, Recipe
from han_bullet.errors import BadInputError

PERSON = np.array([28.3, 32.0, 39.36, 96.0])
SIZE = (64, 64)
seeds = st.integers(0, 2**32 - 1)


def people(data: Path, recipe: Recipe = PAPER, seed: int = 0) -> Samples:
    return samples_around_people(train_people(data), SIZE, recipe, np.random.default_rng(seed))


def numbered(labels: list[int], sources: list[int]) -> Samples:
    return Samples(np.zeros((len(labels), 8, 8, 3), np.uint8), np.array(labels), np.array(sources))


def test_each_crop_gives_itself_and_one_deformed_window_with_the_number_of_its_photograph(tmp_path: Path) -> None:
    samples = people(write_pictures(tmp_path))
    assert samples.crops.shape == (8, 74, 74, 3)  # 64 px and a margin of 16 % in all
    assert samples.labels.tolist() == [1] * 8
    assert samples.sources.tolist() == [0, 0, 0, 0, 1, 1, 1, 1]
    for exact in samples.crops[::2]:  # the bar is 96 of 143 px high and 24 of 71 wide: 50 and 25 of 74
        bright = exact[:, :, 0] > 128
        assert abs(bright[:, 37].sum() - 50) <= 2
        assert abs(bright[37].sum() - 25) <= 2
        rows, columns = np.nonzero(bright)
        assert rows.mean() == pytest.approx(36.5, abs=1.0) and columns.mean() == pytest.approx(36.5, abs=1.0)
    assert not np.array_equal(samples.crops[0], samples.crops[1])


def test_misplaced_boxes_beside_people_are_background_of_the_same_photograph(tmp_path: Path) -> None:
    samples = people(write_pictures(tmp_path), replace(PAPER, deformed=3, misplaced=6))
    assert samples.labels.tolist() == 4 * ([1] * 4 + [0] * 6)
    assert samples.sources.tolist() == [0] * 20 + [1] * 20
    middle = (samples.crops[:, 27:47, 27:47] > 128).mean(axis=(1, 2, 3))
    assert middle[samples.labels == 1].min() > 0.6 > middle[samples.labels == 0].mean()


def test_the_same_seed_gives_the_same_boxes_and_another_one_others(tmp_path: Path) -> None:
    data = write_pictures(tmp_path)
    first, second, other = (people(data, seed=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.crops, second.crops)
    np.testing.assert_array_equal(first.crops[::2], other.crops[::2])  # the exact ones
    assert not np.array_equal(first.crops, other.crops)


@given(seeds)
def test_a_deformed_box_is_moved_and_scaled_by_at_most_5_px(seed: int) -> None:
    box = deformed(PERSON, np.random.default_rng(seed))
    shift = box[:2] + 0.5 * box[2:] - (PERSON[:2] + 0.5 * PERSON[2:])
    assert (np.abs(shift) <= 5.0 + 1e-9).all()
    assert abs(box[3] - 96.0) <= 5.0 + 1e-9
    assert box[2] / box[3] == pytest.approx(0.41)


def test_deformed_boxes_use_the_whole_range() -> None:
    generator = np.random.default_rng(0)
    changes = np.array([deformed(PERSON, generator) for _ in range(500)])
    shift = changes[:, :2] + 0.5 * changes[:, 2:] - (PERSON[:2] + 0.5 * PERSON[2:])
    for values in (*shift.T, changes[:, 3] - 96.0):
        assert values.min() < -4.5 and values.max() > 4.5 and abs(values.mean()) < 0.5


@pytest.mark.parametrize("kind", range(4))
@given(seed=seeds)
def test_a_misplaced_box_overlaps_the_person_by_a_tenth_to_45_percent(kind: int, seed: int) -> None:
    box = misplaced(PERSON, kind, np.random.default_rng(seed))
    assert 0.1 < intersection_over_union(box, PERSON)[0, 0] < 0.45
    assert box[2] / box[3] == pytest.approx(0.41)


def test_the_four_kinds_of_misplaced_boxes_are_beside_too_large_too_small_and_too_high_or_low() -> None:
    generator = np.random.default_rng(0)
    boxes = np.array([[misplaced(PERSON, kind + 4 * (n % 2), generator) for n in range(200)] for kind in range(4)])
    shift = (boxes[..., :2] + 0.5 * boxes[..., 2:] - (PERSON[:2] + 0.5 * PERSON[2:])) / 96.0
    beside, large, small, high = range(4)
    assert np.abs(shift[beside, :, 0]).min() >= 0.12 and np.abs(shift[beside, :, 1]).mean() < 0.06
    assert boxes[large, :, 3].min() >= 1.3 * 96.0
    assert boxes[small, :, 3].max() <= 0.75 * 96.0
    assert np.abs(shift[high, :, 1]).min() >= 0.25 and np.abs(shift[high, :, 0]).mean() < 0.1
    for values in (shift[beside, :, 0], shift[high, :, 1]):
        assert 0.35 < np.mean(values > 0.0) < 0.65  # both sides


def test_a_box_is_placed_by_parts_of_its_height_around_its_centre() -> None:
    assert placed(np.array([10.0, 20.0, 40.0, 100.0]), 0.1, -0.2, 1.5) == pytest.approx([10.0, -25.0, 60.0, 150.0])


def test_negatives_are_at_most_18_per_photograph(tmp_path: Path) -> None:
    files = train_backgrounds(write_pictures(tmp_path))
    samples = samples_of_background(files, everything_detector(), SIZE, PAPER)
    counts = np.bincount(samples.sources)
    assert len(counts) == 3
    assert (counts > 0).all() and (counts <= 18).all()
    assert samples.labels.sum() == 0


def test_the_whole_proposer_and_the_weakened_one_each_give_their_number(tmp_path: Path) -> None:
    files = train_backgrounds(write_pictures(tmp_path))
    recipe = replace(PAPER, weak_negatives=2, strong_negatives=1)
    samples = samples_of_background(files, everything_detector(), SIZE, recipe)
    assert samples.sources.tolist() == [0, 0, 0, 1, 1, 1, 2, 2, 2]


def test_weakened_proposer_scores_with_the_first_trees_only() -> None:
    image = np.full((200, 150, 3), 90, np.uint8)
    found = everything_detector(trees=40).detect(image)
    weak = weakened(everything_detector(trees=40), trees=32).detect(image)
    assert set(found.scores) == {40.0}
    assert set(weak.scores) == {32.0}


def test_people_and_background_never_share_the_number_of_a_photograph(tmp_path: Path) -> None:
    lines: list[str] = []
    recipe = replace(PAPER, misplaced=1, weak_negatives=2)
    data = write_pictures(tmp_path)
    samples = collect_samples(data, everything_detector(), SIZE, recipe, np.random.default_rng(0), lines.append)
    assert lines == ["8 crops of people, 4 beside them", "6 hard negatives"]
    assert samples.labels.tolist() == [1, 1, 0] * 4 + [0] * 6
    assert samples.sources.tolist() == [0] * 6 + [1] * 6 + [2, 2, 3, 3, 4, 4]


def test_split_keeps_all_crops_of_a_photograph_on_one_side() -> None:
    sources = np.repeat(np.arange(50), 4)
    labels = (sources < 20).astype(np.int64)
    labels[sources < 10] &= np.arange(40) % 4 < 2  # misplaced boxes beside people
    samples = Samples(np.zeros((200, 8, 8, 3), np.uint8), labels, sources)
    training, validation = split(samples, 0.1, np.random.default_rng(0))
    assert len(set(validation.sources) & set(range(20))) == 2
    assert len(set(validation.sources) - set(range(20))) == 3
    assert (len(training.labels), len(validation.labels)) == (180, 20)
    assert not set(training.sources) & set(validation.sources)


@given(seeds, st.floats(0.01, 0.99), st.integers(2, 12), st.integers(2, 12))
def test_both_classes_are_on_both_sides_of_every_split(seed: int, part: float, first: int, second: int) -> None:
    samples = numbered([1] * first + [0] * second, list(range(first + second)))
    training, validation = split(samples, part, np.random.default_rng(seed))
    assert set(training.labels) == set(validation.labels) == {0, 1}
    assert len(training.labels) + len(validation.labels) == first + second


@pytest.mark.parametrize(
    ("samples", "name"),
    [
        (numbered([0, 0, 0, 1, 1], [0, 1, 2, 3, 3]), "1 photographs show people"),
        (numbered([0, 0, 1, 1], [0, 0, 1, 2]), "1 photographs show nobody"),
        (numbered([0, 1, 1], [1, 1, 2]), "0 photographs show nobody"),
    ],
)
def test_class_with_less_than_two_photographs_cannot_be_split(samples: Samples, name: str) -> None:
    with pytest.raises(BadInputError, match=name):
        split(samples, 0.1, np.random.default_rng(0))


@pytest.mark.data
def test_inria_gives_2416_crops_of_607_photographs(data_folder: Path) -> None:
    samples = samples_around_people(train_people(data_folder), (32, 16), PAPER, np.random.default_rng(0))
    assert len(samples.labels) == 2 * 2416
    assert len(np.unique(samples.sources)) == 607
