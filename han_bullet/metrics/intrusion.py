"""How deep the robot was in people's personal space, by the costs of our layers and by Kirby's Gaussian."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

from han_bullet.episode import Tick
from han_bullet.geometry import Array, rotated
from han_bullet.messages import Posture, TruePerson
from han_bullet.metrics.tally import Definition, Definitions, Tally, Value

PERSONAL_SPACE = 0.5  # of g1 or g2, whose peak at the person is 1
WALKING_DEVIATION = 0.8  # [m] ahead of a walking person, at least; [s] times their speed above 1 s [Kirby2010]
STILL_DEVIATION = 0.56  # [m]: falls to 0.1 at 1.2 m, the edge of Hall's personal distance [Hall1966]
LEAST_DEVIATION = 0.5  # [m] ahead of a person in Kirby's Gaussian [Kirby2010]
LOOK_AHEAD = 2.0  # [s] of a person's speed in it [Kirby2010]


def asymmetric_gaussian(person: TruePerson, point_in_world: Array, ahead: float, side: float, rear: float) -> float:
    """Return exp(-u^2 / (2 b^2) - v^2 / (2 side^2)), b = ahead or rear, in (0, 1]: 1 at the person [Kirby2010].

    Args:
        person: Of the peak; their yaw is the direction of u, whatever their velocity is.
        point_in_world: Shape (2,) [m].
        ahead: Deviation [m] where u > 0.
        side: Deviation across [m].
        rear: Deviation [m] where u <= 0.
    """
    pose = person.pose_in_world
    u, v = rotated(float(point_in_world[0]) - pose.x, float(point_in_world[1]) - pose.y, -pose.yaw)
    return math.exp(-0.5 * (u / (ahead if u > 0.0 else rear)) ** 2 - 0.5 * (v / side) ** 2)


def personal_space(person: TruePerson, point_in_world: Array) -> float:
    """Return how deep a point, (2,) [m], lies in a person's personal space: g1 or g2, in [0, 1] [Mateus2019].

    Walking (g1): B ahead, 2B/3 beside, B/2 behind, B = max(speed, 0.8). Otherwise (g2): 0.56 m all around.
    """
    if person.posture is not Posture.WALKING:
        return asymmetric_gaussian(person, point_in_world, STILL_DEVIATION, STILL_DEVIATION, STILL_DEVIATION)
    ahead = max(math.hypot(*person.velocity_in_world), WALKING_DEVIATION)
    return asymmetric_gaussian(person, point_in_world, ahead, 2.0 * ahead / 3.0, 0.5 * ahead)


def kirbys_gaussian(person: TruePerson, point_in_world: Array) -> float:
    """Return how deep a point, (2,) [m], intrudes on a person, in (0, 1], 1 at the person [Kirby2010].

    Deviations: sigma_h = max(2 s speed, 0.5 m) ahead, 2/3 sigma_h beside, 1/2 sigma_h behind.
    """
    ahead = max(LOOK_AHEAD * math.hypot(*person.velocity_in_world), LEAST_DEVIATION)
    return asymmetric_gaussian(person, point_in_world, ahead, 2.0 * ahead / 3.0, 0.5 * ahead)


class IntrusionTally(Tally):
    """How deep the robot was in personal spaces.

    Args:
        people: Names, for metrics that exist also where nothing was recorded.
    """

    group = "people"
    definitions: ClassVar[Definitions] = {
        "personal_space_share": Definition(
            "1",
            f"share of ticks in which the robot's centre has g > {PERSONAL_SPACE:g} for somebody, g being the personal "
            "space cost (g1 walking, g2 otherwise, peak 1) of the true person [Mateus2019]",
            "lower",
            "Francis2023: SC, the share outside a distance: another shape, and higher is better",
            headline=True,
        ),
        "personal_space_intrusion": Definition(
            "1",
            "mean over ticks of the largest g over people at the robot's centre (behind a dot, of that person alone; 0 "
            "without people): Kirby's Gaussian about the true person, 1 at their centre, sigma_h = max("
            f"{LOOK_AHEAD:g} s * speed, {LEAST_DEVIATION:g} m) ahead of their yaw, 2/3 sigma_h beside, 1/2 sigma_h "
            "behind [Kirby2010]",
            "lower",
            "SRPB: personal_space_intrusions, there an intrusion from 0.5 on",
            headline=True,
        ),
    }

    def __init__(self, people: Sequence[str]) -> None:
        self._ticks = 0
        self._inside = 0
        self._sum = 0.0
        self._sums = dict.fromkeys(people, 0.0)

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        robot = tick.truth.pose_robot_in_world.position
        depths = {person.name: kirbys_gaussian(person, robot) for person in tick.truth.people}
        for name, depth in depths.items():
            self._sums[name] += depth
        self._sum += max(depths.values(), default=0.0)
        self._inside += any(personal_space(person, robot) > PERSONAL_SPACE for person in tick.truth.people)
        self._ticks += 1

    def values(self) -> dict[str, Value]:
        """Return the share of time inside and the mean depths."""
        sums = {
            "personal_space_share": self._inside,
            "personal_space_intrusion": self._sum,
            **{f"personal_space_intrusion.{name}": depth for name, depth in self._sums.items()},
        }
        return {name: total / self._ticks if self._ticks else None for name, total in sums.items()}
