"""Whether a scan fits to a pose, and whether it fits better to another."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from han_bullet.geometry import Pose2D, wrap_angle
from han_bullet.localization.beams import Beams
from han_bullet.localization.likelihood_field import LikelihoodField

BEAMS = 180  # of a scan, at most
DEVIATION = 0.05  # of the beams' ends [m]
EXPLAINED, BLOCKED = 0.3, 0.1  # a scan fits that has this share of beams at surfaces or more, and through them or less
APART = 0.3, math.radians(10.0)  # poses [m] and [rad] that are so far apart are different ones
BETTER = 15.0  # a pose is clearly better by so much log-likelihood: about five beams that end at surfaces or do not


@dataclass(frozen=True)
class Fit:
    """How well a scan fits to a pose.

    Attributes:
        pose: In the world.
        log_likelihood: Of the scan's beams.
        explained: Share of the beams that end at the map's surfaces, or nowhere as they should.
        blocked: Share of the beams that would have gone through the map's surfaces.
    """

    pose: Pose2D
    log_likelihood: float
    explained: float
    blocked: float

    @classmethod
    def of(cls, pose: Pose2D, beams: Beams, field: LikelihoodField) -> Fit:
        """Compare a scan with what the map has around a pose."""
        some = beams.some(BEAMS)
        logs, hits, blocked = field.likelihoods(np.array([[pose.x, pose.y, pose.yaw]]), some, DEVIATION)
        count = max(len(some.returned), 1)
        return cls(pose, float(logs[0]), float(hits[0]) / count, float(blocked[0]) / count)

    @property
    def good(self) -> bool:
        """Tell whether enough beams are explained; beams that end early, at people and boxes, need no explanation."""
        return self.explained >= EXPLAINED and self.blocked <= BLOCKED

    def clearly_better_than(self, other: Fit) -> bool:
        """Tell whether this is another pose, and the scan clearly speaks for it."""
        return differ(self.pose, other.pose) and self.log_likelihood - other.log_likelihood > BETTER


def differ(one: Pose2D, other: Pose2D) -> bool:
    """Tell whether poses are so far apart that they are different ones."""
    return one.distance_to(other.position) > APART[0] or abs(wrap_angle(one.yaw - other.yaw)) > APART[1]


def apart(poses: Iterable[Pose2D], most: int) -> list[Pose2D]:
    """Return the first different poses, so many at most: without those that are nearly the same as an earlier one."""
    kept: list[Pose2D] = []
    for pose in poses:
        if len(kept) == most:
            break
        if all(differ(pose, other) for other in kept):
            kept.append(pose)
    return kept
