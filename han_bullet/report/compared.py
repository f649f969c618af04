"""Which figures of a sweep are compared, and how those of several people become one per run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from han_bullet.metrics.tally import Value
from han_bullet.report.sweep_files import SweepRow

Numbers = Sequence[float]


@dataclass(frozen=True)
class Figure:
    """A figure that every run has once, or not at all.

    Attributes:
        label: For readers, with the unit.
        definition: What it is; of a metric, see the page of a run.
        value: Of a row; None where the run gives none.
        better: Which way is better, "less", "more", or "" where that depends.
        is_share: Whether it is shown in per cent.
    """

    label: str
    definition: str
    value: Callable[[SweepRow], float | None]
    better: Literal["less", "more", ""] = "less"
    is_share: bool = False


def _numbers(values: Iterable[Value]) -> list[float]:
    return [float(value) for value in values if isinstance(value, int | float)]


def _of(name: str, together: Callable[[Numbers], float]) -> Callable[[SweepRow], float | None]:
    """Return what reads a metric from a row, that of several people or devices joined to one number."""

    def value(row: SweepRow) -> float | None:
        numbers = _numbers(row.people_values(name))
        return together(numbers) if numbers else None

    return value


def _mean(numbers: Numbers) -> float:
    return sum(numbers) / len(numbers)


def _left(row: SweepRow) -> float | None:
    """Return the share of overtaken people who were passed on their left."""
    sides = [side for side in row.people_values("overtaking_side") if side in ("left", "right")]
    return _mean([float(side == "left") for side in sides]) if sides else None


def _arrived(row: SweepRow) -> float | None:
    return None if row.error else float(row.outcome == "arrived")


def _passed(row: SweepRow) -> float:
    return float(row.passed and row.error is None)


def minimum_distances(rows: Iterable[SweepRow]) -> dict[str, Figure]:
    """Return the smallest distance to each person that occurs in some rows, by the person's name."""
    prefix = "minimum_distance."
    names = dict.fromkeys(name.removeprefix(prefix) for row in rows for name in row.metrics if name.startswith(prefix))
    return {name: _minimum_distance(name) for name in names}


def _minimum_distance(person: str) -> Figure:
    def value(row: SweepRow) -> float | None:
        found = row.metrics.get(f"minimum_distance.{person}")
        return float(found) if isinstance(found, int | float) else None

    definition = f"smallest true distance between the centres of the robot and {person}"
    return Figure(f"minimum distance to {person} [m]", definition, value, "more")


COMPARED: tuple[Figure, ...] = (
    Figure("all expectations met", "share of runs that met every expectation", _passed, "more", is_share=True),
    Figure("arrived", "share of runs that fulfilled their task", _arrived, "more", is_share=True),
    Figure("time to goal [s]", "of runs that arrived in both variants", _of("time_to_goal", max)),
    Figure("path length [m]", "length of the robot's true way", _of("path_length", max), ""),
    Figure("distance when level [m]", "from the nearest walker overtaken", _of("distance_when_level", min), "more"),
    Figure("overtaken on the left", "share of overtaken walkers passed on their left", _left, "", is_share=True),
    Figure("time in personal space", "with a cost g above 0.5", _of("personal_space_share", max), is_share=True),
    Figure("intrusion", "mean of Kirby's Gaussian at the robot", _of("personal_space_intrusion", max)),
    Figure("contacts with people", "number of separate contacts", _of("contacts_person", max)),
    Figure("behind the seated", "largest visibility cost g3 at the robot's centre", _of("behind_seated", max)),
    Figure("between viewer and TV, on [s]", "time in that disc while the device is on", _of("transit_time_on", max)),
    Figure("time until a new plan [s]", "from a device going on to a plan that knows", _of("replan_delay", max)),
    Figure("hand-over bearing [rad]", "off the person's front at the stop", _of("hand_over_bearing", max)),
    Figure("stalled time [s]", "time standing after the start and before arrival", _of("stalled_time", max)),
    Figure("heading change [rad]", "sum of all turns", _of("cumulative_heading_change", max), ""),
    Figure("people tracked", "mean over people of tracked_share", _of("tracked_share", _mean), "more", is_share=True),
    Figure("error of tracks [m]", "root mean square distance from the true person", _of("person_position_rmse", max)),
    Figure("MOTA", "of people shown by some camera's newest frame", _of("mota", min), "more"),
    Figure("OSPA [m]", "mean over ticks, order 2, cut-off 1 m", _of("ospa", max)),
    Figure("id switches", "how often people changed their track's id", _of("id_switches", max)),
    Figure("phantom time [s]", "time of tracks without a person", _of("phantom_time_total", max)),
    Figure("false detections per frame", "far from everybody", _of("false_detections_per_frame", max)),
)
