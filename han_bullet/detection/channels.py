"""The ten aggregated channels of an image: colour (L, U, V), gradient magnitude, six orientations [Dollar2014].

Everything is float32; cells are 4 x 4 px unless a model asks for others. Channel arrays are laid out (row, column,
channel), so that resampling and smoothing run over contiguous memory.
"""

from __future__ import annotations

import functools
import math

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.detection.rough_reciprocals import Bits, invert, invert_root, reciprocal_table, root_table
from han_bullet.errors import BadInputError

Float = np.float32
Floats = NDArray[np.float32]

CELL = 4  # [px] side of a cell, the "shrink" of [Dollar2014]
CHANNELS = 10
ORIENTATIONS = 6
KIND_OF_CHANNEL = np.array([0, 0, 0, 1, 2, 2, 2, 2, 2, 2])  # colour, magnitude, orientation: each fades by its own law

NORMALISATION_RADIUS = 5  # [px] neighbourhood that a gradient is compared with
REACH = (
    1 + 1 + NORMALISATION_RADIUS
)  # [px] beyond a cell that its channels depend on: smoothing, gradient, neighbourhood
NORMALISATION_OFFSET = np.float32(0.005)  # keeps flat regions from becoming noise
COSINE_STEPS = 10_000  # per unit; the original's resolution, kept so that scores agree with it
COSINE_MARGIN = 10  # entries beyond +-1 that rounding may reach

_ROWS_KEPT = 16  # more than the 11 rows of magnitudes that the normalisation looks at

_ZERO = np.float32(0.0)
_HALF = np.float32(0.5)
_ONE = np.float32(1.0)
_TWO = np.float32(2.0)
_SIXTEENTH = np.float32(1.0 / 16.0)
_SMALLEST_SQUARE = np.float32(1e-20)  # squared magnitude floor: no division by zero
_STEPS = np.float32(COSINE_STEPS)


@functools.cache
def orientation_table() -> Floats:
    """Return the direction in [0, 6) [bins] of the cosines -1, -1 + 1/10000, .. 1, with a margin at both ends."""
    steps = np.arange(-COSINE_STEPS - COSINE_MARGIN, COSINE_STEPS + COSINE_MARGIN + 1) / COSINE_STEPS
    angle = np.minimum(np.arccos(np.clip(steps, -1.0, 1.0)), math.pi - 1e-6)
    table: Floats = (angle * ORIENTATIONS / math.pi).astype(np.float32)
    return table


def compute_channels(
    planes: Floats, cell: int = CELL, rough: bool = False, part: tuple[slice, slice] | None = None
) -> Floats:
    """Return the channels, (h/cell, w/cell, 10), before the final smoothing, of L, U and V planes, (3, h, w).

    The planes are smoothed first (radius 1 px); gradients are taken on the smoothed planes and divided by their
    neighbourhood, a triangle-weighted mean of radius 5 px.

    Args:
        planes: Height and width must be multiples of the cell's side.
        cell: Side of a cell [px].
        rough: Whether to compute with reciprocals as rough as the original's.
        part: Rows and columns of the planes [px] to take as if they were all; None takes all. More than REACH from its
            edges the channels are those of the whole.

    Raises:
        BadInputError: The planes, or the part of them, are not whole cells.
    """
    rows, columns = part or (slice(0, planes.shape[1]), slice(0, planes.shape[2]))
    height, width = rows.stop - rows.start, columns.stop - columns.start
    if height % cell or width % cell:
        raise BadInputError(f"planes of {height} x {width} px are not whole cells of {cell} px")
    tables = orientation_table(), reciprocal_table(), root_table()
    channels: Floats = _compute_channels(
        planes, (rows.start, rows.stop, columns.start, columns.stop), cell, rough, *tables
    )
    return channels


@numba.njit(cache=True, error_model="numpy")
def _compute_channels(
    planes: Floats,
    part: tuple[int, int, int, int],
    cell: int,
    rough: bool,
    orientations: Floats,
    reciprocals: Bits,
    roots: Bits,
) -> Floats:
    """Stream the rows through smoothing, gradient, normalisation and summing, so that all stays in the cache."""
    first, last, left, right = part[0], part[1] - 1, part[2], part[3]
    height, width = part[1] - part[0], part[3] - part[2]
    channels = np.zeros((height // cell, width // cell, CHANNELS), np.float32)
    per_cell = np.float32(1.0 / (cell * cell))
    smoothed = np.empty((_ROWS_KEPT, 3, width), np.float32)
    magnitude, orientation = np.empty((_ROWS_KEPT, width), np.float32), np.empty((_ROWS_KEPT, width), np.float32)
    line = np.empty(width + 2 * NORMALISATION_RADIUS, np.float32)
    weight = np.empty(width, np.float32)
    for step in range(height + 1 + NORMALISATION_RADIUS):
        if step < height:
            for plane in range(3):
                above = planes[plane, max(first + step - 1, first), left:right]
                here = planes[plane, first + step, left:right]
                below = planes[plane, min(first + step + 1, last), left:right]
                _smooth_row(above, here, below, line, smoothed[step % _ROWS_KEPT, plane])
        row = step - 1
        if 0 <= row < height:
            kept = row % _ROWS_KEPT
            _gradient_row(smoothed, row, height, magnitude[kept], orientation[kept])
            if rough:
                _rough_polar_row(magnitude[kept], orientation[kept], reciprocals, roots)
            else:
                _polar_row(magnitude[kept], orientation[kept])
            for x in range(width):
                orientation[kept, x] = orientations[np.int32(orientation[kept, x]) + COSINE_STEPS + COSINE_MARGIN]
        row = step - 1 - NORMALISATION_RADIUS
        if row >= 0:
            kept = row % _ROWS_KEPT
            _neighbourhood_row(magnitude, row, height, line, weight)
            if rough:
                invert(weight, reciprocals)
                for x in range(width):
                    weight[x] *= magnitude[kept, x]
                    weight[x] *= per_cell
            else:
                for x in range(width):
                    weight[x] = magnitude[kept, x] / weight[x] * per_cell
            if cell == CELL:  # the constant lets the compiler unroll the usual case
                _sum_into_cells(channels[row // cell], smoothed[kept], weight, orientation[kept], CELL)
            else:
                _sum_into_cells(channels[row // cell], smoothed[kept], weight, orientation[kept], cell)
    return channels


@numba.njit(cache=True, error_model="numpy")
def _smooth_row(above: Floats, here: Floats, below: Floats, line: Floats, out: Floats) -> None:
    """Smooth one row of a plane with [1 2 1] / 4 along both axes; border pixels are repeated outward."""
    width = out.size
    for x in range(width):
        line[x + 1] = (above[x] + _TWO * here[x] + below[x]) * _SIXTEENTH
    line[0], line[width + 1] = line[1], line[width]
    for x in range(width):
        out[x] = line[x] + _TWO * line[x + 1] + line[x + 2]


@numba.njit(cache=True, error_model="numpy")
def _gradient_row(smoothed: Floats, row: int, height: int, squares: Floats, towards: Floats) -> None:
    """Write one row of the strongest plane's squared gradient and the gradient's horizontal part."""
    above, below = max(row - 1, 0), min(row + 1, height - 1)
    down = _HALF if below - above == 2 else _ONE
    upper, here, lower = smoothed[above % _ROWS_KEPT], smoothed[row % _ROWS_KEPT], smoothed[below % _ROWS_KEPT]
    last = squares.size - 1
    for x in range(1, last):
        squares[x], towards[x] = _strongest(upper, here, lower, x, x - 1, x + 1, down, _HALF)
    squares[0], towards[0] = _strongest(upper, here, lower, 0, 0, 1, down, _ONE)
    squares[last], towards[last] = _strongest(upper, here, lower, last, last - 1, last, down, _ONE)


@numba.njit(cache=True, error_model="numpy", inline="always")
def _strongest(
    upper: Floats, here: Floats, lower: Floats, x: int, left: int, right: int, down: Float, across: Float
) -> tuple[Float, Float]:
    """Return square and horizontal part of the strongest plane's gradient at one pixel (the first on ties)."""
    best_x = (here[0, right] - here[0, left]) * across
    best_y = (lower[0, x] - upper[0, x]) * down
    best = best_x * best_x + best_y * best_y
    for plane in range(1, 3):
        gradient_x = (here[plane, right] - here[plane, left]) * across
        gradient_y = (lower[plane, x] - upper[plane, x]) * down
        square = gradient_x * gradient_x + gradient_y * gradient_y
        stronger = square > best
        best = square if stronger else best
        best_x = gradient_x if stronger else best_x
        best_y = gradient_y if stronger else best_y
    # Directions are taken modulo half a turn: a gradient that points up counts as its opposite.
    return max(best, _SMALLEST_SQUARE), -best_x if best_y < _ZERO else best_x


@numba.njit(cache=True, error_model="numpy")
def _polar_row(squares: Floats, towards: Floats) -> None:
    """Turn squares into magnitudes, and horizontal parts into cosines [1/10000]."""
    for x in range(squares.size):
        squares[x] = np.sqrt(squares[x])
        towards[x] = towards[x] / squares[x] * _STEPS


@numba.njit(cache=True, error_model="numpy")
def _rough_polar_row(squares: Floats, towards: Floats, reciprocals: Bits, roots: Bits) -> None:
    """Do as `_polar_row` does with rough reciprocals."""
    invert_root(squares, roots)
    for x in range(squares.size):
        towards[x] = towards[x] * squares[x] * _STEPS
    invert(squares, reciprocals)


@numba.njit(cache=True, error_model="numpy")
def _neighbourhood_row(magnitude: Floats, row: int, height: int, line: Floats, out: Floats) -> None:
    """Write what one row of magnitudes is divided by; the border is mirrored."""
    radius, width = NORMALISATION_RADIUS, out.size
    line[:] = _ZERO
    for shift in range(-radius, radius + 1):
        share = np.float32((radius + 1 - abs(shift)) / (radius + 1) ** 4)
        source = magnitude[mirror(row + shift, height) % _ROWS_KEPT]
        for x in range(width):
            line[radius + x] += share * source[x]
    for x in range(radius):
        line[radius - 1 - x] = line[radius + mirror(x, width)]
        line[radius + width + x] = line[radius + mirror(width + x, width)]
    for x in range(width):
        neighbourhood = _ZERO
        for tap in range(2 * radius + 1):
            neighbourhood += np.float32(radius + 1 - abs(tap - radius)) * line[x + tap]
        out[x] = neighbourhood + NORMALISATION_OFFSET


@numba.njit(cache=True)
def mirror(index: int, length: int) -> int:
    """Return the index inside 0 .. length - 1 that an index just outside stands for, the border pixel repeated."""
    if index < 0:
        index = -1 - index
    if index >= length:
        index = 2 * length - 1 - index
    return min(max(index, 0), length - 1)


@numba.njit(cache=True, error_model="numpy", inline="always")
def _sum_into_cells(cells: Floats, colours: Floats, weight: Floats, orientation: Floats, side: int) -> None:
    """Add one row of pixels to its row of cells: colour, magnitude, and the two direction bins nearest to each."""
    per_cell = np.float32(1.0 / (side * side))
    for column in range(cells.shape[0]):
        cell = cells[column]
        light, u, v, magnitude = cell[0], cell[1], cell[2], cell[3]  # in registers
        for x in range(column * side, (column + 1) * side):
            light += colours[0, x] * per_cell
            u += colours[1, x] * per_cell
            v += colours[2, x] * per_cell
            magnitude += weight[x]
            first = np.int32(orientation[x])
            second = first + 1 if first + 1 < ORIENTATIONS else 0
            beyond = weight[x] * (orientation[x] - np.float32(first))
            cell[4 + first] += weight[x] - beyond
            cell[4 + second] += beyond
        cell[0], cell[1], cell[2], cell[3] = light, u, v, magnitude
