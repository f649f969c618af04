"""The state of an interrupted training: what resuming gives, and what is refused."""

import pickle
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from little_samples import bar_samples, everything_detector, small_network, write_pictures

from han_bullet.detection.training.checkpoint import Checkpoint, checkpoint_file, require_checkpoint
from han_bullet.detection.training.cnn_training import CnnTraining, fit, train_cnn
from han_bullet.detection.training.recipe import Recipe
from han_bullet.errors import BadInputError

RECIPE = Recipe(epochs=4, learning_rate=0.02, falling=True, weight_decay=1e-3, augmented=True)
SMALL = CnnTraining("small")


class Interruption(Exception):
    """What stops a training half-way."""


@pytest.fixture(autouse=True)
def one_thread() -> Iterator[None]:
    """Run torch in one thread, as the command does."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


def train(
    out: Path,
    options: CnnTraining = SMALL,
    recipe: Recipe = RECIPE,
    stop_at: tuple[str, float] = ("never", 2.0),
    samples_seed: int = 1,
    network_seed: int = 3,
) -> float:
    """Train on 220 bars, three steps an epoch, until a line starts so or a share of the work is done."""

    def report(line: str, done: float) -> None:
        if line.startswith(stop_at[0]) or done > stop_at[1]:
            raise Interruption

    samples, generator = bar_samples(220, samples_seed), np.random.default_rng(2)
    with torch.random.fork_rng():
        return fit(small_network(network_seed), samples, out, recipe, options, generator, report)


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, float]:
    out = tmp_path_factory.mktemp("whole") / "net.safetensors"
    torch.set_num_threads(1)
    accuracy = train(out)
    assert not checkpoint_file(out).exists()
    return out.read_bytes(), accuracy


@pytest.mark.parametrize(
    "stop_at",
    [("epoch 1/4", 2.0), ("epoch 2/4", 2.0), ("never", 0.6), ("epoch 4/4", 2.0)],
    ids=["after the first epoch", "after the second", "within the third", "after the last"],
)
def test_a_resumed_training_gives_the_same_weights_to_the_last_bit(
    tmp_path: Path, uninterrupted: tuple[bytes, float], stop_at: tuple[str, float]
) -> None:
    out = tmp_path / "net.safetensors"
    with pytest.raises(Interruption):
        train(out, stop_at=stop_at)
    assert checkpoint_file(out).is_file()
    assert stop_at[0] == "epoch 4/4" or out.read_bytes() != uninterrupted[0]
    accuracy = train(out, replace(SMALL, resume=True))
    assert (out.read_bytes(), accuracy) == uninterrupted
    assert [path.name for path in tmp_path.iterdir()] == ["net.safetensors"]  # the checkpoint has gone


def test_a_training_interrupted_twice_gives_the_same_weights(
    tmp_path: Path, uninterrupted: tuple[bytes, float]
) -> None:
    out = tmp_path / "net.safetensors"
    for resume, line in ((False, "epoch 1/4"), (True, "epoch 3/4")):
        with pytest.raises(Interruption):
            train(out, replace(SMALL, resume=resume), stop_at=(line, 2.0))
    train(out, replace(SMALL, resume=True))
    assert out.read_bytes() == uninterrupted[0]


def test_without_resume_a_checkpoint_is_ignored(tmp_path: Path, uninterrupted: tuple[bytes, float]) -> None:
    out = tmp_path / "net.safetensors"
    with pytest.raises(Interruption):
        train(out, network_seed=4, stop_at=("epoch 2/4", 2.0))
    train(out)
    assert out.read_bytes() == uninterrupted[0]


@pytest.mark.parametrize(
    "other",
    [
        {"options": replace(SMALL, seed=1)},
        {"options": replace(SMALL, bf16=True)},
        {"recipe": replace(RECIPE, epochs=5)},
        {"recipe": replace(RECIPE, learning_rate=0.021)},
        {"samples_seed": 2},
        {"network_seed": 4},
    ],
    ids=lambda other: next(iter(other)),
)
def test_a_training_with_other_settings_samples_or_initial_weights_cannot_be_resumed(
    tmp_path: Path, other: dict[str, object]
) -> None:
    out = tmp_path / "net.safetensors"
    with pytest.raises(Interruption):
        train(out, stop_at=("epoch 1/4", 2.0))
    options = replace(other.pop("options", SMALL), resume=True)
    with pytest.raises(BadInputError, match=r"net\.safetensors\.checkpoint is of another training \(Recipe.*small"):
        train(out, options, **other)
    assert checkpoint_file(out).is_file()  # the right one can still be resumed


def test_without_a_checkpoint_nothing_is_resumed_and_that_is_told_before_samples_are_collected(tmp_path: Path) -> None:
    out = tmp_path / "net.safetensors"
    with pytest.raises(BadInputError, match=r"no checkpoint .*net\.safetensors\.checkpoint to resume from"):
        require_checkpoint(out)
    lines: list[str] = []
    options = replace(SMALL, resume=True)
    with pytest.raises(BadInputError, match="no checkpoint"):
        train_cnn(
            write_pictures(tmp_path), everything_detector(), out, RECIPE, options, lambda *said: lines.append(said)
        )
    assert lines == []


def stored(path: Path) -> tuple[Checkpoint, torch.nn.Module, torch.optim.Optimizer]:
    """Write a checkpoint of a network of two weights after three epochs."""
    network = torch.nn.Linear(1, 1)
    optimizer = torch.optim.SGD(network.parameters(), 0.1, 0.9)
    checkpoint = Checkpoint(path, "the settings")
    checkpoint.store(network, optimizer, 3)
    return checkpoint, network, optimizer


def test_a_checkpoint_gives_back_weights_optimizer_and_epochs(tmp_path: Path) -> None:
    checkpoint, network, optimizer = stored(tmp_path / "net")
    weight = network.weight.item()
    network(torch.ones(1)).sum().backward()
    optimizer.step()
    assert network.weight.item() == pytest.approx(weight - 0.1)
    checkpoint.store(network, optimizer, 4)
    other = torch.nn.Linear(1, 1)
    fresh = torch.optim.SGD(other.parameters(), 0.7)
    assert checkpoint.restore(other, fresh) == 4
    assert other.weight.item() == network.weight.item()
    assert fresh.param_groups[0]["lr"] == 0.1
    assert fresh.state[other.weight]["momentum_buffer"].item() == pytest.approx(1.0)


def test_a_damaged_checkpoint_is_one_sentence(tmp_path: Path) -> None:
    checkpoint, network, optimizer = stored(tmp_path / "net")
    whole = checkpoint.path.read_bytes()
    for content in (b"", b"hello", whole[: len(whole) // 2], whole[:-1]):
        checkpoint.path.write_bytes(content)
        with pytest.raises(BadInputError, match=r"net\.checkpoint") as caught:
            checkpoint.restore(network, optimizer)
        assert "\n" not in str(caught.value)
    checkpoint.path.unlink()
    with pytest.raises(BadInputError, match=r"net\.checkpoint cannot be read.*No such file"):
        checkpoint.restore(network, optimizer)


@pytest.mark.parametrize("missing", ["network", "optimizer", "epochs"])
@pytest.mark.parametrize("instead", [None, {}, "text"])
def test_a_checkpoint_without_a_part_is_damaged(tmp_path: Path, missing: str, instead: object) -> None:
    checkpoint, network, optimizer = stored(tmp_path / "net")
    state = torch.load(checkpoint.path, weights_only=True)
    torch.save(state | {missing: instead}, checkpoint.path)
    with pytest.raises(BadInputError, match=r"net\.checkpoint is damaged: ") as caught:
        checkpoint.restore(network, optimizer)
    assert "\n" not in str(caught.value)


def test_objects_in_a_checkpoint_are_never_unpickled(tmp_path: Path) -> None:
    class Bomb:
        def __reduce__(self) -> tuple[object, tuple[object, ...]]:
            return (Path.touch, (tmp_path / "trace",))

    checkpoint, network, optimizer = stored(tmp_path / "net")
    state = torch.load(checkpoint.path, weights_only=True)
    pickled = pickle.dumps(state | {"epochs": Bomb()})
    torch.save(state | {"epochs": Bomb()}, checkpoint.path)
    for content in (checkpoint.path.read_bytes(), pickled):
        checkpoint.path.write_bytes(content)
        with pytest.raises(BadInputError, match="is refused"):
            checkpoint.restore(network, optimizer)
    assert not (tmp_path / "trace").exists()
    pickle.loads(pickled)
    assert (tmp_path / "trace").exists()  # so it was a bomb
