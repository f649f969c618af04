"""The rays of a laser scan, as seen from the robot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from han_bullet.geometry import Array, Pose2D
from han_bullet.messages import LaserScan


@dataclass(frozen=True, eq=False)
class Beams:
    """Straight lines from the scanner, free up to their ends.

    Attributes:
        origin_in_body: Where the scanner is, shape (2,) [m].
        ends_in_body: Where each beam ends, shape (n, 2) [m].
        returned: Whether something is at the end; else the beam went as far as it reaches, shape (n,).
    """

    origin_in_body: Array
    ends_in_body: Array
    returned: NDArray[np.bool_]

    @classmethod
    def of_scan(cls, scan: LaserScan, scanner_in_body: Pose2D) -> Beams:
        """Take the rays that measured something, or measured that nothing is there."""
        ranges = np.asarray(scan.ranges, float)
        angles = scan.angles
        valid = ranges >= scan.range_min  # NaN is none
        returned = ranges[valid] <= scan.range_max
        reach = np.minimum(ranges[valid], scan.range_max)
        ends = reach[:, None] * np.column_stack([np.cos(angles[valid]), np.sin(angles[valid])])
        return cls(scanner_in_body.position, scanner_in_body.to_world(ends), returned)

    def some(self, at_most: int) -> Beams:
        """Return every k-th beam, so that there are not more than wanted."""
        step = -(-len(self.returned) // at_most) or 1
        return Beams(self.origin_in_body, self.ends_in_body[::step], self.returned[::step])
