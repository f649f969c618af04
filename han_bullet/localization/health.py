"""Notice that the robot is not where it believes: somebody carried it, or it went astray."""

from __future__ import annotations

import itertools
import math
from collections import deque
from collections.abc import Callable, Iterator

import numpy as np

from han_bullet.geometry import Array, Pose2D
from han_bullet.localization.beams import Beams
from han_bullet.localization.fit import BETTER, Fit, apart, differ
from han_bullet.localization.likelihood_field import LikelihoodField
from han_bullet.localization.scan_matching import ScanMatcher, information_of

ALTERNATIVES = 100  # poses that are tried beside the believed one
SPREAD = np.array([0.7, 0.7, math.radians(20.0)])  # [m], [m], [rad]
BEAMS, DEVIATION = 60, 0.15  # with which they are tried; [m]
MATCHED = 4  # of these, different ones
VICINITY = information_of(np.diag([0.3, 0.3, math.radians(6.0)]) ** 2)  # in which each is matched
TIME_CONSTANT = 0.4  # of the smoothing [s]
LONGEST_STEP = 0.1  # that one scan counts for [s]: a single one after a gap must not decide
SUSPECT = 0.5  # smoothed share of bad scans
WAITING = 20  # scans that nobody has looked at closely, at most


class Health:
    """Judge scan by scan whether the pose still stands.

    People and things that are new on the floor make beams end early, from every pose alike: no other pose explains the
    scan better. After the robot was carried away, another one does, or beams go through walls.
    """

    def __init__(self, field: LikelihoodField, matcher: ScanMatcher, generator: np.random.Generator) -> None:
        self._field = field
        self._matcher = matcher
        self._generator = generator
        self._bad, self._time = 0.0, math.inf
        # Scans that wait for a closer look: their shares, and how to. Older ones share less than a hundredth in all.
        self._waiting: deque[tuple[float, Callable[[], bool]]] = deque(maxlen=WAITING)

    def lost(self, time: float, pose: Pose2D, beams: Beams) -> bool:
        """Take in a scan of a time [s] and the pose that was matched to it; tell whether the pose is to be doubted.

        A scan that needs a closer look gets it only once the answer depends on it, the last one first: while the robot
        knows where it is, that is little more than half.
        """
        keep = math.exp(-min(max(time - self._time, 0.0), LONGEST_STEP) / TIME_CONSTANT)
        self._bad, self._time = keep * self._bad, time
        self._waiting = deque([(keep * share, judge) for share, judge in self._waiting], WAITING)
        speaks_against = self._judged(pose, beams)
        if callable(speaks_against):
            self._waiting.append((1.0 - keep, speaks_against))
        else:
            self._bad += (1.0 - keep) * speaks_against
        while self._waiting and self._bad + sum(share for share, _ in self._waiting) > SUSPECT:
            share, judge = self._waiting.pop()
            self._bad += share * judge()
        return self._bad > SUSPECT

    def _judged(self, pose: Pose2D, beams: Beams) -> bool | Callable[[], bool]:
        """Return whether a scan speaks against a pose, or how to tell."""
        believed = Fit.of(pose, beams, self._field)
        if not believed.good:
            return True
        if believed.log_likelihood > -BETTER:
            return False  # no pose could be clearly better, since no beam has a likelihood of more than 1
        offsets = SPREAD * self._generator.normal(size=(ALTERNATIVES, 3))
        offsets[::2, 2] = 0.0  # who is pushed need not turn, and along a corridor only those who face right fit
        return lambda: any(
            Fit.of(other, beams, self._field).clearly_better_than(believed)
            for other in self._alternatives(pose, offsets, beams)
            if differ(other, pose)
        )

    def _alternatives(self, pose: Pose2D, offsets: Array, beams: Beams) -> Iterator[Pose2D]:
        """Return the most likely of poses around, by offsets (n, 3) [m] and [rad], each matched to the scan."""
        tried: Array = np.array([pose.x, pose.y, pose.yaw]) + offsets
        few = beams.some(BEAMS)
        logs, _, _ = self._field.likelihoods(tried, few, DEVIATION)
        likely = (Pose2D(*tried[k].tolist()) for k in np.argsort(-logs))
        different = apart(itertools.chain([pose], likely), 1 + MATCHED)[1:]
        return (self._matcher.most_likely(one, VICINITY, few) for one in different)
