"""The second stage's default network: SqueezeNet 1.0 from ImageNet, cut short, with two fully connected layers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from han_bullet.detection.network import (
    FULLY_CONNECTED_DEVIATION,
    LARGEST_LAYER,
    CropNetwork,
    check_sizes,
    draw_fully_connected,
)
from han_bullet.errors import BadInputError, quoted

Floats = NDArray[np.float32]

# Input, squeeze and expand channels of the fire modules 2 to 8 of SqueezeNet 1.0.
FIRES = (
    (96, 16, 64),
    (128, 16, 64),
    (128, 32, 128),
    (256, 32, 128),
    (256, 48, 192),
    (384, 48, 192),
    (384, 64, 256),
)
# Activations of the last fire module are of this size, for colours from 0 to 255; the head expects about 1.
ACTIVATION = 100.0
# The colours that the ImageNet network takes as zero, in RGB.
IMAGENET_MEAN = (123.0, 117.0, 104.0)
LAYERS_IN_FILE = 26


class Fire(nn.Module):
    """A squeeze layer of 1 x 1 filters and an expand layer of 1 x 1 and 3 x 3 filters [Iandola2016]."""

    def __init__(self, channels: int, squeeze: int, expand: int) -> None:
        super().__init__()
        self.squeeze = nn.Conv2d(channels, squeeze, 1)
        self.expand1 = nn.Conv2d(squeeze, expand, 1)
        self.expand3 = nn.Conv2d(squeeze, expand, 3, padding=1)

    def forward(self, features: Tensor) -> Tensor:
        """Return the expanded features, twice `expand` channels."""
        squeezed = torch.relu(self.squeeze(features))
        return torch.relu(torch.cat([self.expand1(squeezed), self.expand3(squeezed)], dim=1))


class SqueezeTrunk(CropNetwork):
    """SqueezeNet 1.0 [Iandola2016] up to its eighth fire module, and two fully connected layers."""

    def __init__(self, height: int = 112, width: int = 56, hidden: int = 128) -> None:
        """Lay out the layers.

        Args:
            height: Of the input [px]. Twice the width keeps the window's shape.
            width: Of the input [px].
            hidden: Neurons of the first fully connected layer.
        """
        super().__init__(height, width, {"hidden": hidden})
        check_sizes(LARGEST_LAYER, hidden=hidden)
        rows, columns = (_side_after_trunk(side) for side in (height, width))
        if min(rows, columns) < 1:
            raise BadInputError(f"an input of {height} x {width} px leaves nothing after the convolutions")
        fires = [Fire(*sizes) for sizes in FIRES]
        pool = nn.MaxPool2d(3, 2, ceil_mode=True)
        self.features = nn.Sequential(
            nn.Conv2d(3, 96, 7, stride=2), nn.ReLU(inplace=True), pool, *fires[:3], pool, *fires[3:], pool
        )
        # Half of the hidden neurons are dropped in training, as in VGG.
        self.head = nn.Sequential(
            nn.Linear(512 * rows * columns, hidden), nn.ReLU(inplace=True), nn.Dropout(0.5), nn.Linear(hidden, 2)
        )

    def start(self, weights: Path | None, deviation: float = FULLY_CONNECTED_DEVIATION) -> None:
        """Take the convolutions from an ImageNet network, deep-compressed [Han2016], and draw the rest at random."""
        if weights is None:
            raise BadInputError("squeezenet starts from ImageNet weights: the file compressed_SqueezeNet.net is needed")
        convolutions = [layer for layer in self.features.modules() if isinstance(layer, nn.Conv2d)]
        decoded = decode_squeezenet(weights, [tuple(layer.weight.shape) for layer in convolutions])
        for layer, (weight, bias) in zip(convolutions, decoded, strict=True):
            layer.weight.data = torch.from_numpy(weight)
            layer.bias.data = torch.from_numpy(bias)  # type: ignore[union-attr]
        first = convolutions[0].weight
        first.data = first.data.flip(1).contiguous()  # it was trained on BGR
        draw_fully_connected(self.head, deviation)

    def forward(self, crops: Tensor) -> Tensor:
        """Return the logits."""
        mean = torch.tensor(IMAGENET_MEAN).view(1, 3, 1, 1)
        logits: Tensor = self.head(self.features(crops - mean).flatten(1) / ACTIVATION)
        return logits


def _side_after_trunk(side: int) -> int:
    """Return what is left of a side after the first convolution and three poolings, which round up."""
    side = (side - 7) // 2 + 1
    for _ in range(3):
        side = -(-(side - 3) // 2) + 1
    return side


def decode_squeezenet(path: Path, shapes: list[tuple[int, ...]]) -> list[tuple[Floats, Floats]]:
    """Read the first layers of a deep-compressed SqueezeNet 1.0 [Han2016].

    The file holds 26 counts, then per layer a codebook of 256 float32, the biases, `count` 8-bit codes and as many
    4-bit runs of zeros, low half first; weight number cumsum(run + 1) - 1 has the code's value.

    Args:
        path: The file.
        shapes: Weight shapes of the wanted layers, in order: (out, in, rows, columns).

    Returns:
        Weights of these shapes and biases (out,), float32.

    Raises:
        BadInputError: The file is missing or too short, a run leaves the layer, or a weight is not finite.
    """
    try:
        content = path.read_bytes()
        counts = np.frombuffer(content, "<u4", LAYERS_IN_FILE)
        offset = counts.nbytes
        layers: list[tuple[Floats, Floats]] = []
        for shape, count in zip(shapes, counts.tolist(), strict=False):
            codebook = np.frombuffer(content, "<f4", 256, offset)
            bias = np.frombuffer(content, "<f4", shape[0], offset + 1024)
            codes = np.frombuffer(content, np.uint8, count, offset + 1024 + bias.nbytes)
            packed = np.frombuffer(content, np.uint8, (count + 1) // 2, offset + 1024 + bias.nbytes + count)
            offset += 1024 + bias.nbytes + count + packed.nbytes
            if not (np.isfinite(codebook).all() and np.isfinite(bias).all()):
                raise ValueError(f"weights of layer {len(layers) + 1} are not all finite")
            runs = np.stack([packed & 15, packed >> 4], axis=1).ravel()[:count].astype(int)
            weight = np.zeros(int(np.prod(shape)), np.float32)
            weight[np.cumsum(runs + 1) - 1] = codebook[codes]
            layers.append((weight.reshape(shape), bias.astype(np.float32)))
    except (OSError, ValueError, IndexError) as error:
        raise BadInputError(f"{path} is not a deep-compressed SqueezeNet 1.0: {quoted(error)}") from error
    return layers
