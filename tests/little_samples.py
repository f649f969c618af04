"""What the trainings of the second stage are tried on: bright bars as people, a proposer that takes all for people."""

from pathlib import Path

import cv2
import numpy as np
import torch

from han_bullet.detection.acf import AcfDetector
from han_bullet.detection.acf_model import AcfModel
from han_bullet.detection.training.cnn_samples import Samples
from han_bullet.detection.vgg import SmallVgg


def everything_detector(trees: int = 40) -> AcfDetector:
    """Return a proposer that takes every window for a person: each tree adds 1, whatever it sees."""
    return AcfDetector(
        AcfModel(
            features=np.zeros((trees, 3), np.int32),
            thresholds=np.zeros((trees, 3), np.float32),
            leaves=np.ones((trees, 4), np.float32),
            lambdas=(0.0, 0.1, 0.1),
        )
    )


def write_pictures(folder: Path) -> Path:
    """Write four crops of two photographs of bright bars, and three dark photographs, laid out as INRIA is."""
    generator = np.random.default_rng(0)
    for name in ("crop1a", "crop1b", "crop2a", "crop2b"):
        picture = generator.integers(0, 40, (160, 96, 3), dtype=np.uint8)
        picture[32:128, 36:60] = 230
        _write(folder / "inria" / "train_pos" / f"{name}.png", picture)
    for name in ("one", "two", "three"):
        _write(folder / "inria" / "train_neg" / f"{name}.png", generator.integers(0, 40, (240, 200, 3), dtype=np.uint8))
    return folder


def bar_samples(count: int, seed: int) -> Samples:
    """Return crops of 37 x 37 px that a network can tell apart: half of them with a bright upright bar."""
    generator = np.random.default_rng(seed)
    crops = generator.integers(0, 80, (count, 37, 37, 3), dtype=np.uint8)
    labels = np.arange(count) % 2
    crops[labels == 1, 6:31, 13:24] = 220
    return Samples(crops, labels.astype(np.int64), np.arange(count))


def small_network(seed: int = 3) -> SmallVgg:
    """Return a network of 32 x 32 px with 2,866 weights."""
    with torch.random.fork_rng():
        torch.manual_seed(seed)
        network = SmallVgg(32, 32, widths=(4, 4), hidden=8)
        network.start(None)
    return network


def _write(path: Path, picture: np.ndarray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), picture)
