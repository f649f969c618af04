"""Reciprocals as rough as the original's, for classifiers that were trained on channels computed with them.

The original [Dollar2014] uses the processor's approximate reciprocals, good to 12 bits. Where colours hardly differ the
error is a texture of its own, which the normalisation of gradients amplifies, and a classifier has learned with it. The
rule here gives the same bits as the instructions do: one value for each of 2048 intervals to the octave, the true one
in its middle, rounded to 13 binary places.
"""

from __future__ import annotations

import functools

import numba
import numpy as np
from numpy.typing import NDArray

Bits = NDArray[np.int32]

_PLACES = 2.0**13
_INTERVALS = 2048
_MANTISSA_BITS, _BIAS = 23, 127


@functools.cache
def reciprocal_table() -> Bits:
    """Return the bits of the reciprocals of the 2048 intervals of [1, 2)."""
    middles = 1.0 + (np.arange(_INTERVALS) + 0.5) / _INTERVALS
    return _rounded_bits(1.0 / middles)


@functools.cache
def root_table() -> Bits:
    """Return the bits of the reciprocal roots of the 1024 intervals of [2, 4), then of the 1024 of [1, 2)."""
    middles = 1.0 + (np.arange(_INTERVALS // 2) + 0.5) / (_INTERVALS // 2)
    return _rounded_bits(1.0 / np.sqrt(np.concatenate([2.0 * middles, middles])))


def _rounded_bits(values: NDArray[np.float64]) -> Bits:
    return (np.rint(values * _PLACES) / _PLACES).astype(np.float32).view(np.int32)


@numba.njit(cache=True)
def invert(line: NDArray[np.float32], table: Bits) -> None:
    """Replace positive numbers by their rough reciprocals."""
    bits = line.view(np.int32)
    for place in range(bits.size):
        exponent = (bits[place] >> _MANTISSA_BITS) - _BIAS
        bits[place] = table[(bits[place] >> 12) & 2047] - (exponent << _MANTISSA_BITS)


@numba.njit(cache=True)
def invert_root(line: NDArray[np.float32], table: Bits) -> None:
    """Replace positive numbers by the rough reciprocals of their roots."""
    bits = line.view(np.int32)
    for place in range(bits.size):
        # The exponent's last bit and the ten first bits behind the point choose the interval.
        half = ((bits[place] >> _MANTISSA_BITS) - _BIAS) >> 1
        bits[place] = table[(bits[place] >> 13) & 2047] - (half << _MANTISSA_BITS)
