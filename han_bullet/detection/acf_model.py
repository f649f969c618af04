"""The model of the ACF detector: its values, checked, and its file."""

from __future__ import annotations

import io
import math
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from han_bullet.atomic_file import write_at_once
from han_bullet.detection.cascade import Ints
from han_bullet.detection.channels import CELL, CHANNELS, Floats
from han_bullet.detection.filters import HALVING
from han_bullet.detection.npz_file import read_npz
from han_bullet.detection.pyramid import PADDING_COLUMNS, PADDING_ROWS, PyramidSettings
from han_bullet.errors import BadInputError, quoted

LARGEST_DEPTH = 8  # of a tree; boosted trees are shallow
CELLS = (2, 4)  # [px] sides that a model's cells may have
LARGEST_WINDOW = 1024  # [px] of a side; a file that asks for more is broken or hostile
LARGEST_FILTER = 15  # [cells] of a side
MOST_FILTERS = 16


@dataclass(frozen=True)
class AcfModel:
    """A boosted classifier of trees over the channels of one window, and what is needed to apply it.

    With filters, the trees look at filtered channels in cells twice as large [Nam2014]. All trees are complete and
    equally deep. The children of node k are 2k + 1 (left) and 2k + 2 (right).

    Attributes:
        features: Of each node: index into a window laid out (row, column, channel), shape (trees, 2^depth - 1).
        thresholds: A value below goes left, shape (trees, 2^depth - 1).
        leaves: Score that each leaf adds, from left to right, calibration included, shape (trees, 2^depth).
        lambdas: How colour, magnitude and orientation channels fade with scale.
        person_height, person_width: Size of the person in the window [px].
        window_height, window_width: Size of the window with its margin [px].
        cascade_threshold: A window is given up as soon as its sum is not above this.
        score_threshold: Recommended smallest score of a detection; -inf where none has been chosen.
        cell: Side of the cells in which channels are computed [px].
        padding_height, padding_width: How far windows may reach beyond the image [px].
        filters: Each applied to each channel, shape (filters, rows, columns, 10); None for plain channels.
        rough: Whether it was trained on channels with reciprocals as rough as the original's.
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
    cell: int = CELL
    padding_height: int = PADDING_ROWS * CELL
    padding_width: int = PADDING_COLUMNS * CELL
    filters: Floats | None = None
    rough: bool = False

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
        self._check_sizes()
        if trees == 0 or self.features.min() < 0 or self.features.max() >= self.window_values:
            raise BadInputError(f"ACF model: {trees} trees; features must lie in 0 .. {self.window_values - 1}")
        numbers = (*self.lambdas, self.cascade_threshold, float(self.leaves.sum()), float(self.thresholds.sum()))
        if len(self.lambdas) != 3 or not np.isfinite(numbers).all() or math.isnan(self.score_threshold):
            raise BadInputError(
                f"ACF model: thresholds, leaves, the three lambdas {self.lambdas} and the cascade threshold "
                f"{self.cascade_threshold} must be finite, the score threshold {self.score_threshold} a number"
            )

    def _check_sizes(self) -> None:
        """Check person, window, cells, padding and filters."""
        person, window = (self.person_height, self.person_width), (self.window_height, self.window_width)
        if not (0 < person[0] <= window[0] <= LARGEST_WINDOW and 0 < person[1] <= window[1] <= LARGEST_WINDOW):
            raise BadInputError(
                f"ACF model: a person of {person[0]} x {person[1]} px must fit the window of {window[0]} x {window[1]} "
                f"px, of {LARGEST_WINDOW} px at most"
            )
        if self.cell not in CELLS or any(side % self.window_cell for side in window):
            raise BadInputError(
                f"ACF model: window {window[0]} x {window[1]} px must be whole cells, and the cells of "
                f"{self.cell} px be of {' or '.join(map(str, CELLS))} px"
            )
        padding = (self.padding_height, self.padding_width)
        if any(side % self.cell or not 0 <= side <= LARGEST_WINDOW for side in padding):
            raise BadInputError(
                f"ACF model: padding of {padding[0]} x {padding[1]} px must be whole cells of {self.cell} px, of "
                f"{LARGEST_WINDOW} px at most"
            )
        if self.filters is not None:
            count, height, width, channels = self.filters.shape if self.filters.ndim == 4 else (0, 0, 0, 0)
            odd = height % 2 == width % 2 == 1 and max(height, width) <= LARGEST_FILTER
            if not (odd and 0 < count <= MOST_FILTERS and channels == CHANNELS and np.isfinite(self.filters).all()):
                raise BadInputError(
                    f"ACF model: filters {self.filters.shape} must be finite numbers of shape (n, h, w, {CHANNELS}), "
                    f"n from 1 to {MOST_FILTERS}, h and w odd and {LARGEST_FILTER} at most"
                )

    @property
    def depth(self) -> int:
        """Return how many comparisons lead to a leaf."""
        return self.leaves.shape[1].bit_length() - 1

    @property
    def window_cell(self) -> int:
        """Return the side of the cells that the trees look at, which is also the step between windows [px]."""
        return self.cell if self.filters is None else HALVING * self.cell

    @property
    def window_channels(self) -> int:
        """Return how many channels the trees look at."""
        return CHANNELS if self.filters is None else CHANNELS * len(self.filters)

    @property
    def pyramid_settings(self) -> PyramidSettings:
        """Return what it asks of the pyramid."""
        return PyramidSettings(
            self.lambdas,
            (self.person_height, self.person_width),
            self.cell,
            (self.padding_height // self.cell, self.padding_width // self.cell),
            self.rough,
        )

    @property
    def window_values(self) -> int:
        """Return how many channel values a window has."""
        return self.window_height * self.window_width // self.window_cell**2 * self.window_channels

    @property
    def smallest_box_area(self) -> int:
        """Return the area [px^2] of a box at the image's own scale, the finest."""
        return self.person_height * self.person_width

    def save(self, path: Path) -> None:
        """Write the model as a compressed npz file without pickled objects, at once."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        arrays: dict[str, Any] = {name: np.asarray(value) for name, value in values.items() if value is not None}
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
            return cls._from_arrays(read_npz(path, [field.name for field in fields(cls)]))
        except (OSError, ValueError, KeyError, TypeError, OverflowError) as error:
            raise BadInputError(
                f"{path} is not an ACF model (npz as AcfModel.save writes it): {quoted(error)}"
            ) from error

    @classmethod
    def _from_arrays(cls, values: dict[str, NDArray[np.generic]]) -> AcfModel:
        """Build a model from the arrays of its file."""
        colour, magnitude, orientation = (float(value) for value in values["lambdas"])
        # Files of the first version have plain cells and no filters.
        sizes = {name: int(values[name]) for name in ("cell", "padding_height", "padding_width") if name in values}
        filters = np.ascontiguousarray(values["filters"], np.float32) if "filters" in values else None
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
            filters=filters,
            rough=bool(values.get("rough", False)),
            **sizes,
        )

    def with_score_threshold(self, score_threshold: float) -> AcfModel:
        """Return the same model with another recommended threshold."""
        return replace(self, score_threshold=score_threshold)
