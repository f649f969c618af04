"""VGG-shaped networks for the second stage: the paper's own, and a narrow one from scratch as ablation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file
from torch import Tensor, nn

from han_bullet.detection.network import CropNetwork, draw_fully_connected
from han_bullet.errors import BadInputError

# Convolutions in each block of configuration D [Simonyan2015]; every block ends by halving both sides.
BLOCKS_OF_D = ((64, 64), (128, 128), (256, 256, 256), (512, 512, 512), (512, 512, 512))
# What torchvision's VGG-16 was trained with: mean and deviation of colours from 0 to 255, in RGB.
TORCHVISION_MEAN = (123.675, 116.28, 103.53)
TORCHVISION_DEVIATION = (58.395, 57.12, 57.375)


class VggD(CropNetwork):
    """VGG, configuration D, with an input of 64 x 64 and two classes: the paper's network [Mateus2019]."""

    def __init__(self, height: int = 64, width: int = 64) -> None:
        """Lay out the layers for an input of this size [px], multiples of 32."""
        super().__init__(height, width, {})
        self.features = _blocks(BLOCKS_OF_D)
        features = BLOCKS_OF_D[-1][-1] * _cells(height, width, len(BLOCKS_OF_D))
        self.head = nn.Sequential(
            *(nn.Linear(features, 4096), nn.ReLU(inplace=True), nn.Dropout(0.5)),
            *(nn.Linear(4096, 4096), nn.ReLU(inplace=True), nn.Dropout(0.5)),
            nn.Linear(4096, 2),
        )

    def start(self, weights: Path | None) -> None:
        """Take the convolutions from torchvision's VGG-16 (.pth or .safetensors), or draw them as He proposes.

        The fully connected layers are drawn at random in either case.
        """
        if weights is None:
            _draw_convolutions(self.features)
        else:
            _copy_convolutions(_read_weights(weights), self.features, weights)
        draw_fully_connected(self.head)

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
        self.features = _blocks([(channels, channels) for channels in widths])
        features = widths[-1] * _cells(height, width, len(widths))
        self.head = nn.Sequential(
            nn.Linear(features, hidden), nn.ReLU(inplace=True), nn.Dropout(0.5), nn.Linear(hidden, 2)
        )

    def start(self, weights: Path | None) -> None:
        """Draw all weights at random; there are no ImageNet weights for it."""
        if weights is not None:
            raise BadInputError(f"the small network starts from scratch; {weights} is of no use to it")
        _draw_convolutions(self.features)
        draw_fully_connected(self.head)

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
    shrinkage: int = 2**blocks
    return (height // shrinkage) * (width // shrinkage)


def _draw_convolutions(features: nn.Sequential) -> None:
    """Draw convolutions as He proposes for rectifiers [He2015]."""
    for layer in features:
        if isinstance(layer, nn.Conv2d):
            nn.init.kaiming_normal_(layer.weight, nonlinearity="relu")
            nn.init.zeros_(layer.bias)  # type: ignore[arg-type]


def _read_weights(path: Path) -> Mapping[str, Any]:
    """Return the tensors of a file, which can hold nothing else: nothing is unpickled but tensors."""
    try:
        if path.suffix == ".safetensors":
            return load_file(path)
        weights = torch.load(path, map_location="cpu", weights_only=True)
    except (OSError, SafetensorError, RuntimeError, ValueError, EOFError) as error:
        raise BadInputError(f"{path} holds no weights (.pth or .safetensors): {_one_line(error)}") from error
    except Exception as error:  # torch raises pickle's own errors for objects it refuses
        raise BadInputError(f"{path} holds more than weights and is refused: {_one_line(error)}") from error
    if not isinstance(weights, Mapping):
        raise BadInputError(f"{path} holds a {type(weights).__name__}; torchvision's state dict would be right")
    return weights


def _copy_convolutions(weights: Mapping[str, Any], features: nn.Sequential, path: Path) -> None:
    """Copy `features.<number>.weight` and `.bias` of torchvision's VGG-16."""
    for number, layer in enumerate(features):
        if not isinstance(layer, nn.Conv2d):
            continue
        for name in ("weight", "bias"):
            own, given = getattr(layer, name), weights.get(f"features.{number}.{name}")
            if not isinstance(given, Tensor) or given.shape != own.shape or not torch.isfinite(given).all():
                raise BadInputError(
                    f"{path}: features.{number}.{name} must be {tuple(own.shape)} finite numbers, as in torchvision"
                )
            own.data = given.float().clone()


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())[:200]
