"""Find the robot anywhere on the map: particles say where it may be, scan matching says which of these places fits."""

from __future__ import annotations

import math

import numpy as np

from han_bullet.geometry import Pose2D
from han_bullet.localization.beams import Beams
from han_bullet.localization.fit import Fit, apart, differ
from han_bullet.localization.likelihood_field import LikelihoodField
from han_bullet.localization.monte_carlo import MonteCarlo
from han_bullet.localization.scan_matching import ScanMatcher

CANDIDATES = 24  # clusters, most of them parts of the same place
VICINITY = np.diag([0.3, 0.3, math.radians(15.0)]) ** 2  # of a cluster's mean, within which the pose is looked for
AGREEING = 3  # scans in a row that must find the same pose, and no other that fits nearly as well
AT_REST = 10  # scans after which only a robot that moves learns more; without end, chance would choose among equals
MOVED = 0.1, math.radians(5.0)  # [m], [rad]


class GlobalSearch:
    """Take in scans until all but one place are ruled out.

    Attributes:
        pose: The best so far.
        covariance: Of the pose; as long as it is not found, of all the places where the robot may be, shape (3, 3).
        found: Whether it is the only one.
    """

    def __init__(self, particles: MonteCarlo, field: LikelihoodField, matcher: ScanMatcher, believed: Pose2D) -> None:
        """Begin with scattered particles and what was believed before."""
        self._particles = particles
        self._field = field
        self._matcher = matcher
        self._since = Pose2D(0.0, 0.0, 0.0)
        self._scans_here = 0
        self._agreeing = 0
        # Places that fit as well as the best: only a scan rules one out, not chance in drawing particles.
        self._rivals: list[Pose2D] = []
        self.pose, self.covariance = believed, particles.covariance()
        self.found = False

    def move(self, step: Pose2D) -> None:
        """Go along with the odometry."""
        self._particles.move(step)
        self.pose = self.pose.compose(step)
        self._rivals = [rival.compose(step) for rival in self._rivals]
        self._since = self._since.compose(step)
        if math.hypot(self._since.x, self._since.y) > MOVED[0] or abs(self._since.yaw) > MOVED[1]:
            self._since, self._scans_here = Pose2D(0.0, 0.0, 0.0), 0

    def look(self, beams: Beams) -> None:
        """Take in a scan."""
        self._scans_here += 1
        if self._scans_here > AT_REST:
            return
        self._particles.weigh(beams)
        means = [Pose2D(*mean) for mean in self._particles.clusters(CANDIDATES).tolist()]
        matched = [self._matcher.match(mean, VICINITY, beams) for mean in [*self._rivals, *means]]
        fits = [Fit.of(pose, beams, self._field) for pose, _ in matched]
        best = max(range(len(fits)), key=lambda k: fits[k].log_likelihood)
        self._rivals = apart((fit.pose for fit in fits if not fits[best].clearly_better_than(fit)), CANDIDATES)
        alone = fits[best].good and not any(differ(rival, fits[best].pose) for rival in self._rivals)
        same = not differ(fits[best].pose, self.pose)
        self._agreeing = (self._agreeing + 1 if same else 1) if alone else 0
        self.found = self._agreeing >= AGREEING
        self.pose = fits[best].pose
        self.covariance = matched[best][1] if self.found else self._particles.covariance()
