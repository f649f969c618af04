"""VGG-shaped networks for the second stage: the paper's own, and a narrow one from scratch as ablation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from han_bullet.detection.network import (
    FULLY_CONNECTED_DEVIATION,
    LARGEST_LAYER,
    CropNetwork,
    check_sizes,
    draw_fully_connected,
)
from han_bullet.detection.tensor_file import read_tensors
from han_bullet.errors import BadInputError

# Convolutions in each block of configuration D [Simonyan2015]; every block ends by halving both sides.
BLOCKS_OF_D = ((64, 64), (128, 128), (256, 256, 256), (512, 512, 512), (512, 512, 512))
# What torchvision's VGG-16 was trained with: mean and deviation of colours from 0 to 255, in RGB.
TORCHVISION_MEAN = (123.675, 116.28, 103.53)
TORCHVISION_DEVIATION = (58.395, 57.12, 57.375)


class VggD(CropNetwork):
    """VGG, configuration D, with an input of 64 x 64 and two classes: the paper's network [Mateus2019]."""

    def __init__(self, height: int = 64, width: int = 64) -> None:
        """Lay out the layers for an input of this size [px], at least 32 x 32."""
        super().__init__(height, width, {})
        features = BLOCKS_OF_D[-1][-1] * _cells(height, width, len(BLOCKS_OF_D))
        self.features = _blocks(BLOCKS_OF_D)
        self.head = nn.Sequential(
            *(nn.Linear(features, 4096), nn.ReLU(inplace=True), nn.Dropout(0.5)),
            *(nn.Linear(4096, 4096), nn.ReLU(inplace=True), nn.Dropout(0.5)),
            nn.Linear(4096, 2),
        )

    def start(self, weights: Path | None, deviation: float = FULLY_CONNECTED_DEVIATION) -> None:
        """Take the convolutions from torchvision's VGG-16 (.pth or .safetensors), or draw them as He proposes.

        The fully connected layers are drawn at random in either case.
        """
        if weights is None:
            _draw_convolutions(self.features)
        else:
            _copy_convolutions(read_tensors(weights), self.features, weights)
        draw_fully_connected(self.head, deviation)

    def forward(self, crops: Tensor) -> Tensor:
        """Return the logits."""
        mean, deviation = (torch.tensor(v).view(1, 3, 1, 1) for v in (TORCHVISION_MEAN, TORCHVISION_DEVIATION))
        logits: Tensor = self.head(self.features((crops - mean) / deviation).flatten(1))
        return logits


class SmallVgg(CropNetwork):
    """Blocks of convolution, convolution, pooling as in VGG [Simonyan2015], narrow, and two fully connected layers."""

    def __init__(
        self, height: int = 64, width: int = 64, widths: Sequence[int] = (16, 32, 64, 128), hidden: int = 256
    ) -> None:
        """Lay out the layers.

        Args:
            height: Of the input [px].
            width: Of the input [px].
            widths: Channels of each block; each block halves both sides.
            hidden: Neurons of the first fully connected layer.
        """
        super().__init__(height, width, {"widths": list(widths), "hidden": hidden})
        cells = _cells(height, width, len(widths))
        check_sizes(LARGEST_LAYER, hidden=hidden, **{f"width of block {n}": w for n, w in enumerate(widths, start=1)})
        self.features = _blocks([(channels, channels) for channels in widths])
        self.head = nn.Sequential(
            *(nn.Linear(widths[-1] * cells, hidden), nn.ReLU(inplace=True), nn.Dropout(0.5)),
            nn.Linear(hidden, 2),
        )

    def start(self, weights: Path | None, deviation: float = FULLY_CONNECTED_DEVIATION) -> None:
        """Draw all weights at random; there are no ImageNet weights for it."""
        if weights is not None:
            raise BadInputError(f"the small network starts from scratch; {weights} is of no use to it")
        _draw_convolutions(self.features)
        draw_fully_connected(self.head, deviation)

    def forward(self, crops: Tensor) -> Tensor:
        """Return the logits."""
        logits: Tensor = self.head(self.features(crops / 127.5 - 1.0).flatten(1))
        return logits


def _blocks(blocks: Sequence[Sequence[int]]) -> nn.Sequential:
    """Return convolutions of 3 x 3 with rectifiers, numbered as torchvision numbers them."""
    layers: list[nn.Module] = []
    channels = 3
    for block in blocks:
        for width in block:
            layers += [nn.Conv2d(channels, width, 3, padding=1), nn.ReLU(inplace=True)]
            channels = width
        layers.append(nn.MaxPool2d(2))
    return nn.Sequential(*layers)


def _cells(height: int, width: int, blocks: int) -> int:
    """Return how many cells of the last block's output there are."""
    rows, columns = height >> blocks, width >> blocks
    if blocks < 1 or rows < 1 or columns < 1:
        raise BadInputError(
            f"{blocks} blocks that halve {height} x {width} px; at least one block and cell must be left"
        )
    return rows * columns


def _draw_convolutions(features: nn.Sequential) -> None:
    """Draw convolutions as He proposes for rectifiers [He2015]."""
    for layer in features:
        if isinstance(layer, nn.Conv2d):
            nn.init.kaiming_normal_(layer.weight, nonlinearity="relu")
            nn.init.zeros_(layer.bias)  # type: ignore[arg-type]


def _copy_convolutions(weights: Mapping[str, Any], features: nn.Sequential, path: Path) -> None:
    """Copy `features.<number>.weight` and `.bias` of torchvision's VGG-16."""
    for number, layer in enumerate(features):
        if not isinstance(layer, nn.Conv2d):
            continue
        for name in ("weight", "bias"):
            own, given = getattr(layer, name), weights.get(f"features.{number}.{name}")
            if not (isinstance(given, Tensor) and given.shape == own.shape and _finite_numbers(given)):
                raise BadInputError(
                    f"{path}: features.{number}.{name} must be {tuple(own.shape)} finite numbers, as in torchvision"
                )
            own.data = given.float().clone()


def _finite_numbers(tensor: Tensor) -> bool:
    return tensor.layout == torch.strided and tensor.is_floating_point() and bool(torch.isfinite(tensor).all())
