"""The second stage: a convolutional network that says of each proposal whether it is a pedestrian [Mateus2019]."""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping
from pathlib import Path

import cv2
import numpy as np
import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor

from han_bullet.atomic_file import write_at_once
from han_bullet.detection.model_files import DEFAULT, classifier_file
from han_bullet.detection.network import CropNetwork
from han_bullet.detection.pictures import Image, cut
from han_bullet.detection.squeezenet import SqueezeTrunk
from han_bullet.detection.vgg import SmallVgg, VggD
from han_bullet.errors import BadInputError, quoted
from han_bullet.geometry import Array

# The network sees the padded window of ACF's INRIA model, 64 x 128 around a person of 100: what surrounds a body helps
# to tell it from a post. The paper squeezes it to a square; SqueezeNet gets it in its own shape.
WINDOW_HEIGHT = 1.28  # of the box's height
WINDOW_WIDTH = 0.64  # of the box's height, so that a box of any proportion gives undistorted people
LEAST_PROBABILITY = 0.5  # of a proposal that is kept: the likelier of the two classes, as in the paper

Network = VggD | SqueezeTrunk | SmallVgg
NETWORKS: Mapping[str, type[Network]] = {"vgg-d": VggD, "squeezenet": SqueezeTrunk, "small": SmallVgg}


class Classifier:
    """Gives proposals the probability of being a pedestrian.

    The same boxes in the same image give the same numbers to the last bit; other boxes in the batch, or more torch
    threads, may change the last bits.

    Attributes:
        least_probability: From which a proposal is kept.
        size: Height and width of the crops that it takes [px].
    """

    def __init__(self, network: CropNetwork, least_probability: float = LEAST_PROBABILITY) -> None:
        """Take a network and the decision."""
        if not 0.0 <= least_probability <= 1.0:
            raise BadInputError(f"least probability is {least_probability}; 0 to 1 would be right")
        self.least_probability = least_probability
        self.size = (network.height, network.width)
        self._network = _frozen(network)

    def probabilities(self, image: Image, boxes: Array) -> Array:
        """Return the probability that each box, (n, 4) x, y, width, height [px], holds a pedestrian, shape (n,)."""
        return self.probabilities_of_crops(crop(image, boxes, self.size))

    def probabilities_of_crops(self, crops: Image) -> Array:
        """Return the same for crops, shape (n, height, width, 3)."""
        if len(crops) == 0:
            return np.zeros(0)
        with torch.inference_mode():
            logits: Tensor = self._network(as_batch(crops))
            chances: Array = torch.softmax(logits, dim=1)[:, 1].numpy().astype(np.float64)
        return chances


def _frozen(network: CropNetwork) -> torch.jit.ScriptModule:
    """Return a network that only answers: the same numbers to the last bit, a tenth sooner."""
    network = network.to(memory_format=torch.channels_last).eval()  # type: ignore[call-overload]
    example = as_batch(np.zeros((1, network.height, network.width, 3), np.uint8))
    with torch.inference_mode(), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # colours are subtracted as constants, which is what they are
        # The check would trace again and import SymPy to compare: half a second, for networks without branches.
        traced = torch.jit.trace(network, example, check_trace=False)  # type: ignore[no-untyped-call]
        frozen: torch.jit.ScriptModule = torch.jit.freeze(traced)
    return frozen


def crop(image: Image, boxes: Array, size: tuple[int, int], margin: float = 1.0) -> Image:
    """Cut a network's input out of an image.

    The window has the box's centre, 0.64 times its height as width and 1.28 times as height; beyond the image's edge
    the edge repeats, as for ACF.

    Args:
        image: RGB, (height, width, 3).
        boxes: (n, 4): x, y, width, height [px].
        size: Height and width of the input [px].
        margin: How many times as large window and input are cut, for training.

    Returns:
        Shape (n, margin * height, margin * width, 3).
    """
    rows, columns = round(size[0] * margin), round(size[1] * margin)
    crops = np.empty((len(boxes), rows, columns, 3), np.uint8)
    for index, (x, y, width, height) in enumerate(np.asarray(boxes, float).reshape(-1, 4)):
        window = np.array([WINDOW_WIDTH, WINDOW_HEIGHT]) * height * margin
        left, top = np.round([x + 0.5 * (width - window[0]), y + 0.5 * (height - window[1])]).astype(int)
        across, down = np.maximum(np.round(window).astype(int), 1)
        part = cut(image, left, top, left + across, top + down)
        how = cv2.INTER_AREA if down > rows else cv2.INTER_LINEAR
        crops[index] = cv2.resize(part, (columns, rows), interpolation=how)
    return crops


def as_batch(crops: Image) -> Tensor:
    """Return crops (n, h, w, 3) as the float tensor (n, 3, h, w) that networks take, channels last in memory."""
    return torch.from_numpy(np.ascontiguousarray(crops)).float().permute(0, 3, 1, 2)


def save_network(network: CropNetwork, path: Path) -> None:
    """Write a network's weights as safetensors, in half precision, with its architecture."""
    names: dict[type[CropNetwork], str] = {kind: name for name, kind in NETWORKS.items()}
    description = json.dumps({"architecture": names[type(network)], "arguments": network.arguments})
    weights = {name: weight.half().contiguous() for name, weight in network.state_dict().items()}
    write_at_once(path, save(weights, {"network": description}))  # one entry: several come in random order


def load_network(path: Path) -> CropNetwork:
    """Read a network that `save_network` wrote.

    Raises:
        BadInputError: The file is missing, malformed, of another architecture, or has weights that are not finite.
    """
    try:
        with safe_open(path, framework="pt") as file:
            network = _described_network(file.metadata() or {})
            weights = {name: file.get_tensor(name).float() for name in file.keys()}  # noqa: SIM118 (it is no mapping)
        network.load_state_dict(weights, assign=True)
    except (OSError, SafetensorError, KeyError, TypeError, ValueError, RuntimeError, BadInputError) as error:
        raise BadInputError(
            f"{path} is not a pedestrian classifier (safetensors by `train cnn`): {quoted(error)}"
        ) from error
    for name, weight in weights.items():
        if not torch.isfinite(weight).all():
            raise BadInputError(f"{path}: weights {name!r} are not all finite; train or download it again")
    return network


def _described_network(metadata: Mapping[str, str]) -> CropNetwork:
    """Return the network that a file says it holds, without weights."""
    if "network" not in metadata:
        raise BadInputError("it does not say which network it is of")
    description = json.loads(metadata["network"])
    name = description["architecture"]
    if name not in NETWORKS:
        raise BadInputError(f"its network is {name!r}; {', '.join(NETWORKS)} would be right")
    with torch.device("meta"):  # no random weights first: they would take memory and advance torch's generator
        return NETWORKS[name](**description["arguments"])


def load_classifier(name_or_path: str | Path = DEFAULT) -> Classifier:
    """Load a classifier: "default", the name of a shipped one ("cnn_inria"), or a file, .safetensors.

    Raises:
        BadInputError: No such model, or it is not one.
    """
    return Classifier(load_network(classifier_file(name_or_path)))
