"""Who is who: confirmed tracks and foot points paired with the true people."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from han_bullet.geometry import Array
from han_bullet.messages import TrackedPerson, TruePerson

MATCH_WITHIN = 1.0  # [m] between a track or a foot point and a true person; two people abreast are about that far apart
CUT_OFF = 1.0  # [m], c of OSPA
ORDER = 2.0  # p of OSPA

MATCHED = (
    f"matched: paired in the assignment of confirmed tracks to true people that has most pairs within {MATCH_WITHIN:g} "
    "m between the centres and then the least sum of distances, anew at every tick"
)


@dataclass(frozen=True)
class Perceived:
    """What the robot believed of people at one tick, beside the truth.

    Attributes:
        time: [s].
        people: The true ones.
        tracks: The confirmed ones.
        pairs: Row of a track and of the person it is matched to.
        distances: Between all tracks and people, shape (tracks, people) [m].
        shown: Whether the newest frame of some camera shows a person, shape (people,).
        with_cameras: Whether a frame has come at all.
    """

    time: float
    people: tuple[TruePerson, ...]
    tracks: tuple[TrackedPerson, ...]
    pairs: tuple[tuple[int, int], ...]
    distances: Array
    shown: NDArray[np.bool_]
    with_cameras: bool

    @property
    def counted(self) -> NDArray[np.bool_]:
        """Return who can be asked for, shape (people,): whom a camera shows; without cameras, everybody."""
        return self.shown if self.with_cameras else np.ones(len(self.people), bool)

    def matched(self) -> list[tuple[TrackedPerson, TruePerson]]:
        """Return the pairs themselves."""
        return [(self.tracks[i], self.people[j]) for i, j in self.pairs]

    def unmatched_tracks(self) -> list[int]:
        """Return the rows of tracks without a person of their own."""
        taken = {track for track, _ in self.pairs}
        return [i for i in range(len(self.tracks)) if i not in taken]


def match(positions: Array, true_positions: Array) -> list[tuple[int, int]]:
    """Pair tracks with people: as many pairs within `MATCH_WITHIN` as can be, of the least sum of distances.

    Args:
        positions: Of the tracks, shape (n, 2) [m].
        true_positions: Of the people, shape (m, 2) [m].

    Returns:
        (track, person) index pairs, ordered by track; each index at most once.
    """
    return match_distances(distances_between(positions, true_positions))


def match_distances(distances: Array) -> list[tuple[int, int]]:
    """Return the same for known distances, shape (n, m) [m]."""
    near = distances <= MATCH_WITHIN
    never = 1.0 + MATCH_WITHIN * (min(distances.shape) + 1)  # dearer than any number of allowed pairs
    rows, columns = linear_sum_assignment(np.where(near, distances, never))
    return [(int(i), int(j)) for i, j in zip(rows, columns, strict=True) if near[i, j]]


def distances_between(first: Array, second: Array) -> Array:
    """Return all distances, shape (n, m) [m], between points of shapes (n, 2) and (m, 2) [m]."""
    difference = first.reshape(-1, 1, 2) - second.reshape(1, -1, 2)
    return np.hypot(difference[..., 0], difference[..., 1])


def ospa(positions: Array, true_positions: Array, cut_off: float = CUT_OFF, order: float = ORDER) -> float:
    """Return the optimal subpattern assignment distance [m] of two sets of points [Schuhmacher2008].

    ((min over assignments of sum min(d, c)^p + c^p |n - m|) / max(n, m))^(1/p), and 0 of two empty sets.

    Args:
        positions: Shape (n, 2) [m].
        true_positions: Shape (m, 2) [m].
        cut_off: c [m], what a missing or superfluous point costs.
        order: p.
    """
    return ospa_of_distances(distances_between(positions, true_positions), cut_off, order)


def ospa_of_distances(distances: Array, cut_off: float = CUT_OFF, order: float = ORDER) -> float:
    """Return the same for known distances, shape (n, m) [m]."""
    most = max(distances.shape)
    if most == 0:
        return 0.0
    costs = np.minimum(distances, cut_off) ** order
    paired = costs[linear_sum_assignment(costs)].sum()
    alone = cut_off**order * abs(distances.shape[0] - distances.shape[1])
    return float(((paired + alone) / most) ** (1.0 / order))
