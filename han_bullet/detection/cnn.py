"""The second stage: a convolutional network that says of each proposal whether it is a pedestrian [Mateus2019]."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import cv2
import numpy as np
import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor, nn

from han_bullet.atomic_file import write_at_once
from han_bullet.detection.model_files import DEFAULT, classifier_file
from han_bullet.detection.networks import SIDE, SmallVgg, SqueezeTrunk
from han_bullet.detection.pictures import Image, cut
from han_bullet.errors import BadInputError
from han_bullet.geometry import Array

# The network sees the padded window of ACF's INRIA model, 64 x 128 around a person of 100: what surrounds a body helps
# to tell it from a post. The window is squeezed to a square: its width matters more than its height.
WINDOW_HEIGHT = 1.28  # of the box's height
WINDOW_WIDTH = 0.64  # of the box's height, so that a box of any proportion gives undistorted people
# A proposal is kept from this probability on. A person dropped costs more than a mistake kept, which the tracker still
# has to see confirmed: 0.2 is the largest tenth at which all 540 validation people stay and 99.5 % of the rendered ones
# (0.5: 539 and 98.6 %), for 1.0 instead of 0.5 % of the hard negatives.
LEAST_PROBABILITY = 0.2

ARCHITECTURES: Mapping[str, type[SmallVgg] | type[SqueezeTrunk]] = {"vgg": SmallVgg, "squeezenet": SqueezeTrunk}


class Classifier:
    """Gives proposals the probability of being a pedestrian.

    The same boxes in the same image give the same numbers to the last bit; other boxes in the batch, or more torch
    threads, may change the last bits.

    Attributes:
        least_probability: From which a proposal is kept.
    """

    def __init__(self, network: nn.Module, least_probability: float = LEAST_PROBABILITY) -> None:
        """Take a network that maps (n, 3, 64, 64) RGB, 0 to 255, to logits (n, 2): other, pedestrian."""
        if not 0.0 <= least_probability <= 1.0:
            raise BadInputError(f"least probability is {least_probability}; 0 to 1 would be right")
        self.least_probability = least_probability
        self._network = network.to(memory_format=torch.channels_last).eval()  # type: ignore[call-overload]

    def probabilities(self, image: Image, boxes: Array) -> Array:
        """Return the probability that each box, (n, 4) x, y, width, height [px], holds a pedestrian, shape (n,)."""
        return self.probabilities_of_crops(crop(image, boxes))

    def probabilities_of_crops(self, crops: Image) -> Array:
        """Return the same for crops, shape (n, 64, 64, 3)."""
        if len(crops) == 0:
            return np.zeros(0)
        with torch.inference_mode():
            logits: Tensor = self._network(as_batch(crops))
            chances: Array = torch.softmax(logits, dim=1)[:, 1].numpy().astype(np.float64)
        return chances


def crop(image: Image, boxes: Array) -> Image:
    """Cut the network's input out of an image.

    The window has the box's centre, 0.64 times its height as width and 1.28 times as height; beyond the image's edge
    the edge repeats, as for ACF.

    Args:
        image: RGB, (height, width, 3).
        boxes: (n, 4): x, y, width, height [px].

    Returns:
        Shape (n, 64, 64, 3).
    """
    crops = np.empty((len(boxes), SIDE, SIDE, 3), np.uint8)
    for index, (x, y, width, height) in enumerate(np.asarray(boxes, float).reshape(-1, 4)):
        size = np.array([WINDOW_WIDTH, WINDOW_HEIGHT]) * height
        left, top = np.round([x + 0.5 * (width - size[0]), y + 0.5 * (height - size[1])]).astype(int)
        columns, rows = np.maximum(np.round(size).astype(int), 1)
        window = cut(image, left, top, left + columns, top + rows)
        crops[index] = cv2.resize(window, (SIDE, SIDE), interpolation=cv2.INTER_AREA)
    return crops


def as_batch(crops: Image) -> Tensor:
    """Return crops (n, 64, 64, 3) as the float tensor (n, 3, 64, 64) that networks take, channels last in memory."""
    return torch.from_numpy(np.ascontiguousarray(crops)).float().permute(0, 3, 1, 2)


def save_network(network: SmallVgg | SqueezeTrunk, path: Path) -> None:
    """Write a network's weights as safetensors, in half precision, with its architecture."""
    names = {kind: name for name, kind in ARCHITECTURES.items()}
    description = json.dumps({"architecture": names[type(network)], "arguments": network.arguments})
    weights = {name: weight.half().contiguous() for name, weight in network.state_dict().items()}
    write_at_once(path, save(weights, {"network": description}))  # one entry: several come in random order


def load_network(path: Path) -> SmallVgg | SqueezeTrunk:
    """Read a network that `save_network` wrote.

    Raises:
        BadInputError: The file is missing, malformed, of another architecture, or has weights that are not finite.
    """
    try:
        with safe_open(path, framework="pt") as file:
            metadata = file.metadata() or {}
            weights = {name: file.get_tensor(name).float() for name in file.keys()}  # noqa: SIM118 (it is no mapping)
        description = json.loads(metadata["network"])
        with torch.device("meta"):  # no random weights first: they would advance torch's generator
            network = ARCHITECTURES[description["architecture"]](**description["arguments"])
        network.load_state_dict(weights, assign=True)
    except (OSError, SafetensorError, KeyError, TypeError, ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise BadInputError(f"{path} is not a pedestrian classifier (safetensors by `train cnn`): {reason}") from error
    for name, weight in weights.items():
        if not torch.isfinite(weight).all():
            raise BadInputError(f"{path}: weights {name!r} are not all finite; train or download it again")
    return network


def load_classifier(name_or_path: str | Path = DEFAULT) -> Classifier:
    """Load a classifier: "default", the name of a shipped one ("cnn_inria"), or a file, .safetensors.

    Raises:
        BadInputError: No such model, or it is not one.
    """
    return Classifier(load_network(classifier_file(name_or_path)))
