"""Notice that the robot is not where it believes: somebody carried it, or it went astray."""

from __future__ import annotations

import math

import numpy as np

from han_bullet.geometry import Array, Pose2D
from han_bullet.localization.beams import Beams
from han_bullet.localization.fit import BETTER, Fit
from han_bullet.localization.likelihood_field import LikelihoodField
from han_bullet.localization.scan_matching import ScanMatcher

ALTERNATIVES = 100  # poses that are tried beside the believed one
SPREAD = np.array([0.7, 0.7, math.radians(20.0)])  # [m], [m], [rad]
BEAMS, DEVIATION = 45, 0.15  # with which they are tried; [m]
TIME_CONSTANT = 0.4  # of the smoothing [s]
SUSPECT = 0.5  # smoothed share of bad scans


class Health:
    """Judge scan by scan whether the pose still stands.

    People and things that are new on the floor make beams end early, from every pose alike: no other pose explains the
    scan better. After the robot was carried away, another one does, or beams go through walls.
    """

    def __init__(self, field: LikelihoodField, matcher: ScanMatcher, generator: np.random.Generator) -> None:
        self._field = field
        self._matcher = matcher
        self._generator = generator
        self._bad, self._time = 0.0, -math.inf

    def lost(self, time: float, pose: Pose2D, beams: Beams) -> bool:
        """Take in a scan of a time [s] and the pose that was matched to it; tell whether the pose is to be doubted."""
        bad = self._doubtful(pose, beams)
        keep = math.exp(-max(time - self._time, 0.0) / TIME_CONSTANT)
        if math.isinf(self._time):
            keep = 1.0
        self._bad, self._time = keep * self._bad + (1.0 - keep) * bad, time
        return self._bad > SUSPECT

    def _doubtful(self, pose: Pose2D, beams: Beams) -> bool:
        believed = Fit.of(pose, beams, self._field)
        if not believed.good:
            return True
        if believed.log_likelihood > -BETTER:
            return False  # no pose could be clearly better, since no beam has a likelihood of more than 1
        other = self._best_alternative(pose, beams)
        return Fit.of(other, beams, self._field).clearly_better_than(believed)

    def _best_alternative(self, pose: Pose2D, beams: Beams) -> Pose2D:
        centre = np.array([pose.x, pose.y, pose.yaw])
        tried: Array = centre + SPREAD * self._generator.normal(size=(ALTERNATIVES, 3))
        logs, _, _ = self._field.likelihoods(tried, beams.some(BEAMS), DEVIATION)
        best = tried[np.argmax(logs)]
        return self._matcher.match(Pose2D(*best.tolist()), np.diag((0.3 * SPREAD) ** 2), beams)[0]
