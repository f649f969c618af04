"""How near the robot came to people, and in whose zone it was how long."""

from __future__ import annotations

import bisect
import math
from collections.abc import Sequence
from typing import ClassVar

from han_bullet.episode import Tick
from han_bullet.metrics.tally import PERSON_RADIUS, Definition, Definitions, Tally, Value

ZONES = {"intimate": 0.45, "personal": 1.2, "social": 3.6, "public": math.inf}  # [m], where each ends [Hall1966]
_ENDS = tuple(ZONES.values())

_SURFACES = f"centres less the robot's radius and {PERSON_RADIUS:g} m of person"


def _zone(name: str) -> str:
    ends = ZONES[name]
    begins = max((end for end in _ENDS if end < ends), default=0.0)
    upper, alone = (f"{ends:g}", "") if math.isfinite(ends) else ("infinity", "; 1 without people")
    return (
        f"share of ticks in which the surface of the nearest person is [{begins:g}, {upper}) m from the robot's "
        f"({_SURFACES}; overlap counts as 0){alone}; the four zones sum to 1 [Hall1966]"
    )


class DistanceTally(Tally):
    """How near the robot came to each person, and for how long to anybody.

    Args:
        people: Names, for metrics that exist also where nothing was recorded.
        robot_radius: Of the footprint [m].
    """

    group = "people"
    definitions: ClassVar[Definitions] = {
        "minimum_distance": Definition(
            "m",
            "smallest true distance between the centres of robot and person",
            "higher",
            "Francis2023: DH_min; SocNavBench: closest_pedestrian_distance",
            headline=True,
        ),
        "minimum_gap": Definition(
            "m",
            f"smallest true distance between the surfaces: {_SURFACES}; negative where the discs overlap",
            "higher",
            "HuNav: minimum_distance_to_people, in one version of the robot's surface from the person's centre",
        ),
        "intimate_zone_share": Definition(
            "1", _zone("intimate"), "lower", "HuNav: intimate_space_intrusions, in per cent", headline=True
        ),
        "personal_zone_share": Definition(
            "1", _zone("personal"), "lower", "HuNav: personal_space_intrusions, in per cent", headline=True
        ),
        "social_zone_share": Definition("1", _zone("social"), elsewhere="HuNav: social_space_intrusions, in per cent"),
        "public_zone_share": Definition("1", _zone("public")),
    }

    def __init__(self, people: Sequence[str], robot_radius: float) -> None:
        self._nearest = dict.fromkeys(people, math.inf)
        self._reach = robot_radius + PERSON_RADIUS
        self._ticks = [0] * len(ZONES)

    def record(self, tick: Tick) -> None:
        """Take note of one tick."""
        robot = tick.truth.pose_robot_in_world.position
        distances = {person.name: person.pose_in_world.distance_to(robot) for person in tick.truth.people}
        for name, distance in distances.items():
            self._nearest[name] = min(self._nearest[name], distance)
        gap = max(0.0, min(distances.values(), default=math.inf) - self._reach)
        self._ticks[min(bisect.bisect_right(_ENDS, gap), len(ZONES) - 1)] += 1

    def values(self) -> dict[str, Value]:
        """Return distances and shares of time."""
        values: dict[str, Value] = {}
        for name, distance in self._nearest.items():
            values[f"minimum_distance.{name}"] = distance
            values[f"minimum_gap.{name}"] = distance - self._reach
        total = sum(self._ticks)
        for zone, ticks in zip(ZONES, self._ticks, strict=True):
            values[f"{zone}_zone_share"] = ticks / total if total else None
        return values
