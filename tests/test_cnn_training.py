"""Training of the second stage: the learning rate, what is learned, what is refused, what repeats."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from little_samples import bar_samples, everything_detector, small_network, write_pictures

from han_bullet.detection.cnn import Classifier, load_network
from han_bullet.detection.training.cnn_training import (
    CnnTraining,
    evaluate,
    fit,
    learning_rate,
    train_cnn,
)
from han_bullet.detection.training.recipe import EXTENDED, PAPER, Recipe
from han_bullet.detection.vgg import SmallVgg
from han_bullet.errors import BadInputError

BARS = Recipe(epochs=20, learning_rate=0.05)
SMALL = CnnTraining("small")
Lines = list[tuple[str, float]]


@pytest.fixture(autouse=True)
def one_thread() -> Iterator[None]:
    """Run torch in one thread: two, on a busy machine, take four times as long for networks this small."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


def ignore(line: str, done: float) -> None:
    """Take no notice of progress."""


def fit_bars(out: Path, recipe: Recipe, lines: Lines, options: CnnTraining = SMALL, count: int = 40) -> float:
    """Train the small network to tell bars from none and return its accuracy."""
    samples, generator = bar_samples(count, seed=1), np.random.default_rng(2)
    with torch.random.fork_rng():
        return fit(
            small_network(), samples, out, recipe, options, generator, lambda line, done: lines.append((line, done))
        )


def test_the_paper_s_learning_rate_stays() -> None:
    assert {learning_rate(step, 50, PAPER) for step in range(50)} == {0.001}


def test_a_falling_learning_rate_rises_over_the_first_tenth_and_then_falls_as_a_cosine_to_nothing() -> None:
    rates = np.array(
        [learning_rate(step, 1000, replace(PAPER, learning_rate=0.5, falling=True)) for step in range(1000)]
    )
    assert rates[:100] == pytest.approx(np.linspace(0.005, 0.5, 100))
    assert rates[100:] == pytest.approx(0.25 * (1.0 + np.cos(np.pi * np.arange(1, 901) / 900)))
    assert rates[-1] == pytest.approx(0.0, abs=1e-12)
    assert rates[549] == pytest.approx(0.25)  # half of it half-way down


@pytest.mark.parametrize("steps", [1, 2, 9, 10])
def test_a_training_of_few_steps_has_rates_in_range(steps: int) -> None:
    rates = [learning_rate(step, steps, EXTENDED) for step in range(steps)]
    assert min(rates) >= 0.0 and max(rates) <= EXTENDED.learning_rate
    assert steps == 1 or max(rates) > 0.5 * EXTENDED.learning_rate


def test_a_small_network_learns_bars_and_the_same_seed_gives_the_same_file(tmp_path: Path) -> None:
    lines: Lines = []
    accuracies = [fit_bars(tmp_path / f"{name}.safetensors", BARS, lines) for name in ("first", "second")]
    assert accuracies == [1.0, 1.0]
    assert (tmp_path / "first.safetensors").read_bytes() == (tmp_path / "second.safetensors").read_bytes()
    fresh = bar_samples(20, seed=9)
    assert evaluate(Classifier(load_network(tmp_path / "first.safetensors")), fresh) == (1.0, 1.0, 0.0)
    assert evaluate(Classifier(small_network()), fresh)[0] < 1.0  # it was not born with it


def test_the_log_has_a_line_per_epoch_and_the_first_losses_and_progress_never_falls(tmp_path: Path) -> None:
    lines: Lines = []
    fit_bars(tmp_path / "net.safetensors", replace(BARS, epochs=3), lines)
    said = [line for line, _ in lines if line]
    assert [line.split(":")[0] for line in said] == ["step 1", "epoch 1/3", "epoch 2/3", "epoch 3/3"]
    assert float(said[0].split()[-1]) == pytest.approx(0.693, abs=0.1)  # ln 2: it knows nothing yet
    done = [share for _, share in lines]
    assert done == sorted(done) and done[-1] == 1.0


def test_another_seed_or_augmentation_gives_other_weights(tmp_path: Path) -> None:
    recipe = replace(BARS, epochs=2)
    kinds = {
        "as it is": (recipe, SMALL),
        "seed": (recipe, replace(SMALL, seed=1)),
        "augmented": (replace(recipe, augmented=True), SMALL),
        "decay": (replace(recipe, weight_decay=0.1), SMALL),
        "falling": (replace(recipe, falling=True), SMALL),
        "bf16": (recipe, replace(SMALL, bf16=True)),
    }
    for name, (changed, options) in kinds.items():
        fit_bars(tmp_path / name, changed, [], options)
    assert len({(tmp_path / name).read_bytes() for name in kinds}) == len(kinds)


@pytest.mark.parametrize(
    ("count", "what"),
    [(220, "the loss is (nan|inf) in step 2 of epoch 1"), (40, "after epoch 1 weights are not finite")],
    ids=["in the second step", "after the only step"],
)
def test_a_training_that_diverges_ends_in_one_sentence_and_leaves_earlier_weights_alone(
    tmp_path: Path, count: int, what: str
) -> None:
    out = tmp_path / "net.safetensors"
    out.write_text("earlier")
    with pytest.raises(BadInputError, match=rf"^{what}: a learning rate of 1e\+18 is too high.*try a tenth of it$"):
        fit_bars(out, replace(BARS, learning_rate=1e18), [], count=count)
    assert out.read_text() == "earlier"


def test_training_runs_from_a_folder_to_a_file_that_loads_and_leaves_the_random_state_of_torch_alone(
    tmp_path: Path,
) -> None:
    state = torch.random.get_rng_state()
    data, out, lines = write_pictures(tmp_path), tmp_path / "net.safetensors", []
    recipe = replace(PAPER, epochs=1, weak_negatives=4)
    accuracy = train_cnn(data, everything_detector(), out, recipe, SMALL, lambda line, done: lines.append(line))
    assert 0.0 <= accuracy <= 1.0
    assert isinstance(load_network(out), SmallVgg)
    assert lines[:2] == ["8 crops of people, 0 beside them", "12 hard negatives"]
    assert torch.equal(torch.random.get_rng_state(), state)
    assert {path.name for path in tmp_path.iterdir()} == {"inria", "net.safetensors"}


def test_the_deviation_of_the_fully_connected_layers_decides_the_first_loss(tmp_path: Path) -> None:
    data, first_losses = write_pictures(tmp_path), []
    for deviation in (0.001, 1.0):
        lines: list[str] = []
        options = replace(SMALL, deviation=deviation)
        recipe = replace(PAPER, epochs=1, learning_rate=1e-9, weak_negatives=4)
        train_cnn(data, everything_detector(), tmp_path / "net", recipe, options, lambda line, done: lines.append(line))  # noqa: B023
        first_losses.append(float(next(line for line in lines if line.startswith("step 1:")).split()[-1]))
    assert first_losses[0] == pytest.approx(0.6931, abs=1e-3)
    assert first_losses[1] > 5.0


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"network": "vgg"}, "network 'vgg' is not known; there are vgg-d, squeezenet, small"),
        ({"deviation": 0.0}, r"deviation of the initial weights is 0\.0"),
        ({"deviation": float("nan")}, "is nan"),
        ({"deviation": float("inf")}, "is inf"),
    ],
)
def test_options_out_of_range_are_refused(change: dict[str, object], sentence: str) -> None:
    with pytest.raises(BadInputError, match=sentence):
        CnnTraining(**change)


def test_missing_data_and_missing_imagenet_weights_are_refused(tmp_path: Path) -> None:
    for options in (SMALL, CnnTraining()):  # of these the second takes its first weights from the same folder
        with pytest.raises(BadInputError, match="neither inria/ nor INRIAPerson"):
            train_cnn(tmp_path, everything_detector(), tmp_path / "net", PAPER, options, ignore)
    with pytest.raises(BadInputError, match=r"compressed_SqueezeNet\.net is missing"):
        train_cnn(write_pictures(tmp_path), everything_detector(), tmp_path / "net", PAPER, CnnTraining(), ignore)
    assert not (tmp_path / "net").exists()
