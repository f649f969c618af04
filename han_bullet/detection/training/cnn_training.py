"""Trains the CNN of the second stage on photographs, for pictures that it never saw: renderings, noisy cameras."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Literal

import cv2
import numpy as np
import torch
from torch import nn

from han_bullet.detection.acf import AcfDetector
from han_bullet.detection.cnn import Classifier, as_batch, load_network, save_network
from han_bullet.detection.networks import SIDE, SmallVgg, SqueezeTrunk
from han_bullet.detection.pictures import Image
from han_bullet.detection.training.cnn_samples import Samples, collect_samples, split
from han_bullet.errors import BadInputError

Network = SmallVgg | SqueezeTrunk
Report = Callable[[str], None]

# The paper has ten, for a net that starts from other weights; with the ImageNet trunk, validation stops improving here,
# and the whole training takes a few minutes of one core.
EPOCHS = 4
BATCH = 100
MOMENTUM = 0.9
VALIDATION_PART = 0.1
# The paper fine-tunes at 0.001; a net from scratch hardly leaves its start at that in ten epochs.
LEARNING_RATES = {"vgg": 0.01, "squeezenet": 0.003}
# Proposals sit less exactly on people than training crops do: half a scale and half a cell of ACF, and more.
LARGEST_SHIFT = 3.0  # [px] of 64
LARGEST_ZOOM = 0.07
WEIGHT_DECAY = 5e-4  # as VGG was trained [Simonyan2015]
SQUEEZENET_FILE = Path("squeezenet") / "compressed_SqueezeNet.net"


def train_cnn(
    data: Path,
    acf: AcfDetector,
    out: Path,
    seed: int = 0,
    epochs: int = EPOCHS,
    report: Report = lambda line: None,
    architecture: Literal["squeezenet", "vgg"] = "squeezenet",
) -> float:
    """Train a classifier of ACF's proposals and write it.

    The file is written after every epoch, so that an interrupted training leaves a usable one. The same seed gives the
    same weights with the same number of torch threads.

    Args:
        data: Folder with inria/ and squeezenet/ (the latter to start from ImageNet).
        acf: The proposer, whose weakened form finds the hard negatives.
        out: A .safetensors file.
        seed: Of jitter, split, initial weights, order and augmentation.
        epochs: Passes over the training part.
        report: Told the progress, a line at a time.
        architecture: "squeezenet" from ImageNet or "vgg" from scratch.

    Returns:
        Accuracy of the written weights on the validation part, in [0, 1].

    Raises:
        BadInputError: The data are missing or the number of epochs is not positive.
    """
    if epochs < 1:
        raise BadInputError(f"epochs is {epochs}; 1 or more would be right")
    generator = np.random.default_rng(seed)
    samples = collect_samples(data, acf, generator, report)
    with torch.random.fork_rng():
        torch.manual_seed(seed)
        network = _new_network(architecture, data)
        return fit(network, samples, out, generator, epochs, LEARNING_RATES[architecture], report)


def fit(
    network: Network,
    samples: Samples,
    out: Path,
    generator: np.random.Generator,
    epochs: int,
    learning_rate: float,
    report: Report,
) -> float:
    """Train a network on nine tenths of the samples by stochastic gradient descent; see `train_cnn`."""
    training, validation = split(samples, VALIDATION_PART, generator)
    network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    optimizer = torch.optim.SGD(network.parameters(), learning_rate, MOMENTUM, weight_decay=WEIGHT_DECAY)
    steps = epochs * math.ceil(len(training.labels) / BATCH)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps)
    accuracy = 0.0
    for epoch in range(1, epochs + 1):
        loss = _run_epoch(network, training, optimizer, schedule, generator)
        save_network(network, out)
        accuracy, hit, false = evaluate(Classifier(load_network(out)), validation)
        report(
            f"epoch {epoch}/{epochs}: training loss {loss:.4f}, validation accuracy {100 * accuracy:.2f} %, "
            f"people kept {100 * hit:.2f} %, others kept {100 * false:.2f} %"
        )
    return accuracy


def evaluate(classifier: Classifier, samples: Samples) -> tuple[float, float, float]:
    """Return accuracy, part of the people kept and part of the others kept, each in [0, 1]."""
    batches = [samples.crops[start : start + BATCH] for start in range(0, len(samples.crops), BATCH)]
    chances = np.concatenate([classifier.probabilities_of_crops(batch) for batch in batches])
    kept, people = chances >= classifier.least_probability, samples.labels == 1
    return float((kept == people).mean()), float(kept[people].mean()), float(kept[~people].mean())


def augment(crops: Image, generator: np.random.Generator) -> Image:
    """Change place, light, colour, sharpness and noise of crops, (n, 64, 64, 3), each in its own way; mirror half.

    Renderings have flat colours, hard edges and lights unlike photographs', and cameras add noise: none of these may
    matter.
    """
    return np.stack([_augmented(picture, generator) for picture in crops])


def _augmented(crop: Image, generator: np.random.Generator) -> Image:
    if generator.random() < 0.5:
        crop = crop[:, ::-1]
    crop = _changed_sharpness(_moved(np.ascontiguousarray(crop), generator), generator)
    picture = crop.astype(np.float32)
    grey = picture.mean(axis=2, keepdims=True)
    picture = grey + generator.uniform(0.2, 1.4) * (picture - grey)  # saturation
    gain = generator.uniform(0.6, 1.4) * generator.uniform(0.85, 1.15, 3)  # contrast and colour of the light
    picture = (picture - 128.0) * gain + 128.0 + generator.uniform(-40.0, 40.0)
    if generator.random() < 0.5:
        picture = picture + generator.normal(0.0, generator.uniform(0.0, 8.0), picture.shape)
    augmented: Image = np.clip(np.round(picture), 0, 255).astype(np.uint8)
    return augmented


def _moved(crop: Image, generator: np.random.Generator) -> Image:
    zoom = 1.0 + generator.uniform(-LARGEST_ZOOM, LARGEST_ZOOM)
    middle = 0.5 * (SIDE - 1)
    shift = middle * (1.0 - zoom) + generator.uniform(-LARGEST_SHIFT, LARGEST_SHIFT, 2)
    warp = np.array([[zoom, 0.0, shift[0]], [0.0, zoom, shift[1]]])
    moved: Image = cv2.warpAffine(crop, warp, (SIDE, SIDE), borderMode=cv2.BORDER_REPLICATE)  # type: ignore[assignment]
    return moved


def _changed_sharpness(crop: Image, generator: np.random.Generator) -> Image:
    choice = generator.random()
    if choice < 0.25:
        return cv2.GaussianBlur(crop, (0, 0), generator.uniform(0.3, 1.3)).astype(np.uint8)
    if choice < 0.5:  # flattens texture and keeps edges, as renderings have them
        return cv2.medianBlur(crop, 3 if choice < 0.4 else 5).astype(np.uint8)
    return crop


def _run_epoch(
    network: Network,
    samples: Samples,
    optimizer: torch.optim.Optimizer,
    schedule: torch.optim.lr_scheduler.LRScheduler,
    generator: np.random.Generator,
) -> float:
    """Pass once over the samples and return the mean loss."""
    network.train()
    losses = []
    for crops, labels in _batches(samples, generator):
        optimizer.zero_grad()
        loss = nn.functional.cross_entropy(network(crops), labels)
        loss.backward()  # type: ignore[no-untyped-call]
        optimizer.step()
        schedule.step()
        losses.append(loss.item())
    return float(np.mean(losses))


def _batches(samples: Samples, generator: np.random.Generator) -> Iterator[tuple[torch.Tensor, torch.Tensor]]:
    order = generator.permutation(len(samples.labels))
    for start in range(0, len(order), BATCH):
        rows = order[start : start + BATCH]
        yield as_batch(augment(samples.crops[rows], generator)), torch.from_numpy(samples.labels[rows])


def _new_network(architecture: Literal["squeezenet", "vgg"], data: Path) -> Network:
    if architecture == "squeezenet":
        trunk = SqueezeTrunk()
        trunk.start(data / SQUEEZENET_FILE)
        return trunk
    network = SmallVgg()
    network.start()
    return network
