"""The contract of what compares tracks and truth: each gets what one tick perceived, paired once for all."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

from han_bullet.metrics.perceived import Perceived
from han_bullet.metrics.tally import Definitions, Value


class PerceptionPart(ABC):
    """Some numbers about tracks; see `Tally` for the definitions."""

    definitions: ClassVar[Definitions]

    @abstractmethod
    def update(self, perceived: Perceived) -> None:
        """Take note of one tick."""

    @abstractmethod
    def values(self) -> dict[str, Value]:
        """Return what has been counted so far, by metric name."""


@dataclass
class IdSwitches:
    """How often one person is matched to another id than at their previous match."""

    count: int = 0
    last_id: int | None = None

    def update(self, track_id: int) -> bool:
        """Take note of the id that the person is matched to; tell whether it is another one."""
        switched = self.last_id is not None and self.last_id != track_id
        self.count += switched
        self.last_id = track_id
        return switched
