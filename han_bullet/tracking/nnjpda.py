"""Nearest neighbour joint probabilistic data association: exact marginals, then a hard choice [Fitzgerald1986]."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array
from han_bullet.tracking.association import Association, Gating, Pairs, take_best_first


class Nnjpda(Association):
    """Give each track the measurement that most of the probability of all joint events gives it.

    A joint event hands each track one gated measurement or none, no measurement twice. Its probability is proportional
    to the product of Pd N(z) / clutter density over the pairs and 1 - Pd Pg over the tracks without one
    [BarShalom2001]. The marginals beta_ij sum these over all events; the pairs are taken greedily, largest beta first,
    and one stands only if it is at least as probable as "track i has no measurement", beta_ij >= beta_i0.
    """

    def assign(self, gating: Gating) -> Pairs:
        """Return the pairs; see `Association.assign`."""
        beta = self.marginals(gating)
        return take_best_first(beta[:, 1:], gating.inside & (beta[:, 1:] >= beta[:, :1]))

    def marginals(self, gating: Gating) -> Array:
        """Return beta, shape (n, m + 1): column 0 "no measurement", column j + 1 measurement j; rows sum to 1."""
        weights = self.weights(gating)
        beta = np.zeros((weights.shape[0], weights.shape[1] + 1))
        beta[:, 0] = 1.0
        for tracks, measurements in clusters(gating.inside):
            cluster = _cluster_marginals(weights[np.ix_(tracks, measurements)], self.miss_weight)
            beta[tracks, 0] = cluster[:, 0]
            beta[np.ix_(tracks, measurements + 1)] = cluster[:, 1:]
        return beta


def clusters(inside: NDArray[np.bool_]) -> list[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Split gated pairs (n, m) into groups of tracks and measurements that share no pair with another group."""
    groups: list[tuple[set[int], set[int]]] = []
    for track, row in enumerate(inside):
        tracks, measurements = {track}, set(np.flatnonzero(row).tolist())
        if not measurements:
            continue
        for group in [group for group in groups if not group[1].isdisjoint(measurements)]:
            groups.remove(group)
            tracks |= group[0]
            measurements |= group[1]
        groups.append((tracks, measurements))
    return [(np.array(sorted(tracks)), np.array(sorted(measurements))) for tracks, measurements in groups]


def _cluster_marginals(weights: Array, miss_weight: float) -> Array:
    """Return the marginals of one cluster, shape (t, m + 1).

    Summing event by event grows exponentially in the tracks. But all events that have used the same measurements,
    among those that later tracks may still take, go on alike: `ahead` sums over the choices of the tracks before one,
    `behind` over those from it on, both per such set (a bit mask).
    """
    choices = [[(int(j), float(row[j])) for j in np.flatnonzero(row)] for row in weights]
    still_wanted = [0] * (len(choices) + 1)
    for i in reversed(range(len(choices))):
        still_wanted[i] = still_wanted[i + 1] | sum(1 << j for j, _ in choices[i])
    ahead = _sums_ahead(choices, still_wanted, miss_weight)
    beta = np.zeros((weights.shape[0], weights.shape[1] + 1))
    behind = {0: 1.0}
    for i in reversed(range(len(choices))):
        here: dict[int, float] = {}
        for used, weight in ahead[i].items():
            here[used] = 0.0
            for column, option, mask in _options(choices[i], used, miss_weight):
                rest = option * behind[mask & still_wanted[i + 1]]
                here[used] += rest
                beta[i, column] += weight * rest
        behind = here
    normalized: Array = beta / beta.sum(axis=1, keepdims=True)
    return normalized


def _sums_ahead(
    choices: list[list[tuple[int, float]]], still_wanted: list[int], miss_weight: float
) -> list[dict[int, float]]:
    """Return, for each track, the summed weight of what the tracks before it may have done, by measurements used."""
    ahead = [{0: 1.0}]
    for i, choice in enumerate(choices):
        after: dict[int, float] = {}
        for used, weight in ahead[i].items():
            for _, option, mask in _options(choice, used, miss_weight):
                key = mask & still_wanted[i + 1]
                after[key] = after.get(key, 0.0) + weight * option
        ahead.append(after)
    return ahead


def _options(choice: list[tuple[int, float]], used: int, miss_weight: float) -> list[tuple[int, float, int]]:
    """Return what a track may do: column of beta, weight, measurements used afterwards."""
    free = [(j + 1, weight, used | 1 << j) for j, weight in choice if not used >> j & 1]
    return [(0, miss_weight, used), *free]
