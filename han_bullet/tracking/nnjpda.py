"""Nearest neighbour joint probabilistic data association: exact marginals, then a hard choice [Fitzgerald1986]."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array
from han_bullet.tracking.association import Association, Gating, Pairs, take_best_first
from han_bullet.tracking.joint_events import pair_probabilities


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
        return take_best_first(beta[:, 1:], (beta[:, 1:] > 0.0) & (beta[:, 1:] >= beta[:, :1]))

    def marginals(self, gating: Gating) -> Array:
        """Return beta, shape (n, m + 1): column 0 "no measurement", column j + 1 measurement j; rows sum to 1."""
        log_ratios = self.log_weights(gating) - math.log(self.miss_weight)
        beta = np.zeros((log_ratios.shape[0], log_ratios.shape[1] + 1))
        for tracks, measurements in clusters(log_ratios > -np.inf):
            beta[np.ix_(tracks, measurements + 1)] = pair_probabilities(log_ratios[np.ix_(tracks, measurements)])
        beta[:, 0] = np.maximum(1.0 - beta.sum(axis=1), 0.0)
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
