"""Trains the CNN of the second stage on photographs, for pictures that it never saw: renderings, noisy cameras."""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import nn

from han_bullet.detection.acf import AcfDetector
from han_bullet.detection.cnn import NETWORKS, Classifier, as_batch, load_network, save_network
from han_bullet.detection.inria import train_people
from han_bullet.detection.network import FULLY_CONNECTED_DEVIATION, CropNetwork
from han_bullet.detection.training.augmentation import augment, centre
from han_bullet.detection.training.checkpoint import Checkpoint, require_checkpoint
from han_bullet.detection.training.cnn_samples import Samples, collect_samples, split
from han_bullet.detection.training.recipe import Recipe
from han_bullet.errors import BadInputError

Report = Callable[[str, float], None]
"""Gets a line for the log and the share of the whole work that is done, in [0, 1]."""

BATCH = 100
MOMENTUM = 0.9
VALIDATION_PART = 0.1
RISING_PART = 0.1  # of the steps of a falling learning rate
FIRST_STEPS = 10  # whose losses the log has: they show whether the initial weights suit the learning rate
IMAGENET_FILE = Path("squeezenet") / "compressed_SqueezeNet.net"


@dataclass(frozen=True)
class CnnTraining:
    """How to train, apart from the recipe.

    Attributes:
        network: "vgg-d", "squeezenet" or "small".
        weights: From which the network starts; None takes squeezenet's from the data folder, draws others at random.
        seed: Of split, boxes, initial weights, order and augmentation.
        bf16: Whether to multiply in bfloat16: half the time on processors that have it, other last digits.
        resume: Whether to go on from the last whole epoch of an interrupted training with the same settings.
        deviation: Standard deviation of the fully connected layers' initial weights.
    """

    network: str = "squeezenet"
    weights: Path | None = None
    seed: int = 0
    bf16: bool = False
    resume: bool = False
    deviation: float = FULLY_CONNECTED_DEVIATION

    def __post_init__(self) -> None:
        """Check the network's name and the deviation."""
        if self.network not in NETWORKS:
            raise BadInputError(f"network {self.network!r} is not known; there are {', '.join(NETWORKS)}")
        if not 0.0 < self.deviation < math.inf:
            raise BadInputError(f"deviation of the initial weights is {self.deviation}; above 0 would be right")


def train_cnn(data: Path, acf: AcfDetector, out: Path, recipe: Recipe, options: CnnTraining, report: Report) -> float:
    """Train a classifier of ACF's proposals and write it.

    The file is written after every epoch, and a checkpoint beside it (`<out>.checkpoint`), which goes when the training
    is complete. The same seed gives the same weights with the same number of torch threads, resumed or not.

    Args:
        data: Folder with the INRIA photographs and, to start SqueezeNet from ImageNet, squeezenet/.
        acf: The proposer that, and whose weakened form, finds the hard negatives.
        out: A .safetensors file.
        recipe: What to train on and for how long.
        options: Which network, seed.
        report: Told the progress, a line at a time.

    Returns:
        Accuracy of the written weights on the validation part, in [0, 1].

    Raises:
        BadInputError: The data or the initial weights are missing or no use, or there is nothing to resume.
    """
    if options.resume:
        require_checkpoint(out)
    train_people(data)  # a folder of no use is told before weights that should lie in it
    generator = np.random.default_rng(options.seed)
    with torch.random.fork_rng():
        torch.manual_seed(options.seed)
        network: CropNetwork = NETWORKS[options.network]()
        network.start(_initial_weights(options, data), options.deviation)
        size = (network.height, network.width)
        samples = collect_samples(data, acf, size, recipe, generator, lambda line: report(line, 0.0))
        return fit(network, samples, out, recipe, options, generator, report)


def fit(
    network: CropNetwork,
    samples: Samples,
    out: Path,
    recipe: Recipe,
    options: CnnTraining,
    generator: np.random.Generator,
    report: Report,
) -> float:
    """Train a network on nine tenths of the samples by stochastic gradient descent; see `train_cnn`."""
    training, validation = split(samples, VALIDATION_PART, generator)
    network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    optimizer = torch.optim.SGD(
        network.parameters(), recipe.learning_rate, MOMENTUM, weight_decay=recipe.weight_decay, nesterov=recipe.falling
    )
    checkpoint = Checkpoint(out, _settings(network, samples, recipe, options))
    done = checkpoint.restore(network, optimizer) if options.resume else 0
    # It may have been interrupted after its last epoch.
    accuracy = 0.0 if done < recipe.epochs else evaluate(Classifier(load_network(out)), validation)[0]
    for epoch in range(done, recipe.epochs):
        loss = _run_epoch(network, training, optimizer, epoch, recipe, options, report)
        save_network(network, out)
        checkpoint.store(network, optimizer, epoch + 1)
        accuracy, hit, false = evaluate(Classifier(load_network(out)), validation)
        report(
            f"epoch {epoch + 1}/{recipe.epochs}: training loss {loss:.4f}, validation accuracy {accuracy:.2%}, "
            f"people kept {hit:.2%}, others kept {false:.2%}",
            (epoch + 1) / recipe.epochs,
        )
    checkpoint.remove()
    return accuracy


def evaluate(classifier: Classifier, samples: Samples) -> tuple[float, float, float]:
    """Return accuracy, part of the people kept and part of the others kept, each in [0, 1]."""
    batches = [samples.crops[start : start + BATCH] for start in range(0, len(samples.crops), BATCH)]
    chances = np.concatenate([classifier.probabilities_of_crops(centre(batch, classifier.size)) for batch in batches])
    kept, people = chances >= classifier.least_probability, samples.labels == 1
    return float((kept == people).mean()), float(kept[people].mean()), float(kept[~people].mean())


def learning_rate(step: int, steps: int, recipe: Recipe) -> float:
    """Return the learning rate of a step, counted from 0, of all."""
    if not recipe.falling:
        return recipe.learning_rate
    done = (step + 1) / steps
    if done <= RISING_PART:
        return recipe.learning_rate * done / RISING_PART
    return recipe.learning_rate * 0.5 * (1.0 + math.cos(math.pi * (done - RISING_PART) / (1.0 - RISING_PART)))


def _initial_weights(options: CnnTraining, data: Path) -> Path | None:
    """Return the file of the weights from which training starts; None draws them at random."""
    weights = data / IMAGENET_FILE if options.network == "squeezenet" and options.weights is None else options.weights
    if weights is not None and options.network != "small" and not weights.is_file():
        raise BadInputError(f"file of the initial weights {weights} is missing; --weights FILE gives another")
    return weights


def _settings(network: CropNetwork, samples: Samples, recipe: Recipe, options: CnnTraining) -> str:
    """Return everything that decides what a training does; initial weights and samples as checksums."""
    weights = data = 0
    for weight in network.state_dict().values():
        weights = zlib.crc32(np.ascontiguousarray(weight.numpy()).data, weights)
    for part in (samples.crops, samples.labels, samples.sources):
        data = zlib.crc32(np.ascontiguousarray(part).data, data)
    how = f"{recipe}, {options.network}, seed {options.seed}, bf16 {options.bf16}"
    return f"{how}, initial weights {weights:08x}, samples {data:08x}"


def _run_epoch(
    network: CropNetwork,
    samples: Samples,
    optimizer: torch.optim.Optimizer,
    epoch: int,
    recipe: Recipe,
    options: CnnTraining,
    report: Report,
) -> float:
    """Pass once over the samples and return the mean loss."""
    network.train()
    # Each epoch draws from a generator of its own, so that a resumed training draws the same.
    torch.manual_seed(options.seed + epoch)
    generator = np.random.default_rng([options.seed, epoch])
    batches = math.ceil(len(samples.labels) / BATCH)
    losses = []
    for number, (crops, labels) in enumerate(_batches(samples, network, recipe, generator)):
        for group in optimizer.param_groups:
            group["lr"] = learning_rate(epoch * batches + number, recipe.epochs * batches, recipe)
        optimizer.zero_grad()
        with torch.autocast("cpu", torch.bfloat16, enabled=options.bf16):
            logits = network(crops)
        loss = nn.functional.cross_entropy(logits.float(), labels)
        if not torch.isfinite(loss):
            raise _diverged(f"the loss is {loss.item()} in step {number + 1} of epoch {epoch + 1}", recipe)
        loss.backward()  # type: ignore[no-untyped-call]
        optimizer.step()
        losses.append(loss.item())
        shown = f"step {number + 1}: loss {loss.item():.4f}" if epoch == 0 and number < FIRST_STEPS else ""
        report(shown, (epoch + (number + 1) / batches) / recipe.epochs)
    if not all(bool(torch.isfinite(weight.half()).all()) for weight in network.parameters()):
        raise _diverged(f"after epoch {epoch + 1} weights are not finite", recipe)
    return float(np.mean(losses))


def _diverged(what: str, recipe: Recipe) -> BadInputError:
    return BadInputError(
        f"{what}: a learning rate of {recipe.learning_rate} is too high for this network's initial weights; "
        "try a tenth of it"
    )


def _batches(
    samples: Samples, network: CropNetwork, recipe: Recipe, generator: np.random.Generator
) -> Iterator[tuple[torch.Tensor, torch.Tensor]]:
    size = (network.height, network.width)
    order = generator.permutation(len(samples.labels))
    for start in range(0, len(order), BATCH):
        rows = order[start : start + BATCH]
        crops = samples.crops[rows]
        inputs = augment(crops, size, generator) if recipe.augmented else centre(crops, size)
        yield as_batch(inputs), torch.from_numpy(samples.labels[rows])
