"""The contract of the tallies: each counts a group of a run's numbers, and defines them where it counts them.

Thresholds that more than one tally needs stand here; the definitions quote them.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from han_bullet.episode import Tick
from han_bullet.messages import TruePerson

Value = float | int | str | bool | None

STILL_SPEED = 0.05  # [m/s]: below it robot and people count as standing; ten times the jitter of a held base
PERSON_RADIUS = 0.25  # [m] of a person's body disc, as in the costmap
TIME_SLACK = 1e-6  # [s] for comparing sums of control periods


@dataclass(frozen=True)
class Definition:
    """What a metric measures.

    Attributes:
        unit: SI, "1" for counts and shares, empty for words.
        text: Thresholds, between centres or surfaces, from when to when, when there is no value; the source's key.
        better: Which way is better, empty where neither is.
        elsewhere: What other programs and papers call it, and how theirs differs; empty where none has it.
        headline: Whether a person wants to see it after every run.
    """

    unit: str
    text: str
    better: Literal["lower", "higher", ""] = ""
    elsewhere: str = ""
    headline: bool = False

    @property
    def statement(self) -> str:
        """Return the text with the polarity."""
        return f"{self.text}; {self.better} is better" if self.better else self.text


Definitions = Mapping[str, Definition]


class Tally(ABC):
    """A group of numbers that grows with every tick.

    Attributes:
        group: Heading under which a person looks for them.
        definitions: One of each metric, by name; metrics of one person or device carry its name behind a dot.
    """

    group: ClassVar[Literal["task", "motion", "people", "perception"]]
    definitions: ClassVar[Definitions]

    @abstractmethod
    def record(self, tick: Tick) -> None:
        """Take note of one tick."""

    @abstractmethod
    def values(self) -> dict[str, Value]:
        """Return what has been counted so far, by metric name."""


def root_mean_square(errors: Sequence[float]) -> float | None:
    """Return the root mean square of errors; None of none."""
    return float(np.sqrt(np.mean(np.square(errors)))) if errors else None


def person_walks(person: TruePerson) -> bool:
    """Tell whether a true person moves at more than `STILL_SPEED`."""
    return math.hypot(*person.velocity_in_world) > STILL_SPEED
