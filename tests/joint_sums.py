"""Joint events counted one by one, with numbers that neither under- nor overflow, to hold cleverer sums against."""

import math
from collections.abc import Sequence
from decimal import Decimal
from itertools import product

import numpy as np


def one_by_one(ratios: Sequence[Sequence[Decimal]]) -> np.ndarray:
    """Return how probable each pair of a track and a measurement is, shape (n, m).

    Args:
        ratios: Of an event with a pair to the same event without it, n rows of m; 0 where the pair is impossible.
    """
    n, m = len(ratios), len(ratios[0]) if ratios else 0
    pairs, whole = [[Decimal(0)] * m for _ in range(n)], Decimal(0)
    for event in product(range(-1, m), repeat=n):
        used = [column for column in event if column >= 0]
        if len(set(used)) < len(used):
            continue
        probability = math.prod((ratios[i][j] for i, j in enumerate(event) if j >= 0), start=Decimal(1))
        whole += probability
        for i, j in enumerate(event):
            if j >= 0:
                pairs[i][j] += probability
    return np.array([[float(pair / whole) for pair in row] for row in pairs]).reshape(n, m)
