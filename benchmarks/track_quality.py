"""How well tracks agree with the people who were there: OSPA and ID switches."""

from collections import defaultdict

import numpy as np
from scipy.optimize import linear_sum_assignment

from han_bullet.geometry import Array
from han_bullet.perception_tally import IdSwitches, distances_between, match

CUT_OFF = 1.0  # [m], c
ORDER = 2.0  # p


def ospa(positions: Array, true_positions: Array, cut_off: float = CUT_OFF, order: float = ORDER) -> float:
    """Return the optimal subpattern assignment distance [m] of two sets of points.

    ((min over assignments of sum min(d, c)^p + c^p |n - m|) / max(n, m))^(1/p), and 0 of two empty sets. By D.
    Schuhmacher, B.-T. Vo, B.-N. Vo: A consistent metric for performance evaluation of multi-object filters. IEEE
    Transactions on Signal Processing 56(8), 2008.

    Args:
        positions: Shape (n, 2) [m].
        true_positions: Shape (m, 2) [m].
        cut_off: c [m], what a missing or superfluous point costs.
        order: p.
    """
    most = max(len(positions), len(true_positions))
    if most == 0:
        return 0.0
    costs = np.minimum(distances_between(positions, true_positions), cut_off) ** order
    paired = costs[linear_sum_assignment(costs)].sum()
    alone = cut_off**order * abs(len(positions) - len(true_positions))
    return float(((paired + alone) / most) ** (1.0 / order))


class TrackQuality:
    """OSPA of every scan, and the ID switches of all people so far.

    Attributes:
        ospa: One value per scan [m].
    """

    def __init__(self) -> None:
        self.ospa: list[float] = []
        self._switches: dict[int, IdSwitches] = defaultdict(IdSwitches)

    @property
    def id_switches(self) -> int:
        """Return how often a person was matched to another id than at their previous match."""
        return sum(one.count for one in self._switches.values())

    def record(self, tracks: dict[int, Array], true_positions: Array) -> None:
        """Take note of one scan: positions, shape (2,) [m], by id, and those of the people, shape (m, 2) [m]."""
        ids, positions = list(tracks), np.array(list(tracks.values())).reshape(-1, 2)
        self.ospa.append(ospa(positions, true_positions))
        for track, person in match(positions, true_positions):
            self._switches[person].update(ids[track])
