"""Training of the CNN: samples, split, augmentation, a run on a few pictures."""

from pathlib import Path

import cv2
import numpy as np
import pytest
import torch

from han_bullet.detection.acf import AcfDetector
from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.cnn import Classifier, load_network
from han_bullet.detection.networks import SmallVgg
from han_bullet.detection.training.cnn_samples import (
    HARD_NEGATIVES_PER_PHOTOGRAPH,
    Samples,
    negative_samples,
    positive_samples,
    split,
    weakened,
)
from han_bullet.detection.training.cnn_training import augment, evaluate, fit, train_cnn
from han_bullet.errors import BadInputError


@pytest.fixture(autouse=True)
def one_thread():
    """Run torch in one thread: two, on a busy machine, take four times as long for nets this small."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


def everything_detector(trees: int = 40) -> AcfDetector:
    """Return a proposer that takes every window for a person: each tree adds 1, whatever it sees."""
    return AcfDetector(
        AcfModel(
            features=np.zeros((trees, 3), np.int32),
            thresholds=np.zeros((trees, 3), np.float32),
            leaves=np.ones((trees, 4), np.float32),
            lambdas=(0.0, 0.1, 0.1),
        )
    )


def write_pictures(folder: Path) -> Path:
    """Write four crops of two photographs of bright bars, and three dark photographs, laid out as INRIA is."""
    generator = np.random.default_rng(0)
    for name in ("crop1a", "crop1b", "crop2a", "crop2b"):
        picture = generator.integers(0, 40, (160, 96, 3), dtype=np.uint8)
        picture[32:128, 36:60] = 230
        _write(folder / "inria" / "train_pos" / f"{name}.png", picture)
    for name in ("one", "two", "three"):
        _write(folder / "inria" / "train_neg" / f"{name}.png", generator.integers(0, 40, (240, 200, 3), dtype=np.uint8))
    return folder


def _write(path: Path, picture: np.ndarray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), picture)


def bars(count: int, generator: np.random.Generator) -> Samples:
    """Return samples that a net can tell apart: half with a bright upright bar."""
    crops = generator.integers(0, 80, (count, 64, 64, 3), dtype=np.uint8)
    labels = np.arange(count) % 2
    crops[labels == 1, 8:56, 24:40] = 220
    return Samples(crops, labels.astype(np.int64), np.arange(count))


def test_each_crop_gives_itself_and_one_jittered_window_with_the_number_of_its_photograph(tmp_path):
    folder = write_pictures(tmp_path) / "inria" / "train_pos"
    samples = positive_samples(folder, np.random.default_rng(0))
    assert samples.crops.shape == (8, 64, 64, 3)
    assert samples.labels.tolist() == [1] * 8
    assert samples.sources.tolist() == [0, 0, 0, 0, 1, 1, 1, 1]
    for exact in samples.crops[::2]:  # the bar is 96 of 123 px high and 24 of 61 wide: 50 and 25 of 64
        bright = exact[:, :, 0] > 128
        assert abs(bright[:, 32].sum() - 50) <= 2
        assert abs(bright[32].sum() - 25) <= 2
    assert not np.array_equal(samples.crops[0], samples.crops[1])


def test_negatives_are_at_most_18_per_photograph(tmp_path):
    samples = negative_samples(write_pictures(tmp_path) / "inria" / "train_neg", everything_detector())
    counts = np.bincount(samples.sources)
    assert len(counts) == 3
    assert (counts > 0).all()
    assert (counts <= HARD_NEGATIVES_PER_PHOTOGRAPH).all()
    assert samples.labels.sum() == 0


def test_weakened_proposer_scores_with_the_first_trees_only():
    image = np.full((200, 150, 3), 90, np.uint8)
    found = everything_detector(trees=40).detect(image)
    weak = weakened(everything_detector(trees=40), trees=32).detect(image)
    assert set(found.scores) == {40.0}
    assert set(weak.scores) == {32.0}


def test_split_keeps_all_crops_of_a_photograph_on_one_side():
    sources = np.repeat(np.arange(50), 4)
    labels = (sources < 20).astype(np.int64)
    samples = Samples(np.zeros((200, 64, 64, 3), np.uint8), labels, sources)
    training, validation = split(samples, 0.1, np.random.default_rng(0))
    assert validation.labels.tolist().count(1) == 2 * 4
    assert validation.labels.tolist().count(0) == 3 * 4
    assert len(training.labels) == 180
    assert not set(training.sources) & set(validation.sources)


def test_class_with_one_photograph_cannot_be_split():
    samples = Samples(np.zeros((5, 64, 64, 3), np.uint8), np.array([0, 0, 0, 1, 1]), np.array([0, 1, 2, 3, 3]))
    with pytest.raises(BadInputError, match="1 photographs show people"):
        split(samples, 0.1, np.random.default_rng(0))


def test_augmentation_changes_every_crop_repeats_with_the_seed_and_leaves_its_input_alone():
    samples = bars(8, np.random.default_rng(0))
    before = samples.crops.copy()
    first = augment(samples.crops, np.random.default_rng(5))
    assert first.dtype == np.uint8
    assert (np.abs(first.astype(int) - before).mean(axis=(1, 2, 3)) > 1.0).all()
    np.testing.assert_array_equal(first, augment(samples.crops, np.random.default_rng(5)))
    np.testing.assert_array_equal(samples.crops, before)


def test_small_net_learns_bars_and_the_same_seed_gives_the_same_file(tmp_path):
    lines = []
    for name in ("first", "second"):
        with torch.random.fork_rng():
            torch.manual_seed(1)
            network = SmallVgg(widths=(4, 8), hidden=8)
            network.start()
            samples = bars(40, np.random.default_rng(1))
            path = tmp_path / f"{name}.safetensors"
            accuracy = fit(network, samples, path, np.random.default_rng(2), 20, 0.05, lines.append)
    assert accuracy == 1.0
    assert len(lines) == 40
    assert "epoch 20/20" in lines[19]
    assert (tmp_path / "first.safetensors").read_bytes() == (tmp_path / "second.safetensors").read_bytes()
    fresh = bars(20, np.random.default_rng(9))
    assert evaluate(Classifier(load_network(path)), fresh) == (1.0, 1.0, 0.0)


def test_training_runs_from_a_folder_to_a_file_that_loads_and_leaves_the_random_state_of_torch_alone(tmp_path):
    state = torch.random.get_rng_state()
    out = tmp_path / "net.safetensors"
    lines = []
    accuracy = train_cnn(write_pictures(tmp_path), everything_detector(), out, 0, 1, lines.append, "vgg")
    assert 0.0 <= accuracy <= 1.0
    assert isinstance(load_network(out), SmallVgg)
    assert lines[0] == "8 crops of people"
    assert torch.equal(torch.random.get_rng_state(), state)


def test_missing_data_and_no_epochs_are_refused(tmp_path):
    with pytest.raises(BadInputError, match="train_pos"):
        train_cnn(tmp_path, everything_detector(), tmp_path / "net.safetensors")
    with pytest.raises(BadInputError, match="epochs is 0"):
        train_cnn(tmp_path, everything_detector(), tmp_path / "net.safetensors", epochs=0)


@pytest.mark.data
def test_inria_gives_2416_crops_of_607_photographs(data_folder):
    samples = positive_samples(data_folder / "inria" / "train_pos", np.random.default_rng(0))
    assert len(samples.labels) == 2 * 2416
    assert len(np.unique(samples.sources)) == 607
