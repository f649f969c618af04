"""How well tracks agree with the people who were there: OSPA and ID switches."""

from collections import defaultdict

import numpy as np

from han_bullet.geometry import Array
from han_bullet.metrics.perceived import match, ospa
from han_bullet.metrics.perception_part import IdSwitches


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
