"""The model of the ACF detector: its values, checked, and its file."""

from __future__ import annotations

import io
import math
import zipfile
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from han_bullet.atomic_file import write_at_once
from han_bullet.detection.cascade import Ints
from han_bullet.detection.channels import CELL, CHANNELS, Floats
from han_bullet.errors import BadInputError

LARGEST_DEPTH = 8  # of a tree; boosted trees are shallow


@dataclass(frozen=True)
class AcfModel:
    """A boosted classifier of trees over the channels of one window, and what is needed to apply it.

    All trees are complete and equally deep. The children of node k are 2k + 1 (left) and 2k + 2 (right).

    Attributes:
        features: Of each node: index into a window laid out (row, column, channel), shape (trees, 2^depth - 1).
        thresholds: A value below goes left, shape (trees, 2^depth - 1).
        leaves: Score that each leaf adds, from left to right, calibration included, shape (trees, 2^depth).
        lambdas: How colour, magnitude and orientation channels fade with scale.
        person_height, person_width: Size of the person in the window [px].
        window_height, window_width: Size of the window with its margin [px].
        cascade_threshold: A window is given up as soon as its sum is not above this.
        score_threshold: Recommended smallest score of a detection; -inf where none has been chosen.
    """

    features: Ints
    thresholds: Floats
    leaves: Floats
    lambdas: tuple[float, float, float]
    person_height: int = 100
    person_width: int = 41
    window_height: int = 128
    window_width: int = 64
    cascade_threshold: float = -1.0
    score_threshold: float = -math.inf

    def __post_init__(self) -> None:
        """Check shapes and ranges, so that no kernel ever reads outside a window."""
        shapes = self.features.shape, self.thresholds.shape, self.leaves.shape
        trees, nodes = shapes[0] if len(shapes[0]) == 2 else (0, 0)
        complete = nodes + 1 in [2**depth for depth in range(1, LARGEST_DEPTH + 1)]
        if not complete or shapes[1] != (trees, nodes) or shapes[2] != (trees, nodes + 1):
            raise BadInputError(
                f"ACF model: features {shapes[0]}, thresholds {shapes[1]} and leaves {shapes[2]} must be "
                f"(trees, 2^d - 1), (trees, 2^d - 1) and (trees, 2^d) with a depth d of 1 to {LARGEST_DEPTH}"
            )
        if not (0 < self.person_height <= self.window_height and 0 < self.person_width <= self.window_width):
            raise BadInputError(f"ACF model: a person of {self.person_height} px does not fit {self.window_height} px")
        if self.window_height % CELL or self.window_width % CELL:
            raise BadInputError(f"ACF model: window {self.window_height} x {self.window_width} px must be whole cells")
        if trees == 0 or self.features.min() < 0 or self.features.max() >= self.window_values:
            raise BadInputError(f"ACF model: {trees} trees; features must lie in 0 .. {self.window_values - 1}")
        numbers = (*self.lambdas, self.cascade_threshold, float(self.leaves.sum()), float(self.thresholds.sum()))
        if len(self.lambdas) != 3 or not np.isfinite(numbers).all() or math.isnan(self.score_threshold):
            raise BadInputError(
                f"ACF model: thresholds, leaves, the three lambdas {self.lambdas} and the cascade threshold "
                f"{self.cascade_threshold} must be finite, the score threshold {self.score_threshold} a number"
            )

    @property
    def depth(self) -> int:
        """Return how many comparisons lead to a leaf."""
        return self.leaves.shape[1].bit_length() - 1

    @property
    def window_values(self) -> int:
        """Return how many channel values a window has."""
        return self.window_height * self.window_width // CELL**2 * CHANNELS

    @property
    def smallest_box_area(self) -> int:
        """Return the area [px^2] of a box at the image's own scale, the finest."""
        return self.person_height * self.person_width

    def save(self, path: Path) -> None:
        """Write the model as a compressed npz file without pickled objects, at once."""
        arrays: dict[str, Any] = {field.name: np.asarray(getattr(self, field.name)) for field in fields(self)}
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **arrays)
        write_at_once(path, buffer.getvalue())

    @classmethod
    def load(cls, path: Path) -> AcfModel:
        """Read a model that `save` wrote.

        Raises:
            BadInputError: If the file is missing or is not such a model.
        """
        try:
            with np.load(path, allow_pickle=False) as archive:
                values = {name: archive[name] for name in archive.files}
            return cls._from_arrays(values)
        except (OSError, ValueError, KeyError, TypeError, AttributeError, zipfile.BadZipFile, EOFError) as error:
            raise BadInputError(f"{path} is not an ACF model (npz as AcfModel.save writes it): {error}") from error

    @classmethod
    def _from_arrays(cls, values: dict[str, NDArray[np.generic]]) -> AcfModel:
        """Build a model from the arrays of its file."""
        colour, magnitude, orientation = (float(value) for value in values["lambdas"])
        return cls(
            features=np.ascontiguousarray(values["features"], np.int32),
            thresholds=np.ascontiguousarray(values["thresholds"], np.float32),
            leaves=np.ascontiguousarray(values["leaves"], np.float32),
            lambdas=(colour, magnitude, orientation),
            person_height=int(values["person_height"]),
            person_width=int(values["person_width"]),
            window_height=int(values["window_height"]),
            window_width=int(values["window_width"]),
            cascade_threshold=float(values["cascade_threshold"]),
            score_threshold=float(values["score_threshold"]),
        )

    def with_score_threshold(self, score_threshold: float) -> AcfModel:
        """Return the same model with another recommended threshold."""
        return replace(self, score_threshold=score_threshold)
