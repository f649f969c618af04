"""What every network of the second stage is: crops in, two logits out."""

from __future__ import annotations

from abc import abstractmethod
from pathlib import Path
from typing import Any

from torch import Tensor, nn

from han_bullet.errors import BadInputError

LARGEST_SIDE = 1024  # of an input [px]
LARGEST_LAYER = 65_536  # neurons or channels
# Fully connected layers start from a Gaussian of this standard deviation. The paper's variance of 0.01, a deviation of
# 0.1, starts VGG-D at a loss above 25, from where it diverges [Mateus2019].
FULLY_CONNECTED_DEVIATION = 0.01


class CropNetwork(nn.Module):
    """A network that tells pedestrians from anything else.

    It takes a batch (n, 3, height, width), RGB, 0 to 255, float32, and gives logits (n, 2): other, pedestrian.

    Attributes:
        height, width: Of its input [px].
        arguments: What its constructor needs to build it again.
    """

    def __init__(self, height: int, width: int, others: dict[str, Any]) -> None:
        """Note the size of the input [px] and what else the constructor was given.

        Raises:
            BadInputError: The size is no size; a file of weights may claim anything.
        """
        super().__init__()
        check_sizes(LARGEST_SIDE, height=height, width=width)
        self.height, self.width = height, width
        self.arguments = {"height": height, "width": width, **others}

    @abstractmethod
    def start(self, weights: Path | None, deviation: float = FULLY_CONNECTED_DEVIATION) -> None:
        """Set the weights from which training starts.

        Args:
            weights: Of an ImageNet network; what a network takes, it says itself.
            deviation: Standard deviation of the fully connected layers' weights, which are always drawn.

        Raises:
            BadInputError: The file is not what the network needs.
        """

    @abstractmethod
    def forward(self, crops: Tensor) -> Tensor:
        """Return the logits."""


def check_sizes(largest: int, **sizes: object) -> None:
    """Make sure that sizes, by their names, are whole numbers from 1 to the largest.

    Raises:
        BadInputError: One is not.
    """
    for name, size in sizes.items():
        if type(size) is not int or not 1 <= size <= largest:
            raise BadInputError(f"{name} is {size!r}; a whole number from 1 to {largest} would be right")


def draw_fully_connected(head: nn.Module, deviation: float) -> None:
    """Draw the weights of all fully connected layers from a zero-mean Gaussian; biases are zero."""
    for layer in head.modules():
        if isinstance(layer, nn.Linear):
            nn.init.normal_(layer.weight, std=deviation)
            nn.init.zeros_(layer.bias)
