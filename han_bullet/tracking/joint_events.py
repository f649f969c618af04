"""Sums over all joint events of a cluster of tracks and measurements: exact, in an order that keeps the work small."""

from __future__ import annotations

import math
from itertools import count
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array

# Partial sums of a cluster: 14 tracks that all may have any of 14 measurements need nearly as many, and some 30 ms.
# Twenty people who walk about in 5 x 5 m need a hundred; packed half a metre apart and all known to 0.2 m only, some
# ten thousands. A cluster that needs more loses its least likely pairs, see `thinned`: it is exact no longer.
MOST_SUMS = 1 << 18
# Part of its pairs, besides each row's best, that such a cluster loses at a time.
THINNING = 0.1
# By how many powers of two two numbers differ -> the factor; from the last of these on, the smaller one is nothing.
POWERS = 2.0 ** -np.arange(1000)

Exponents = NDArray[np.int64]


class Sweep(NamedTuple):
    """An order in which rows choose their columns, and which choices the later rows have to know.

    Attributes:
        order: Rows, in the order in which they choose.
        slots: Of each column, the bit that says whether it has been taken. A column that no later row wants leaves its
            bit to another; one that only one row wants has none: the bit `width`, which is never set.
        kept: Of each row in the order, the mask of the bits that later rows ask for.
        width: Number of bits.
    """

    order: list[int]
    slots: list[int]
    kept: list[int]
    width: int

    @property
    def sums(self) -> int:
        """Return how many partial sums the sweep needs: one for each row and set of taken columns."""
        return (len(self.order) + 1) << self.width


def pair_probabilities(log_ratios: Array) -> Array:
    """Return how probable each pair of a row and a column is, over all events that pair no row or column twice.

    An event's probability is proportional to the product of its pairs' ratios, so that 1 is that of the event without
    pairs. A product of a few ratios may be too large or too small for a float, so each number has its power of two.

    Args:
        log_ratios: Natural logarithms of the pairs' ratios, -inf where a pair is impossible, shape (n, m).
    """
    if 1 in log_ratios.shape:  # nearly every cluster: its events are its pairs, and that without any
        alone: Array = np.exp(log_ratios - np.logaddexp.reduce(log_ratios, axis=None, initial=0.0))
        return alone
    if log_ratios.shape[0] < log_ratios.shape[1]:  # sets of the fewer are fewer sets
        return pair_probabilities(np.ascontiguousarray(log_ratios.T)).T
    sweep = plan(log_ratios > -np.inf)
    while sweep.sums > MOST_SUMS:
        log_ratios = thinned(log_ratios)
        sweep = plan(log_ratios > -np.inf)
    ordered = log_ratios[sweep.order]
    exponents = np.where(ordered > -np.inf, np.ceil(ordered / math.log(2.0)), 0.0)
    mantissas = np.exp(ordered - exponents * math.log(2.0))
    slots, kept = np.array(sweep.slots), np.array(sweep.kept)
    pairs, powers, whole, whole_power = _sum_up(mantissas, exponents.astype(np.int64), slots, kept, sweep.width)
    probabilities = np.empty(log_ratios.shape)
    probabilities[sweep.order] = np.ldexp(pairs / whole, powers - whole_power)
    return probabilities


def thinned(log_ratios: Array) -> Array:
    """Return log ratios (n, m) without the least likely of the pairs that are not their row's best.

    Likely is measured against the row's best pair. The sums over the events that are left are exact.
    """
    behind_best = log_ratios.max(axis=1, keepdims=True) - log_ratios
    behind_best[np.arange(len(log_ratios)), log_ratios.argmax(axis=1)] = np.nan  # each row's best stays
    others = np.flatnonzero(behind_best < np.inf)
    weakest = others[np.argsort(-behind_best.ravel()[others], kind="stable")]
    left = log_ratios.copy()
    left.ravel()[weakest[: math.ceil(THINNING * len(weakest))]] = -np.inf
    return left


def plan(possible: NDArray[np.bool_]) -> Sweep:
    """Return a sweep over the rows of possible pairs (n, m) that has few columns in mind at a time."""
    order = _order([sum(1 << int(j) for j in np.flatnonzero(row)) for row in possible])
    users = [np.flatnonzero(column).tolist() for column in possible[order].T]
    slots, busy, kept = [-1] * len(users), set[int](), []
    for k in range(len(order)):
        for j in (j for j, rows in enumerate(users) if len(rows) > 1 and rows[0] == k):
            slots[j] = next(slot for slot in count() if slot not in busy)
            busy.add(slots[j])
        busy -= {slots[j] for j, rows in enumerate(users) if rows and rows[-1] == k}
        kept.append(sum(1 << slot for slot in busy))
    width = 1 + max(slots, default=-1)
    return Sweep(order, [width if slot < 0 else slot for slot in slots], kept, width)


def _order(wanted: list[int]) -> list[int]:
    """Return rows, each a mask of the columns that it wants, in an order for a sweep.

    Next is always the row after which the fewest columns are wanted both by a row that has chosen and by one that has
    not: people in a line are swept from one end to the other, whatever the order of their tracks.
    """
    left, opened, order = list(range(len(wanted))), 0, list[int]()
    while left:
        once = twice = 0
        for row in left:
            twice |= once & wanted[row]
            once |= wanted[row]
        after = [(((opened & ~wanted[row]) | (wanted[row] & twice)), row) for row in left]
        opened, row = min(after, key=lambda pair: pair[0].bit_count())
        order.append(row)
        left.remove(row)
    return order


@numba.njit(cache=True)
def _sum_up(
    mantissas: Array, exponents: Exponents, slots: Exponents, kept: Exponents, width: int
) -> tuple[Array, Exponents, float, int]:
    """Return the summed products of the events with each pair, two (n, m), and of all events.

    Each number is a mantissa and a power of two. The rows are in the order of a sweep. `ahead` sums over the choices of
    the rows before one, `behind` over those from it on, both per set of columns that have been taken and are still
    wanted (a bit mask): all events with the same set go on alike.
    """
    rows, columns = mantissas.shape
    ahead, ahead_exponents = np.zeros((rows + 1, 1 << width)), np.zeros((rows + 1, 1 << width), np.int64)
    ahead[0, 0] = 1.0
    for i in range(rows):
        sums, powers = ahead[i + 1], ahead_exponents[i + 1]
        for taken in range(1 << width):
            value, power = ahead[i, taken], ahead_exponents[i, taken]
            if value == 0.0:
                continue
            _add(sums, powers, taken & kept[i], value, power)
            for j in range(columns):
                if mantissas[i, j] > 0.0 and not taken >> slots[j] & 1:
                    after = (taken | 1 << slots[j]) & kept[i]
                    _add(sums, powers, after, value * mantissas[i, j], power + exponents[i, j])
    pairs, pairs_exponents = np.zeros((rows, columns)), np.zeros((rows, columns), np.int64)
    behind, behind_exponents = np.ones(1 << width), np.zeros(1 << width, np.int64)
    for i in range(rows - 1, -1, -1):
        found, found_exponents = pairs[i], pairs_exponents[i]
        here, here_exponents = np.zeros(1 << width), np.zeros(1 << width, np.int64)
        for taken in range(1 << width):
            value, power = ahead[i, taken], ahead_exponents[i, taken]
            if value == 0.0:
                continue
            here[taken], here_exponents[taken] = behind[taken & kept[i]], behind_exponents[taken & kept[i]]
            for j in range(columns):
                if mantissas[i, j] > 0.0 and not taken >> slots[j] & 1:
                    after = (taken | 1 << slots[j]) & kept[i]
                    rest, rest_power = mantissas[i, j] * behind[after], exponents[i, j] + behind_exponents[after]
                    _add(here, here_exponents, taken, rest, rest_power)
                    _add(found, found_exponents, j, value * rest, power + rest_power)
        behind, behind_exponents = here, here_exponents
    return pairs, pairs_exponents, ahead[rows, 0], ahead_exponents[rows, 0]


@numba.njit(cache=True, inline="always")
def _add(sums: Array, exponents: Exponents, k: int, value: float, exponent: int) -> None:
    """Add value * 2^exponent to the k-th of the numbers sums * 2^exponents."""
    shift = exponent - exponents[k]
    if sums[k] == 0.0 or shift >= len(POWERS):
        sums[k], exponents[k] = value, exponent
    elif shift > 0:
        sums[k], exponents[k] = sums[k] * POWERS[shift] + value, exponent
    elif shift > -len(POWERS):
        sums[k] += value * POWERS[-shift]
